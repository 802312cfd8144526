"""A model that ignores the force can predict smooth readings better than the machine with its noisy force does."""

import numpy as np
import pytest

from benchmarks.ok_promise import cases
from symid import Log, load_axis, load_generated
from symid.identification import Preparation
from symid.output_error import identify_output_error


def test_the_physical_minimum_near_least_squares_is_taken() -> None:
    _, case = next(iter(cases(1, 17, 260101, "undamaged")))
    log = Log.from_arrays({name: x[:800] for name, x in case.signals.items()}, sampling_period=1 / case.rate)
    found = identify_output_error(
        load_axis(case.axis),
        load_generated(case.axis, case.measured),
        log,
        preparation=Preparation(held=False),
    )
    assert found.status == "ok"
    error = np.abs(np.array([found.physical_parameters[name] - case.truth[name] for name in case.truth]))
    assert np.all(error < 3 * np.asarray(found.physical_deviations))
    assert found.physical_parameters["Kt"] == pytest.approx(case.truth["Kt"], rel=1e-3)
