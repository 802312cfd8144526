"""Coulomb friction of which a part builds up over a displacement: both are found, and the levels are those declared."""

from dataclasses import replace

import numpy as np
import pytest

from symid import CoulombFriction, Log, PreslidingFriction, load_axis
from symid.diagnosis import LIBRARY, Diagnosis, diagnose, explained_axis
from symid.diagnosis.effects import Placed, with_presliding_parts
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
BODY = RIGID.bodies[0]
COULOMB = next(law for law in RIGID.laws if isinstance(law, CoulombFriction))
FRICTIONLESS = RIGID.without(COULOMB)
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
KNOWN = {"M": 100.0, "Fv": 120.0}


def slide(seed: int) -> Log:
    """A log of a slide of whose 30 N 12 N build up over 0.1 mm."""
    axis = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.5)
    axis = axis.with_effect(PreslidingFriction(BODY, 12.0, reach=1e-4))
    speeds = [0.05, 0.1, 0.2, 0.3]
    reference = trapezoids([0.1, 0.02], speeds, acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    return simulate(axis, VALUES, reference, tuned_cascade(plant_of(RIGID, VALUES), "q"), seed=seed).log


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    """The diagnosis by a model without the friction."""
    return diagnose(FRICTIONLESS, slide(1), validation=slide(2), nominal=KNOWN, held=True)


def test_coulomb_friction_is_the_whole_and_presliding_a_part_of_it(found: Diagnosis) -> None:
    whole, part = found.effects
    assert (whole.effect, part.effect) == ("coulomb_friction", "presliding_friction")
    assert whole.parameters["Fs"].value == pytest.approx(30.0, rel=0.01)
    assert whole.parameters["Fs"].std < 0.1
    assert part.parameters["Fs"].value == pytest.approx(12.0, rel=0.05)
    assert part.parameters["reach"].value == pytest.approx(1e-4, rel=0.05)


def test_the_axis_written_has_the_friction_of_the_machine(found: Diagnosis) -> None:
    explained = explained_axis(found)
    (law,) = (own for own in explained.axis.laws if isinstance(own, CoulombFriction))
    (part,) = (own for own in explained.axis.imperfections if isinstance(own, PreslidingFriction))
    assert explained.values[law.named("level")] == pytest.approx(30.0, rel=0.01)
    assert part.level == pytest.approx(12.0, rel=0.05)


def test_an_encoder_of_coarse_steps_shows_no_short_reach() -> None:
    log = slide(1)
    step = 4e-5
    coarse = replace(log, signals={**log.signals, "q": np.round(log["q"] / step) * step})
    effect = next(e for e in LIBRARY if e.name == "presliding_friction")

    def shows(log: Log, reach: float) -> bool:
        data = data_of(FRICTIONLESS, (joined([log]), None), Recording({}, True))
        prediction = first_state(data.record, KNOWN)[0].prediction
        return effect.is_plausible(prediction, Placed(effect, BODY.name, (reach,), (12.0,)))

    assert (shows(log, 3e-5), shows(coarse, 3e-5), shows(coarse, 1e-4)) == (True, False, True)
    # The instant of a reversal is uncertain by a fraction of a sample besides.
    assert not shows(coarse, 1.03 * step)


def test_a_part_of_coulomb_friction_predicts_what_both_did_apart() -> None:
    data = data_of(FRICTIONLESS, (joined([slide(1)]), None), Recording({}, True))
    state, weighting = first_state(data.record, KNOWN)
    effects = {effect.name: effect for effect in LIBRARY}
    coulomb = Placed(effects["coulomb_friction"], BODY.name, (), (18.0,))
    presliding = Placed(effects["presliding_friction"], BODY.name, (1e-4,), (12.0,))
    apart = with_effects(state, weighting, (coulomb, presliding))
    whole, part = with_presliding_parts(apart.placed)
    together = with_effects(state, weighting, (whole, part))
    assert (whole.amplitudes, part.amplitudes) == ((30.0,), (12.0,))
    assert np.allclose(together.rows, apart.rows, rtol=0, atol=1e-9 * np.abs(apart.rows).max())


def test_reaches_tried_fit_within_the_stroke_of_the_joint() -> None:
    """A structure that its spring holds moves by micrometres: the least reach of a slide was as long as its stroke."""
    axis = load_axis("direct_2m1s")
    values = {"Ms": 2300.0, "Fvs": 28000.0, "Ks": 1.4e8, "Mm": 335.0, "Fvm": 330.0, "Fsm": 110.0}
    path = trapezoids([0.2, 0.1], 0.8, acceleration=5.0, jerk=300.0, dwell=0.05, sampling_period=1e-3)
    log = simulate(axis, values, path, tuned_cascade(plant_of(axis, values), "q2"), seed=1).log
    state, _ = first_state(data_of(axis, (joined([log]), None), Recording({}, True)).record, values)
    effect = next(effect for effect in LIBRARY if effect.name == "presliding_friction")
    tried = {
        at: [reach for (reach,) in effect.shapes(state.prediction, at, lambda response: response.real)]
        for at in ("motor", "structure")
    }
    assert tried["motor"][0] == pytest.approx(2e-6)
    assert tried["motor"][-1] == pytest.approx(6e-4)
    stroke = state.prediction.joints["structure"].stroke
    assert stroke < 1e-4
    assert max(tried["structure"]) < stroke / 3
    assert min(tried["structure"]) < stroke / 100
