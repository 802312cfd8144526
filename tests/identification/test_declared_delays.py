"""A delay that the axis declares of a sensor or a drive is taken off the log; what is passed over is reported."""

from typing import Any

import pytest

import symid
from symid import ActuatorDelay, ActuatorLag, ForceLimit, Preparation, load_axis
from symid.data import Log, LongLog
from symid.simulation import ClosedLoop, chirp, plant_of, simulate, tuned_cascade

TRUE = {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
PLAIN = load_axis("rigid_1m")
LATE = PLAIN.with_signal("q", noise=1e-8, delay=3e-3)
DECLARED = {"q": LATE, "F": PLAIN.with_signal("q", noise=1e-8).with_effect(ActuatorDelay(3e-3))}
REFERENCE = chirp(0.5, 5.0, 4.0, 0.01, sampling_period=1e-3)
SHORT = chirp(0.5, 5.0, 1.0, 0.01, sampling_period=1e-3)
"""Of what is simulated anew at every step of a search."""
CONTROLLER = tuned_cascade(plant_of(PLAIN, TRUE), "q", bandwidth_hz=10.0)


@pytest.fixture(scope="module")
def log() -> Log:
    return simulate(LATE, TRUE, REFERENCE, CONTROLLER).log


def loop_of(axis: symid.Axis, method: str) -> dict[str, Any]:
    return {"loop": ClosedLoop(axis, CONTROLLER, 1000.0)} if method == "loop" else {}


@pytest.mark.parametrize("method", ["wls", "iv", "oe", "loop"])
@pytest.mark.parametrize("signal", DECLARED)
def test_a_declared_delay_is_taken_off(signal: str, method: str) -> None:
    declared = DECLARED[signal]
    reference = SHORT if method == "loop" else REFERENCE
    log = simulate(declared, TRUE, reference, CONTROLLER).log
    settings = {"method": "oe" if method == "loop" else method, "preparation": Preparation(held=True)}
    found: Any = symid.identify(declared, log, **settings, **loop_of(declared, method))  # type: ignore[call-overload]
    assert found.status == "ok"
    assert found.physical_parameters == pytest.approx(TRUE, rel=2e-3)
    assert any(note.startswith(signal) and "3 ms late" in note for note in found.notes)
    assert not any("acts as if" in note for note in found.notes)
    without: Any = symid.identify(PLAIN, log, **settings, **loop_of(PLAIN, method))  # type: ignore[call-overload]
    assert without.status != "ok"
    assert without.physical_parameters != pytest.approx(TRUE, rel=0.05)


def test_a_given_delay_takes_the_place_of_the_declared_one(log: Log) -> None:
    found = symid.identify(LATE, log, preparation=Preparation(held=True, late={"q": 0.0}))
    assert found.status != "ok"
    assert not any("declares" in note for note in found.notes)


def test_blocks_and_predictions_know_the_delay(log: Log) -> None:
    whole = symid.identify(LATE, log, preparation=Preparation(held=True))
    blocks = symid.identify(LATE, LongLog.of(log, block=1000), preparation=Preparation(held=True))
    assert blocks.physical_parameters == pytest.approx(whole.physical_parameters, rel=1e-9)
    on_time = simulate(PLAIN, TRUE, REFERENCE, CONTROLLER).log
    late, early = (whole.predict(one).residuals[0].relative for one in (log, on_time))
    assert late < 0.02 < early


def test_what_is_declared_and_passed_over_is_reported_with_the_way_out() -> None:
    declared = PLAIN.with_signal("q", noise=1e-8).with_effect(ActuatorLag(5e-3), ForceLimit(1e3))
    run = simulate(declared, TRUE, SHORT, CONTROLLER).log
    by_regression = symid.identify(declared, run, preparation=Preparation(held=True))
    statement = (
        "ActuatorLag and ForceLimit are declared, but this method passes them over: "
        "take `method=oe` with `controller`, which simulates them"
    )
    assert statement in by_regression.notes
    simulated: Any = symid.identify(
        declared, run, method="oe", preparation=Preparation(held=True), **loop_of(declared, "loop")
    )
    assert simulated.physical_parameters == pytest.approx(TRUE, rel=2e-3)
    assert not any("passes" in note for note in simulated.notes)
