"""Filters against those of scipy.signal: designs, settled states, runs, and every n-th sample."""

import importlib.machinery
import subprocess
import sys

import numpy as np
import pytest
import scipy

from symid.errors import SettingError
from symid.signal_processing.filtering import decimation_filter, kept_indices
from symid.signal_processing.sections import _loop, butterworth, chebyshev, run_sections, settled_states


@pytest.mark.parametrize("order", [1, 2, 3, 4, 7, 8])
@pytest.mark.parametrize("share", [0.003, 0.1, 0.5, 0.93])
def test_designs_have_the_response_of_scipys(order, share):
    frequency = np.concatenate([np.linspace(0.0, 2.0 * share, 50), np.linspace(0.0, 0.99, 50)]) * np.pi
    for own, other in (
        (butterworth(order, share), scipy.signal.butter(order, share, output="sos")),
        (chebyshev(order, 0.05, share), scipy.signal.cheby1(order, 0.05, share, output="sos")),
    ):
        responses = [scipy.signal.sosfreqz(sections, frequency)[1] for sections in (own, other)]
        assert own.shape == other.shape
        assert responses[0] == pytest.approx(responses[1], rel=1e-7, abs=1e-12)


def test_rows_run_as_in_scipy_from_settled_states():
    sections = chebyshev(8, 0.05, 0.2)
    x = np.random.default_rng(3).standard_normal((3, 500)).cumsum(axis=1)
    states = settled_states(sections)
    passed, behind = run_sections(sections, x, states * x[:, :1, None])
    expected, after = scipy.signal.sosfilt(
        sections, x, zi=scipy.signal.sosfilt_zi(sections)[:, None] * x[:, 0][None, :, None]
    )
    assert passed == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert behind == pytest.approx(after.swapaxes(0, 1), rel=1e-10, abs=1e-12)


def test_where_the_compiled_loop_of_scipy_has_moved_that_of_the_package_serves(monkeypatch):
    sections, x = butterworth(3, 0.2), np.random.default_rng(5).standard_normal((2, 300))
    states = settled_states(sections) * x[:, :1, None]
    passed, behind = run_sections(sections, x, states)
    monkeypatch.setattr(importlib.machinery, "EXTENSION_SUFFIXES", [])
    _loop.cache_clear()
    try:
        again, after = run_sections(sections, x, states)
    finally:
        _loop.cache_clear()
    assert again == pytest.approx(passed, rel=1e-12, abs=1e-12)
    assert after == pytest.approx(behind, rel=1e-12, abs=1e-12)


def test_a_filter_that_forgets_nothing_has_no_settled_state():
    with pytest.raises(SettingError, match="does not settle: raise it"):
        settled_states(butterworth(4, 1e-12))


@pytest.mark.parametrize("factor", [2, 8, 13, 64, 177])
@pytest.mark.parametrize("n_samples", [25, 600, 20_001])
def test_thinned_rows_are_samples_of_filtered_ones(factor, n_samples):
    rows = np.random.default_rng(4).standard_normal((4, n_samples)).cumsum(axis=1)
    rows[2] = 5.0
    sections = scipy.signal.cheby1(8, 0.05, 0.8 / factor, output="sos")
    whole = scipy.signal.sosfiltfilt(sections, rows, padtype="odd", padlen=24)
    for kept in (kept_indices(n_samples, factor), slice(n_samples // 3, n_samples - 5, factor)):
        thinned = decimation_filter(factor).apply_thinned(rows, kept)
        assert thinned == pytest.approx(whole[:, kept], abs=1e-9 * np.abs(rows).max())


def test_identification_starts_without_the_packages_that_are_slow_to_import(tmp_path):
    t = np.arange(2000) / 1000.0
    log = tmp_path / "log.csv"
    q, force = np.sin(9 * t), -405 * np.sin(9 * t) + 2 * np.sign(np.cos(9 * t)) + 9 * np.cos(9 * t)
    np.savetxt(log, np.column_stack([t, q, force]), delimiter=",", header="t,q,F", comments="")
    slow = "scipy.signal", "scipy.linalg", "scipy.stats", "sympy", "numba", "narwhals", "matplotlib", "joblib"
    program = (
        "import atexit, sys\n"
        f"atexit.register(lambda: print('loaded', [name for name in {slow} if name in sys.modules]))\n"
        "from symid.cli import main\n"
        "main()"
    )
    command = [sys.executable, "-c", program, "identify", "rigid_1m", str(log)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert "Fv" in done.stdout, done.stderr
    assert done.stdout.splitlines()[-1] == "loaded []"
