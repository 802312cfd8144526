"""Friction beside a drive, taken off its force: rows and their factors are linear in its level."""

import numpy as np
import pytest

import symid
from benchmarks.promise.machines import draw_case, draw_machine
from symid.identification.rows.coulomb import direction, factors_without
from symid.identification.rows.observation import observe
from symid.identification.rows.row_blocks import Run

LEVEL = 3.0
PREPARATION = symid.Preparation(cutoff_hz=30.0, decimation=4, trim=(400, 400), standstill=0.0, widening=4.0)


def log_of(force_less: float) -> symid.Log:
    """A motion of two sines, whose force has the friction of its direction less some of it."""
    t = np.arange(20_000) / 1000.0
    q = np.sin(9.0 * t) + 0.3 * np.sin(31.0 * t)
    sign = np.sign(9.0 * np.cos(9.0 * t) + 9.3 * np.cos(31.0 * t))
    force = np.cos(5.0 * t) + (LEVEL - force_less) * sign
    return symid.Log("made", 0.0, 1e-3, {"q2": q, "Fm": force})


def test_friction_taken_off_the_rows_is_friction_taken_off_the_recorded_force() -> None:
    model = symid.load_generated("direct_2m1s")
    taken = symid.Preparation(**{**vars(PREPARATION), "coulomb": (LEVEL,)})
    without = symid.Preparation(**{**vars(PREPARATION), "coulomb": ()})
    seen, cleaned = observe(model, log_of(0.0), taken), observe(model, log_of(LEVEL), without)
    column = model.law_columns[0][1]
    scale = np.abs(cleaned.W[0]).max(axis=0)
    np.testing.assert_allclose(seen.W[0] / scale, cleaned.W[0] / scale, atol=2e-3)
    given_back = cleaned.y[0] + LEVEL * cleaned.W[0][:, column]
    np.testing.assert_allclose(seen.y[0], given_back, atol=1e-3 * np.abs(given_back).max())


def test_factors_without_friction_are_those_of_the_rows_without() -> None:
    model = symid.load_generated("direct_2m1s")
    run = Run.of(model, log_of(0.0), PREPARATION, friction=True)
    (found,) = factors_without(model, run.factors(), (LEVEL,))
    seen = run.without((LEVEL,)).observation
    rows = np.column_stack([seen.W[0], seen.y[0]])
    assert found.rows == len(rows)
    norms = np.linalg.norm(rows, axis=0)
    scale = np.outer(norms, norms)
    np.testing.assert_allclose(found.R.T @ found.R / scale, rows.T @ rows / scale, atol=1e-12)


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [
        ([0.0, 0.0], [0.0, 0.0]),
        ([1.0, 2.0], [1.0, 1.0]),
        ([0.001, 1.0, 0.0, 1.0, 0.001], [1.0, 1.0, 1.0, 1.0, 1.0]),
        (
            [-0.001, 1.0, 0.001, 0.0, -0.001, 0.001, -1.0, -0.001],
            [-1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0],
        ),
    ],
)
def test_direction_turns_once_in_a_reversal(velocity: list[float], expected: list[float]) -> None:
    assert direction(np.array(velocity)).tolist() == expected


def test_friction_at_rest_does_not_reach_rows_of_a_differentiated_force():
    """Filters carry its unknown part further than that of a force as it is, and ends must be trimmed further."""
    case = draw_case(np.random.default_rng([50501, 61, 0]))
    log = symid.Log.from_arrays(case.signals, sampling_period=1 / case.rate)
    found = symid.identify(symid.load_generated(case.axis, case.measured), log)
    assert found.physical_parameters["Ms"] == pytest.approx(case.truth["Ms"], rel=0.004)


def test_stops_between_moves_are_no_reversals_there_and_back() -> None:
    """A velocity touches zero where one move follows another: friction there is not known. Ms was 2.6 % too large."""
    case = draw_machine("direct_2m1s", ("q2",), np.random.default_rng([40127, 3]))
    log = symid.Log.from_arrays(case.signals, sampling_period=1 / case.rate)
    found = symid.identify(symid.load_generated(case.axis, case.measured), log)
    assert found.status == "ok"
    assert found.physical_parameters["Ms"] == pytest.approx(case.truth["Ms"], rel=0.015)


def test_a_rest_within_a_trimmed_end_reaches_the_rows() -> None:
    t = np.arange(2000) / 1000.0
    q = np.where(t < 0.29, 0.0, 1.0 - np.cos(12.0 * (t - 0.29)))
    log = symid.Log("made", 0.0, 1e-3, {"q": q, "F": np.zeros_like(t)})
    settings = symid.Preparation(cutoff_hz=20.0, decimation=1, trim=(300, 300), widening=4.0)
    used = observe(symid.load_generated("rigid_1m"), log, settings).valid[0]
    assert not used[:35].any()
    assert used[60]
