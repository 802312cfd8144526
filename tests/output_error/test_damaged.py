"""Damaged logs and logs of unequal rate: output error is right, or says that something is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.promise.faults import damaged
from benchmarks.promise.machines import draw_case
from symid import Log, Preparation, load_axis, load_generated
from symid.identification import identify_by_least_squares
from symid.identification.results.status import Status
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.output_error.fit_status import likelihood_status
from symid.simulation import chirp, plant_of, simulate, trapezoids, tuned_cascade

HELD = Preparation(held=True)

RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}


def noisy(log: Log, noise: dict[str, float], seed: int) -> Log:
    random = np.random.default_rng(seed)
    signals = {name: log[name] + std * random.standard_normal(log.n_samples) for name, std in noise.items()}
    return replace(log, signals={**log.signals, **signals})


def swept(values: dict[str, float], seed: int) -> Log:
    """A chirp of the rigid axis at 500 Hz, with noise in the record."""
    axis = load_axis("rigid_1m")
    reference = chirp(0.5, 15.0, 8.0, 0.01, sampling_period=2e-3)
    log = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q", bandwidth_hz=5.0)).log
    return noisy(log, {"q": 1e-7, "F": 1.0}, seed)


@pytest.fixture(scope="module")
def rigid() -> Log:
    return swept(RIGID, seed=1)


def identified(log: Log) -> OutputErrorIdentification:
    return identify_output_error(load_axis("rigid_1m"), load_generated("rigid_1m"), log, preparation=HELD)


@pytest.mark.parametrize(
    ("status", "expected"),
    [("not_physical", "not_physical"), ("recording", "recording"), ("undetermined", "ok"), ("biased", "ok")],
)
def test_faults_that_least_squares_finds_hold_where_samples_are_dense(
    rigid: Log, status: Status, expected: str
) -> None:
    found = identified(rigid)
    regression = identify_by_least_squares(load_generated("rigid_1m"), rigid, preparation=HELD)
    assert regression.status == "ok"
    judged = likelihood_status(found, replace(regression, status=status, message="its statement"))
    assert judged == (expected, "its statement" if expected != "ok" else "")
    simulated = replace(found, comparison=replace(found.comparison, force="simulated"))
    assert likelihood_status(simulated, replace(regression, status="not_physical"))[0] == "ok"


def test_least_squares_with_a_negative_mass_are_compared_where_samples_are_dense(rigid: Log) -> None:
    found = identified(rigid)
    regression = identify_by_least_squares(load_generated("rigid_1m"), rigid, preparation=HELD)
    (place,) = regression.physical
    values = place.parameters * np.array([-1.0, 1.0, 1.0])
    negative = replace(regression, physical=(replace(place, parameters=values),))
    status, message = likelihood_status(found, negative)
    assert (status, "differ in M (100" in message) == ("poor_fit", True)
    sparse = replace(found, comparison=replace(found.comparison, force="simulated"))
    assert likelihood_status(sparse, negative) == ("ok", "")
    far = replace(regression, physical=(replace(place, parameters=1.5 * place.parameters),))
    assert likelihood_status(sparse, far)[0] == "poor_fit"


def with_force(log: Log, force: np.ndarray) -> Log:
    return replace(log, signals={**log.signals, "F": force})


def test_an_undamaged_log_is_ok_and_right(rigid: Log) -> None:
    found = identified(rigid)
    assert found.status == "ok", found.message
    errors = [found.physical_parameters[name] - true for name, true in RIGID.items()]
    assert np.all(np.abs(errors) < 4 * found.physical_deviations)


def test_a_force_with_the_wrong_sign_is_no_result(rigid: Log) -> None:
    assert identified(with_force(rigid, -rigid["F"])).status != "ok"


def test_a_gain_that_changes_within_the_log_is_reported(rigid: Log) -> None:
    first = np.arange(rigid.n_samples) < 0.5 * rigid.n_samples
    found = identified(with_force(rigid, np.where(first, 1.0, 1.5) * rigid["F"]))
    assert found.status == "poor_fit"
    assert "parameters change within the logs" in found.message


def test_a_force_that_says_little_of_the_motion_is_reported(rigid: Log) -> None:
    """Its spectrum is that of a force, so that it shows no noise; only what it should move does not move so."""
    found = identified(with_force(rigid, np.roll(rigid["F"], rigid.n_samples // 2)))
    assert found.status != "ok"


def test_a_fast_and_a_slow_log_of_one_axis() -> None:
    """Each begins at its own solution; trials of both at once may end at a structure of nothing."""
    axis, model = load_axis("direct_2m1s"), load_generated("direct_2m1s", ("q2",))
    logs = []
    for rate in (2000.0, 250.0):
        moves = trapezoids(
            [0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / rate
        )
        log = simulate(axis, PAPER, moves, tuned_cascade(plant_of(axis, PAPER), "q2", bandwidth_hz=8.0)).log
        logs.append(noisy(log, {"q2": 1e-8, "Fm": 0.3}, seed=int(rate)))
    found = identify_output_error(axis, model, logs, preparation=HELD)
    assert found.status == "ok", found.message
    for name in ("Ms", "Ks", "Mm"):
        assert found.physical_parameters[name] == pytest.approx(PAPER[name], rel=0.02)


def test_logs_of_different_axes_are_distinguished(rigid: Log) -> None:
    heavier = swept(RIGID | {"M": 120.0}, seed=2)
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m")
    found = identify_output_error(axis, model, [rigid, heavier], preparation=HELD)
    assert found.status == "poor_fit"
    assert identify_output_error(axis, model, [rigid, rigid], preparation=HELD).status == "ok"


def test_a_lag_beside_white_innovations_is_reported() -> None:
    """A free delay takes most of the lag, and what is left biases the mass."""
    random = np.random.default_rng([731070, 9, 1])
    case = damaged(draw_case(random), random)
    half = {name: x[: x.size // 2] for name, x in case.signals.items()}
    log = Log.from_arrays(half, sampling_period=1 / case.rate)
    found = identify_output_error(load_axis(case.axis), load_generated(case.axis, case.measured), log)
    assert found.status == "timing"
    assert found.message.startswith("F lags")


@pytest.mark.parametrize("mass", [100.0, 112.0])
def test_logs_are_told_apart_where_one_has_another_payload(rigid: Log, mass: float) -> None:
    logs = [rigid, swept({**RIGID, "M": mass}, seed=2)]
    found = identify_output_error(load_axis("rigid_1m"), load_generated("rigid_1m"), logs, preparation=HELD)
    same = mass == RIGID["M"]
    assert found.status == ("ok" if same else "poor_fit"), found.message
    assert same or "differ between the logs" in found.message
