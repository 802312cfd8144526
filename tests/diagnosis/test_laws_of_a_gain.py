"""An effect with several laws, as a gain that bends: a projection hardly distinguishes them, fits do."""

from dataclasses import replace

import numpy as np
import pytest
from hand_made import rigid_log

from symid import Log, OffsetForce, load_axis
from symid.axis import GainNonlinearity
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import GainNonlinearityEffect, Placed
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection import backward
from symid.diagnosis.selection.reselection import reselected
from symid.diagnosis.selection.step import accepted_of
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 60.0}
SQUARE, CUBE = GainNonlinearityEffect(2), GainNonlinearityEffect(3)
ACTUATOR = "actuator"


def bent(seed: int, offset: float = 0.0) -> Log:
    axis = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.4)
    axis = axis.with_effect(GainNonlinearity(6e-7, 3), OffsetForce(RIGID.bodies[0], "F0"))
    moves = trapezoids([0.3, 0.1], [0.2, 0.4], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    return simulate(
        axis, VALUES | {"F0": offset}, moves, tuned_cascade(plant_of(RIGID, VALUES), "q"), seed=seed
    ).log


def test_another_law_takes_the_place_of_one_that_a_projection_preferred() -> None:
    found = diagnose(
        RIGID, bent(1), validation=bent(2), nominal=VALUES, held=True, library=[SQUARE, CUBE, *LIBRARY[:3]]
    )
    (step,) = accepted_of(found.search)
    (candidate,) = (c for c in step.screened if c.placed.effect.name == "gain_nonlinearity")
    assert {candidate.placed.effect, *(item.effect for item in candidate.others)} == {SQUARE, CUBE}
    # The same with the square law, as if that had been found.
    fit = step.best.fit
    placed = Placed(SQUARE, ACTUATOR, (), (1e-4,))
    whole = fitted(with_effects(fit.state, fit.weighting, (placed,)), fit.weighting, 5)
    preferred = replace(candidate, placed=placed, others=(Placed(CUBE, ACTUATOR, (), (1e-7,)),))
    begun = replace(step, confirmed=(replace(step.best, fit=whole),), screened=(preferred,))
    (member,) = reselected([begun], ())
    assert member.placed.effect is CUBE
    assert member.placed.amplitudes[0] == pytest.approx(6e-7, rel=0.01)


def test_effects_are_taken_together_where_none_is_justified_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search had found the wrong law of the gain, and a constant force beside it."""
    library = [CUBE, *(effect for effect in LIBRARY if effect.name == "offset_force")]
    logs = {"validation": bent(2, 15.0), "nominal": VALUES, "held": True, "library": library}
    *steps, last = accepted_of(diagnose(RIGID, bent(1, 15.0), **logs).search)
    fit, wrong = last.best.fit, Placed(SQUARE, ACTUATOR, (), (1e-4,))
    placed = tuple(wrong if item.effect is CUBE else item for item in fit.state.placed)
    whole = fitted(with_effects(fit.state, fit.weighting, placed), fit.weighting, 5)
    screened = tuple(
        replace(c, others=(replace(c.placed, effect=SQUARE),)) if c.placed.effect is CUBE else c
        for step in (*steps, last)
        for c in step.screened
    )
    astray = replace(last, confirmed=(replace(last.best, fit=whole),), screened=screened)
    begun = [replace(step, screened=screened) for step in steps]
    assert whole.mean_square > 4 * fit.mean_square
    chain = backward._chain
    monkeypatch.setattr(
        backward,
        "_chain",
        lambda *args, justified=False, **k: chain(*args, justified=True, **k) if justified else None,
    )
    found = backward.backward_elimination([*begun, astray], ())
    assert {step.best.effect for step in found} == set(library)
    assert found[-1].best.fit.mean_square < 1.2 * fit.mean_square


@pytest.mark.parametrize("share", [0.004, 0.2])
def test_a_gain_may_bend_more_in_short_peaks(share: float) -> None:
    """As at the shock when a body takes up a payload."""
    log = rigid_log()
    force = log["F"] / np.abs(log["F"]).max()
    peaks = np.abs(np.arange(force.size) / force.size - 0.5) < share / 2
    raised = np.where(peaks, 3.0, force)
    data = data_of(
        RIGID, (joined([replace(log, signals={**log.signals, "F": raised})]), None), Recording({}, None)
    )
    state, _ = first_state(data.record, {"M": 1.0, "Fv": 1.0, "Fs": 0.1})
    assert CUBE.is_plausible(state.prediction, Placed(CUBE, ACTUATOR, (), (0.05,))) is (share < 0.02)
