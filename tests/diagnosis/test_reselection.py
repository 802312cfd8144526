"""Effects selected again, each beside all others."""

from dataclasses import replace

import pytest

from symid import Log, OffsetForce, load_axis
from symid.axis import FrictionDrift
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.selection import reselection
from symid.diagnosis.selection.backward import _beside_others
from symid.diagnosis.selection.confirmation import confirmed_from
from symid.diagnosis.selection.evidence import probabilities
from symid.diagnosis.selection.reselection import Member, in_place_of, reselected
from symid.diagnosis.selection.step import Confirmed, SelectionStep, accepted_of
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
BODY = RIGID.bodies[0]
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 60.0}
OFFSET = next(effect for effect in LIBRARY if effect.name == "offset_force")
ASYMMETRIC = next(
    effect for effect in LIBRARY if effect.name == "asymmetric_friction" and len(effect.amplitudes) == 2
)
DRIFTS = [effect for effect in LIBRARY if effect.name == "friction_drift"]


def slide(seed: int) -> Log:
    """A slide that a constant force pulls while its friction rises from a third."""
    axis = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.4)
    axis = axis.with_effect(OffsetForce(BODY, "F0"), FrictionDrift(BODY, -40.0, -50.0, 1.5))
    moves = trapezoids([0.3, 0.1], [0.2, 0.4], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(RIGID, VALUES), "q")
    return simulate(axis, VALUES | {"F0": 15.0}, moves, loop, seed=seed).log


@pytest.fixture(scope="module")
def accepted() -> list[SelectionStep]:
    """The steps that find both effects."""
    library, nominal = [OFFSET, *DRIFTS], VALUES | {"Fs": 20.0}
    found = diagnose(RIGID, slide(1), validation=slide(2), nominal=nominal, held=True, library=library)
    return accepted_of(found.search)


def test_each_later_model_holds_the_accepted_effects_alone(accepted: list[SelectionStep]) -> None:
    """A step that is not accepted beside the others was left out, and its effect stayed in the models after it."""
    first, last = accepted
    unsure = replace(first, confirmed=(replace(first.best, certainty=0.0),), beside_others=True)
    steps = accepted_of(_beside_others([unsure, last], [Member(last.best.placed, last, 0.0)]))
    assert [len(step.best.fit.state.placed) for step in steps] == list(range(1, len(steps) + 1))


def test_a_simpler_effect_competes_beside_all_others(accepted: list[SelectionStep]) -> None:
    *steps, last = accepted
    # The same with asymmetric friction in the place of the constant force, as if that had been found.
    fit = last.best.fit
    placed = tuple(
        Placed(ASYMMETRIC, BODY.name, (), (item.amplitudes[0], 1.0))
        if item.effect.name == "offset_force"
        else item
        for item in fit.state.placed
    )
    whole = fitted(with_effects(fit.state, fit.weighting, placed), fit.weighting, 5)
    last = replace(last, confirmed=(replace(last.best, fit=whole), *last.confirmed[1:]))
    members = reselected([*steps, last], ())
    chosen = next(member.step for member in members if member.placed.effect.name != "friction_drift")
    rivals = {own.effect.name: own for own in chosen.confirmed}
    assert rivals["offset_force"].placed.amplitudes[0] == pytest.approx(15.0, rel=0.01)
    # The level of friction that drifts cannot tell which of the two it is.
    assert not any(own.log_prior_odds for own in rivals.values())
    assert probabilities(chosen, [("friction_drift", BODY.name)])["offset_force", BODY.name] > 0.3


def test_the_same_effect_elsewhere_begins_with_the_values_of_the_whole_model(
    accepted: list[SelectionStep], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without it the parameters are astray: a disturbance of the driven body led them too far for a hidden one."""
    first, last = accepted
    elsewhere = replace(first.best.placed, at="elsewhere")
    state = replace(first.best.fit.state, placed=(elsewhere,))
    rival = replace(first.best, fit=replace(first.best.fit, state=state))
    begun: list[dict[str, float]] = []

    def confirmed(before: Fit, start: Start, *rest: float) -> Confirmed | None:
        if start.placed.at != "elsewhere":
            return confirmed_from(before, start, *rest)
        begun.append(dict(start.state.prediction.parameters))
        return None

    monkeypatch.setattr(reselection, "confirmed_from", confirmed)
    reselected([replace(first, confirmed=(first.best, rival)), last], [OFFSET])
    assert dict(last.best.fit.parameters) in begun


def test_a_rival_that_explained_more_alone_is_not_ahead_beside_the_other_effects(
    accepted: list[SelectionStep],
) -> None:
    """Coulomb friction may lead Stribeck friction that explains a drag too: beside the drag it explains all."""
    first, last = accepted
    ahead = replace(first.best, gain=first.best.gain + 5000.0)
    led = replace(first, confirmed=(first.best, ahead))
    best, rival = in_place_of(led, last.before, last.best).confirmed
    assert rival.gain == best.gain == last.best.gain
