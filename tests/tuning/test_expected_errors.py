"""Errors that are expected to first order, beside those of drawn noise."""

import numpy as np
import pytest

from benchmarks.tuning_grid import VALUES, clean_log
from symid import Preparation, load_axis, load_generated
from symid.tuning.total_errors import TotalErrors

DRAWS = 40  # the root mean square of one error scatters by 11 %


@pytest.mark.parametrize(
    ("axis", "measured", "settings"),
    [
        ("rigid_1m", ("q",), ((60.0, 3), (200.0, 1), (9.0, 10))),
        ("ballscrew_2m1s", ("qm", "ql"), ((60.0, 6), (200.0, 1))),
        ("ballscrew_2m1s", ("qm",), ((60.0, 6), (60.0, 1))),
    ],
)
def test_expected_errors_are_those_of_drawn_noise(axis, measured, settings):
    clean = clean_log(load_axis(axis), 1000.0, measured)
    noise = dict.fromkeys(measured, 1e-7) | {load_axis(axis).drive.signal: 2.0}
    errors = TotalErrors(load_generated(axis, measured), (clean,), noise, VALUES[axis], DRAWS, 700)
    late = {load_axis(axis).drive.signal: -1.25e-4}
    for cutoff, decimation in settings:
        chosen = Preparation(cutoff_hz=cutoff, decimation=decimation, late=late)
        np.testing.assert_allclose(errors.expected(chosen), errors.rms(chosen), rtol=0.35, atol=2e-5)


def test_noise_that_drowns_the_motion_loses_the_parameters():
    clean = clean_log(load_axis("rigid_1m"), 1000.0, ("q",))
    errors = TotalErrors(load_generated("rigid_1m"), (clean,), {"q": 1e-1, "F": 1e5}, VALUES["rigid_1m"], 1)
    assert np.all(errors.expected(Preparation(cutoff_hz=300.0)) > 0.5)
