"""A small effect beside a large one is found where it takes away much of what is left."""

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symid import Cogging, PayloadChange, QuadraticDrag, load_axis
from symid.data import Log
from symid.diagnosis import Diagnosis, diagnose
from symid.diagnosis.effects import LIBRARY
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.selection import backward
from symid.diagnosis.selection.backward import _chain, _members, _with_values_of
from symid.diagnosis.selection.lack_of_fit import lack_of_fit
from symid.diagnosis.selection.reselection import Member
from symid.diagnosis.selection.step import takes
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
BODY = RIGID.bodies[0]
VALUES = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
HIDDEN = {"D": 900.0, "As": 2.0, "Ac": 0.0}


def slide(seed: int) -> Log:
    """A log of a slide with strong drag and weak cogging."""
    axis = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.3)
    axis = axis.with_effect(Cogging(BODY, "As", "Ac", pitch=0.03), QuadraticDrag(BODY, "D"))
    speeds = [0.3, 0.7, 1.0] if seed % 2 else [0.4, 0.6, 0.9]
    reference = trapezoids(0.4, speeds, acceleration=5.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(RIGID, VALUES), "q")
    return simulate(axis, VALUES | HIDDEN, reference, loop, seed=seed).log


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return diagnose(RIGID, slide(1), validation=slide(2), nominal=VALUES, held=True)


def test_a_small_effect_that_takes_away_most_of_a_clear_rest_is_found(found: Diagnosis) -> None:
    assert [effect.effect for effect in found.effects] == ["quadratic_drag", "cogging"]
    first, second = (step for step in found.search if step.accepts)
    rest = second.before.mean_square
    taken = rest - second.best.fit.mean_square
    assert taken > 0.9 * rest
    assert taken < 0.006 * first.before.mean_square
    amplitudes = found.effects[1].parameters
    assert np.hypot(amplitudes["As"].value, amplitudes["Ac"].value) == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize(
    ("before", "after", "counts"),
    [(20.0, 5.0, True), (20.0, 15.0, False), (3.0, 1.2, True), (3.0, 1.6, False), (1.4, 1.0, False)],
)
def test_what_takes_nearly_all_of_a_rest_near_the_noise_counts(
    before: float, after: float, counts: bool
) -> None:
    first, *fits = (
        cast(
            Fit,
            SimpleNamespace(
                squares=np.array([square]),
                mean_square=square,
                squares_as_weighted_by=lambda _, own=square: np.array([own]),
            ),
        )
        for square in (1e5, before, after)
    )
    assert takes(fits[0], fits[1], first) is counts


def test_beside_the_first_effect_the_second_is_left(found: Diagnosis) -> None:
    left = found.effects[0].gap_after.rms ** 2 - found.gap.explained.rms**2
    assert left == pytest.approx(2.0**2 / 2, rel=0.2)  # of a sine; a part of it lies above the band


def test_no_law_of_any_shape_outdoes_the_right_effect_that_leaves_another_one(found: Diagnosis) -> None:
    first, whole = found.search[0].before, found.search[0].best.fit
    assert whole.state.placed[-1].key == ("quadratic_drag", "motor")
    assert not lack_of_fit(first, whole).outdoes


def test_the_last_effect_of_an_order_is_also_fitted_from_the_values_of_the_whole_model(
    found: Diagnosis,
) -> None:
    accepted = [step for step in found.search if step.accepts]
    first, whole = accepted[0].before, accepted[-1].best.fit
    drag, cogging = members = _members(accepted)
    (start,) = _with_values_of(whole, first, members)
    assert start.placed is cogging.placed
    assert start.placed_state().prediction.parameters == whole.state.prediction.parameters
    found_again = _chain([drag, cogging], first, math.inf, justified=True, whole=whole)
    assert found_again is not None
    assert found_again[-1].best.fit.mean_square == pytest.approx(whole.mean_square, rel=1e-2)


def test_where_fits_begin_astray_the_values_of_the_whole_model_are_tried(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    accepted = [step for step in found.search if step.accepts]
    tried = []

    def astray(members: Sequence[Member], *args: Any, whole: Fit | None = None, **options: Any) -> Any:
        tried.append((tuple(member.placed.key for member in members), whole is not None))
        return whole and _chain(members, *args, whole=whole, **options)

    monkeypatch.setattr(backward, "_chain", astray)
    steps = backward.backward_elimination(accepted, LIBRARY)
    assert [from_whole for _, from_whole in tried] == [*[False] * (len(tried) - 1), True]
    assert len(tried) > 1
    assert len(set(tried)) == len(tried)  # each order once
    assert {step.best.key for step in steps} == {step.best.key for step in accepted}


def test_a_change_of_one_percent_of_a_mass_is_found_where_it_is() -> None:
    screw = load_axis("ballscrew_2m1s").with_signal("qm", noise=1e-8).with_signal("ql", noise=1e-8)
    values = {"Mm": 158.0, "Fvm": 142.0, "Fsm": 81.0, "Kt": 2e7, "Ft": 2000.0, "Ml": 253.0, "Fvl": 134.0}
    changing = screw.with_signal("Fm", noise=0.3).with_effect(PayloadChange(screw.bodies[1], 3.0, time=1.1))
    reference = trapezoids(0.2, [0.3, 0.5], acceleration=5.0, jerk=200.0, dwell=0.1, sampling_period=5e-4)
    loop = tuned_cascade(plant_of(screw, values), "qm")
    log, other = (simulate(changing, values, reference, loop, seed=seed).log for seed in (1, 2))
    library = [effect for effect in LIBRARY if effect.name == "payload_change"]
    effect = diagnose(screw, log, validation=other, nominal=values, library=library).effects[0]
    assert (effect.effect, effect.at) == ("payload_change", "load")
    assert effect.parameters["dm"].value == pytest.approx(3.0, rel=0.05)
