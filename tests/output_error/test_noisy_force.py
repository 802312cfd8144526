"""Noise in the record of a force shifts an estimate that takes it for a disturbance: the deviations hold the shift."""

import numpy as np

from symid import Log
from symid.axis import load_axis
from symid.codegen import load_generated
from symid.identification import Preparation
from symid.output_error import identify_output_error

TRUE = {"M": 5.0, "Fv": 20.0, "Fs": 6.0}
RATE = 500.0


def test_the_expected_shift_is_the_error():
    t, rng = np.arange(4000) / RATE, np.random.default_rng(8)
    s = 2j * np.pi * np.array([0.7, 2.3, 6.1, 13.0])
    tones = np.exp(np.outer(t, s) + 1j * np.array([0.3, 1.0, 2.0, 4.0]))
    q, v, a = (np.real(tones @ (0.1 * s ** (k - 1))) for k in range(3))
    F = TRUE["M"] * a + TRUE["Fv"] * v + TRUE["Fs"] * np.sign(v)
    noisy = {"q": q + 2e-5 * rng.standard_normal(t.size), "F": F + 12.0 * rng.standard_normal(t.size)}
    found = identify_output_error(
        load_axis("rigid_1m"),
        load_generated("rigid_1m"),
        Log.from_arrays(noisy, sampling_period=1 / RATE),
        preparation=Preparation(held=False),
        nominal=TRUE,
    )
    error = found.physical_parameters["M"] - TRUE["M"]
    assert error > 5 * found.fit.linear.standard_deviations[0]
    assert abs(found.fit.bias[0] - error) < 0.3 * error
    assert error < 1.5 * found.physical_deviations[0]
