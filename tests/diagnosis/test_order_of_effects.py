"""The strongest effect is named first, and a change of mass lets hidden bodies go on."""

import sys
from types import SimpleNamespace

import hand_made
import numpy as np
import pytest
from hand_made import rigid_log

from symid import Cogging, PayloadChange, QuadraticDrag, load_axis
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import LIBRARY, Placed
from symid.diagnosis.findings.held_out import strongest_first
from symid.diagnosis.findings.strength import FixedBand
from symid.diagnosis.fitting.applied import applied
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import State, first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.backward import _determined, brought_first
from symid.diagnosis.selection.step import Confirmed, SelectionStep, accepted_of
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

applied_module = sys.modules[applied.__module__]
held_out_module = sys.modules[strongest_first.__module__]
RIGID = load_axis("rigid_1m")
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
ELASTIC = load_axis("direct_2m1s")
BOTH = [effect for effect in LIBRARY if effect.name in ("cogging", "quadratic_drag")]
FLEXIBLE = {"Mm": 90.0, "Ms": 60.0, "Ks": 60 * (2 * np.pi * 25) ** 2, "Fvs": 200.0, "Fvm": 150.0, "Fsm": 30.0}


def slide(speeds: list[float], seed: int) -> Log:
    """A log of a slide with cogging and drag at given speeds."""
    body = RIGID.bodies[0]
    axis = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.3)
    axis = axis.with_effect(Cogging(body, "As", "Ac", pitch=0.02), QuadraticDrag(body, "D"))
    values = VALUES | {"As": 3.0, "Ac": 0.0, "D": 60.0}
    reference = trapezoids([0.3, 0.1], speeds, acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    return simulate(axis, values, reference, tuned_cascade(plant_of(RIGID, VALUES), "q"), seed=seed).log


def test_the_strongest_of_the_validation_log_is_first(monkeypatch: pytest.MonkeyPatch) -> None:
    slow, fast = slide([0.05, 0.1, 0.3], 1), slide([0.5, 0.8, 1.0], 2)

    def found() -> list[str]:
        effects = diagnose(RIGID, slow, validation=fast, nominal=VALUES, held=True, library=BOTH).effects
        return [effect.effect for effect in effects]

    assert found() == ["quadratic_drag", "cogging"]
    monkeypatch.setattr(held_out_module, "brought_first", lambda steps, at: steps)
    assert found() == ["cogging", "quadratic_drag"]  # by what errs in the log for identification


@pytest.mark.parametrize(
    ("strengths", "share", "first"),
    [([1.0, 2.0], 0.6, 1), ([1.0, 2.0], 0.2, 0), ([1.0, 4.0], 0.2, 1), ([1.0, 0.9], 0.6, 0)],
)
def test_what_removes_little_alone_is_first_only_if_it_is_clearly_stronger(
    monkeypatch: pytest.MonkeyPatch, strengths: list[float], share: float, first: int
) -> None:
    """A slow wander of the record hid a Stribeck friction of 12 N in the gap, where a lag of 0.7 ms showed."""

    def comparison(share_alone: float) -> SimpleNamespace:
        ranked = SimpleNamespace(strengths=np.array(strengths))
        removed = SimpleNamespace(share=share_alone)
        return SimpleNamespace(
            validated=2, relative_error=0.3, with_effects=lambda _: ranked, removed=lambda *_: removed
        )

    def step(name: str) -> SimpleNamespace:
        best = SimpleNamespace(effect=SimpleNamespace(name=name))
        return SimpleNamespace(accepts=True, best=best)

    steps = (step("actuator_lag"), step("stribeck_friction"))
    monkeypatch.setattr(held_out_module, "brought_first", lambda found, at: [found[at], found[1 - at]])
    found, _ = strongest_first(steps, comparison(0.7), lambda _: comparison(share))
    assert found[0] is steps[first]


def test_strength_is_the_force_that_no_parameter_stands_for(monkeypatch: pytest.MonkeyPatch) -> None:
    log = slide([0.5, 0.8, 1.0], 2)
    found = diagnose(RIGID, log, nominal=VALUES, held=True, library=BOTH)
    fit = accepted_of(found.search)[-1].best.fit
    assert {item.effect.name for item in fit.state.placed} == {"quadratic_drag", "cogging"}
    kept = fit.weighting.kept
    away = (
        np.abs(np.interp(fit.weighting.record.row_time[kept], log.time, np.gradient(log["q"], log.time)))
        > 0.02
    )
    band = FixedBand.of(fit.state, fit.weighting, away, 0)
    found = band.strengths()

    v = np.gradient(log["q"], log.time)
    rows = np.isin(
        np.arange(v.size), np.rint(fit.weighting.record.row_time[kept][away] / log.sampling_period)
    )
    columns = np.stack([np.gradient(v, log.time), v, np.sign(v)], axis=1)[rows]
    for item, strength in zip(fit.state.placed, found, strict=True):
        place = 2 * np.pi * log["q"] / (item.shape[0] if item.shape else 1.0)
        terms = [np.sin(place), np.cos(place)] if item.effect.name == "cogging" else [v * np.abs(v)]
        force = (np.array(item.amplitudes) @ np.array(terms))[rows]
        left = force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0]
        noise = fit.weighting.record.noise_of_outputs[0]
        assert strength == pytest.approx(np.sqrt(np.mean(left**2)) / noise, rel=0.1)

    # An effect that alone keeps hidden motion stable has no strength: the model without it is none of the machine.
    errors = FixedBand._errors
    whole, error = len(fit.state.placed), errors(band, fit.state.placed)
    monkeypatch.setattr(
        FixedBand, "_errors", lambda _, placed: error if len(placed) == whole else 1e50 * (1 + error)
    )
    assert band.strengths().tolist() == [0.0, 0.0]


def test_what_is_brought_first_keeps_what_spoke_for_it() -> None:
    log = slide([0.05, 0.1, 0.3], 1)
    steps = accepted_of(diagnose(RIGID, log, nominal=VALUES, held=True, library=BOTH).search)
    assert len(steps) == 2
    last_first = brought_first(steps, 1)
    assert [step.best.key for step in last_first] == [step.best.key for step in steps[::-1]]
    assert [step.best.gain for step in last_first] == [step.best.gain for step in steps[::-1]]
    assert all(step.accepts for step in last_first)
    assert last_first[0].before is steps[0].before


@pytest.mark.parametrize("moment", [1.5, 3.4])
def test_hidden_bodies_go_on_when_a_mass_changes(moment: float) -> None:
    change = PayloadChange(ELASTIC.only_drive.at, 8.0, time=moment)
    axis = ELASTIC.with_effect(change).with_signal("q2", noise=1e-7).with_signal("Fm", noise=1.0)
    reference = trapezoids(0.1, [0.1, 0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    run = simulate(axis, FLEXIBLE, reference, tuned_cascade(plant_of(ELASTIC, FLEXIBLE), "q2"), seed=1).log
    log = Log.from_arrays({"q2": run["q2"], "Fm": run["Fm"]}, sampling_period=run.sampling_period)
    left = []
    for declared in (ELASTIC, ELASTIC.with_effect(change)):
        data = data_of(declared, (joined([log]), None), Recording({}, True))
        left.append(Fit(*first_state(data.record, FLEXIBLE)).mean_square)
    assert left[1] < 0.02 * left[0]


def test_a_model_that_grows_without_bound_on_the_validation_log_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    under = applied

    def grows(model: State, *others: object) -> tuple[State, Weighting]:
        if model.placed:
            raise OverflowError("the hidden motion grows without bound")
        return under(model, *others)

    monkeypatch.setattr(applied_module, "applied", grows)
    found = diagnose(
        RIGID, slide([0.05, 0.1, 0.3], 1), validation=slide([0.1, 0.3, 0.5], 2), nominal=VALUES, held=True
    )
    assert found.verdict == "unexplained"
    assert not found.effects


def test_the_interval_of_a_share_holds_what_the_effect_removes_beside_the_others() -> None:
    slow, fast = slide([0.05, 0.1, 0.3], 1), slide([0.5, 0.8, 1.0], 2)
    found = diagnose(RIGID, slow, validation=fast, nominal=VALUES, held=True, library=BOTH)
    assert [effect.effect for effect in found.effects] == ["quadratic_drag", "cogging"]

    # by the drawn forces: what the plain axis leaves of them, with the drag taken away and without
    v, force = np.gradient(fast["q"], fast.time), 3.0 * np.sin(2 * np.pi * fast["q"] / 0.02)
    columns = np.stack([np.gradient(v, fast.time), v, np.sign(v)], axis=1)[np.abs(v) > 0.02]

    def left(missing: np.ndarray) -> float:
        missing = missing[np.abs(v) > 0.02]
        return float(np.sum((missing - columns @ np.linalg.lstsq(columns, missing, rcond=None)[0]) ** 2))

    truth = 1 - left(force) / left(force + 60.0 * v * np.abs(v))
    drag, cogging = (effect.removes for effect in found.effects)
    assert drag.low < truth < drag.high
    assert cogging.low < 1 - truth < cogging.high


def test_cogging_of_a_longer_pitch_than_the_stroke_is_found_if_it_explains_all() -> None:
    pitch = 1.2 * float(np.ptp(rigid_log()["q"]))
    log = rigid_log(lambda t, q, v, a, path: 40 * np.sin(2 * np.pi * q / pitch + 0.7))
    found = diagnose(RIGID, log, nominal=hand_made.RIGID)
    assert [effect.effect for effect in found.effects] == ["cogging"]
    assert found.effects[0].parameters["pitch"].value == pytest.approx(pitch, rel=1e-3)
    stiff = rigid_log(lambda t, q, v, a, path: 800 * q)
    named = diagnose(RIGID, stiff, nominal=hand_made.RIGID).effects[0]
    assert (named.effect, named.indistinguishable_from) == ("position_stiffness", ())


def test_effects_within_their_deviations_beside_all_others_are_dropped() -> None:
    """An effect that is named first and stood in for another one, which leaves nothing to it."""
    data = data_of(RIGID, (joined([rigid_log(lambda t, q, v, a, path: 800 * q)]), None), Recording({}, None))
    fit = fitted(*first_state(data.record, hand_made.RIGID))
    base, steps = fit, list[SelectionStep]()
    for name in ("offset_force", "position_stiffness"):
        effect = next(effect for effect in LIBRARY if effect.name == name)
        item = Placed(effect, "motor", (), (1.0,))
        found = fitted(with_effects(fit.state, fit.weighting, (*fit.state.placed, item)), fit.weighting)
        own = Confirmed(found, 100.0, 1.0, found.blocks.squares)
        steps.append(SelectionStep(fit, (own,), ()))
        fit = found
    assert abs(fit.state.placed[0].amplitudes[0]) < 1.0
    kept = _determined(steps)
    assert [step.best.key for step in kept] == [("position_stiffness", "motor")]
    assert kept[0].before.parameters == base.parameters
    assert _determined(steps[:1]) == steps[:1]
