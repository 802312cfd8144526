"""What is chosen from a log: bands by three transforms, as scipy's spectra give them one by one."""

import numpy as np
import pytest
from scipy import signal

from symid import Log, load_generated
from symid.identification.rows.bands import Spectra, coherent_band, noise_limited_band
from symid.signal_processing import derivatives

RIGID = load_generated("rigid_1m")


def noisy(samples: int) -> Log:
    draw, t = np.random.default_rng(4), np.arange(samples) / 1000
    q, a = np.zeros((2, samples))
    for w in (9.0, 40.0, 130.0, 300.0):
        q += 0.1 / w * np.sin(w * t)
        a -= 0.1 * w * np.sin(w * t)
    q += 1e-6 * draw.standard_normal(samples)
    return Log.from_arrays({"q": q, "F": 5 * a + draw.standard_normal(samples)}, sampling_period=1e-3)


@pytest.mark.parametrize("samples", [700, 3001, 20_000])
def test_spectra_are_those_of_scipy(samples: int) -> None:
    log = noisy(samples)
    found = Spectra.of(log, RIGID)
    length = 2 * (found.frequency.size - 1)
    if samples // 5 % 2:
        length += 1
    frequency, power = signal.welch(log["q"], fs=1000, nperseg=length)
    np.testing.assert_allclose(found.frequency, frequency)
    middle = slice(1, None)  # the mean is no motion
    np.testing.assert_allclose(
        found.power[middle] / found.power[middle].sum(), power[middle] / power[middle].sum(), rtol=1e-8
    )
    motion = derivatives(log["q"], log.sampling_period, 2)[1]
    _, expected = signal.coherence(log["F"], motion, fs=1000, nperseg=length)
    np.testing.assert_allclose(found.coherence, expected, rtol=1e-6, atol=1e-12)


def test_bands_follow_what_the_log_holds() -> None:
    log = noisy(20_000)
    assert 300 / (2 * np.pi) < coherent_band(log, RIGID) < 70
    assert noise_limited_band(log, RIGID) < 400
