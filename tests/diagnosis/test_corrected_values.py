"""Values are corrected by what a fit predicts wrong of a simulation of its own axis."""

from dataclasses import replace

import pytest

from symid import Log, StribeckFriction, load_axis
from symid.diagnosis import LIBRARY, Diagnosis, diagnose, explained_axis
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.in_motion.corrected import corrected
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.step import accepted_of
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("rigid_1m")
VALUES = {"M": 105.0, "Fv": 120.0, "Fs": 90.0, "dF": 100.0}


def slide(seed: int) -> Log:
    """A slide whose friction falls within 5 ms of each reversal, less than the motion in its band resolves."""
    axis = AXIS.with_signal("q", noise=6e-8).with_signal("F", noise=0.1)
    axis = axis.with_effect(StribeckFriction(AXIS.bodies[0], "dF", velocity=0.02))
    speeds = [0.1, 0.2, 0.3, 0.15]
    path = trapezoids(0.06, speeds, acceleration=5.0, jerk=400.0, dwell=0.0, sampling_period=5e-4)
    plain = {name: value for name, value in VALUES.items() if name != "dF"}
    return simulate(axis, VALUES, path, tuned_cascade(plant_of(AXIS, plain), "q"), seed=seed).log


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    library = [effect for effect in LIBRARY if effect.name == "stribeck_friction"]
    nominal = {"M": 100.0, "Fv": 130.0, "Fs": 100.0}
    return diagnose(AXIS, slide(1), validation=slide(2), nominal=nominal, held=True, library=library)


def test_values_lose_their_error_of_the_band(found: Diagnosis) -> None:
    (friction,) = found.effects
    fitted = accepted_of(found.search)[0].best.fit.state.placed[0]
    before = {"dF": fitted.amplitudes[0], "vs": fitted.shape[0]}
    for name, true in {"dF": 100.0, "vs": 0.02}.items():
        after = friction.parameters[name]
        assert abs(after.value - true) < 0.5 * abs(before[name] - true)
        assert abs(after.value - true) < 3 * after.std
    assert explained_axis(found).values["motor_dF"] == friction.parameters["dF"].value


def test_logs_slower_than_the_simulated_controller_keep_theirs(found: Diagnosis) -> None:
    fitted = accepted_of(found.search)[0].best.fit
    log = slide(1)
    assert corrected(fitted, joined([log])) is not None
    assert corrected(fitted, joined([replace(log, sampling_period=2e-3)])) is None


def test_a_force_that_is_early_is_not_simulated_and_leaves_the_values(found: Diagnosis) -> None:
    fitted = accepted_of(found.search)[0].best.fit
    early = Placed(next(e for e in LIBRARY if e.name == "delay"), "actuator", (-1e-3,), (1.0,))
    state = with_effects(fitted.state, fitted.weighting, (*fitted.state.placed, early))
    assert corrected(Fit(state, fitted.weighting), joined([slide(1)])) is None
