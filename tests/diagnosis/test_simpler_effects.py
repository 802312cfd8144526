"""Coulomb friction takes the place of effects that contain it, unless the log shows more."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from symid import CoulombFriction, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.effects import Key, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.confirmation import confirmed_from, prefer_coulomb
from symid.diagnosis.selection.screening import Candidate
from symid.diagnosis.selection.stages import simpler_effects
from symid.diagnosis.selection.step import Confirmed
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")
BODY = RIGID.bodies[0].name
EFFECTS = {effect.name: effect for effect in LIBRARY}
PERIODIC = next(
    e
    for e in LIBRARY
    if e.name == "position_dependent_friction" and e.amplitudes[0] == "Fs" and e.shape_names
)
COULOMB = Placed(EFFECTS["coulomb_friction"], BODY, (), (30.0,))
PRESLIDING = Placed(EFFECTS["presliding_friction"], BODY, (1e-5,), (30.0,))
VARYING = Placed(PERIODIC, BODY, (0.1,), (30.0, 0.01, 0.02))


def test_coulomb_friction_begins_at_the_level_of_what_contains_it() -> None:
    values = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    noisy = RIGID.with_signal("q", noise=1e-7).with_signal("F", noise=0.5)
    reference = trapezoids(0.1, [0.1, 0.2], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(noisy, values, reference, tuned_cascade(plant_of(RIGID, values), "q"), seed=1).log
    law = next(own for own in RIGID.laws if isinstance(own, CoulombFriction))
    data = data_of(RIGID.without(law), (joined([log]), None), Recording({}, True))
    fit = fitted(*first_state(data.record, {"M": 100.0, "Fv": 120.0}))
    whole = Fit(with_effects(fit.state, fit.weighting, (VARYING,)), fit.weighting)
    own = Confirmed(whole, 0.0, 1.0, whole.blocks.squares)
    far = Candidate(Placed(COULOMB.effect, BODY, (), (1e4,)), 0.0, 0.0)
    (start,) = simpler_effects(fit, [far], {own.key: own})
    assert start.placed.amplitudes == VARYING.amplitudes[:1]
    found = confirmed_from(fit, start)
    assert found is not None
    assert found.placed.amplitudes[0] == pytest.approx(30.0, rel=0.01)


def confirmed(
    item: Placed, gain: float, blocks: float, mean_square: float, rest: float | None = None
) -> Confirmed:
    """A candidate that gains; `blocks` is the error of each other block in which it errs less."""
    squares = np.full((1, 16), 100.0)
    squares[0, ::2] = blocks
    positions = np.linspace(0.0, 0.2, 50)
    if rest is not None:  # most of the time at one place
        positions = np.concatenate([positions, np.full(200, rest)])
    motion = SimpleNamespace(q=positions, v=np.ones(positions.size))
    record = SimpleNamespace(in_log=np.ones(positions.size, dtype=bool))
    state = SimpleNamespace(prediction=SimpleNamespace(joints={BODY: motion}, record=record))
    fit = SimpleNamespace(mean_square=mean_square, n_rows=1600.0, state=state)
    effect = SimpleNamespace(is_plausible=lambda *_: True)
    own = SimpleNamespace(
        placed=item, key=item.key, penalised_gain=gain, squares=squares, fit=fit, effect=effect
    )
    return cast(Confirmed, cast(Any, own))


@pytest.mark.parametrize(
    ("left", "gained", "kept"),
    [
        (1.0, 28.0, True),  # of noise alone what exceeds two deviations counts, here 21
        (1.0, 18.0, False),
        (5.0, 28.0, False),  # beside something else that is missing, 3 % of the gain of Coulomb friction
        (5.0, 140.0, True),
    ],
)
def test_a_reach_counts_that_the_log_shows(left: float, gained: float, kept: bool) -> None:
    plain = confirmed(COULOMB, 4000.0, 100.0, left)
    found: dict[Key, Confirmed] = {
        COULOMB.key: plain,
        PRESLIDING.key: confirmed(PRESLIDING, 4000.0 + gained, 89.5, left - 0.01),
    }
    prefer_coulomb(found)
    assert (PRESLIDING.key in found) == kept


@pytest.mark.parametrize(("level_gains", "kept"), [(3000.0, False), (100.0, True)])
def test_a_level_comes_before_its_variation_where_it_explains_something(
    level_gains: float, kept: bool
) -> None:
    """A friction that varies by little has its level first; the level of a drawn load explained a sixtieth."""
    found: dict[Key, Confirmed] = {
        COULOMB.key: confirmed(COULOMB, level_gains, 100.0, 1.4),
        VARYING.key: confirmed(VARYING, 5000.0, 40.0, 0.6),
    }
    prefer_coulomb(found)
    assert (VARYING.key in found) == kept


def test_a_level_that_vanishes_somewhere_varies_wherever_the_axis_rests() -> None:
    from_zero = Placed(PERIODIC, BODY, (0.1,), (30.0, 30.0, 0.0))
    found: dict[Key, Confirmed] = {
        COULOMB.key: confirmed(COULOMB, 3000.0, 100.0, 1.4),
        from_zero.key: confirmed(from_zero, 9000.0, 40.0, 0.6, rest=0.025),
    }
    prefer_coulomb(found)
    assert from_zero.key in found
