"""Lack-of-fit test of the effect found first: a law of any shape in its place must not explain clearly more.

The library holds laws of a given shape: a friction that varies as a wave along the stroke, a gain that bends with the
square of the force. A machine may have another law of the same quantity. The best effect of the library then takes away
most of the gap and is still not the cause. It shows in a law without a shape, a piecewise linear function of the
position, velocity or acceleration, in either direction of motion: in the place of the right effect it explains no
more, in the place of a wrong one much more, on blocks that are left out of the fit (compare the classical lack-of-fit
test against a saturated model, N. R. Draper and H. Smith, Applied Regression Analysis, 1998).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray, norms_or_one
from symid.diagnosis.effects import Placed
from symid.diagnosis.effects.nonparametric_law import NonparametricLaw
from symid.diagnosis.fitting.cross_validation import deviation, log_likelihood
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import RANK, fitted
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError

_ITERATIONS = 6
_ROWS_PER_VALUE = 10.0
"""Least number of independent rows for each value of a law without a shape."""
_HOPELESS = 0.9
"""Share of the error above the noise that a law leaves by projection, from which on it does not outdo the effect."""
_FIRST_TERMS = ("coulomb_friction", "viscous_friction", "offset_force")
"""Terms that any force of the motion has, whatever its shape: another shape is a second effect beside them."""
_LAWS = tuple(NonparametricLaw(of) for of in ("position", "velocity", "acceleration"))


@dataclass(frozen=True)
class LackOfFit:
    """The best law without a shape in the place of the first effect."""

    of: str = ""  # quantity of which it is a law; empty if there is none
    # cross-validated mean square above the noise that the model leaves with it, relative to that with the effect; inf
    # where it predicts no better than the effect
    share: float = math.inf

    @property
    def outdoes(self) -> bool:
        """Whether it explains clearly more than the effect: the library may lack the law."""
        return self.share < THRESHOLDS.outdone


def lack_of_fit(first: Fit, whole: Fit) -> LackOfFit:
    """The best law without a shape that takes over what the first effect explains; none if rows are too few for one.

    `first` is the re-identified model, `whole` the one with all effects.
    """
    known = len(first.state.placed)
    item = whole.state.placed[known]
    # A refinement of the effect would take its place, as presliding friction takes that of Coulomb friction.
    others = tuple(x for x in whole.state.placed if x is not item and not x.refines(item.key))
    if item.effect.name in _FIRST_TERMS:
        return LackOfFit()

    def with_law(*placed: Placed) -> FloatArray | None:
        """Squares of the blocks left out by the model with other effects, fitted from its values; None if that fails.

        The fit itself is not kept: its columns are large.
        """
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                state = with_effects(whole.state, whole.weighting, placed)
                return fitted(state, whole.weighting, _ITERATIONS).blocks.squares
        except (SettingError, np.linalg.LinAlgError, OverflowError):
            return None

    def predicted(squares: FloatArray) -> float:
        return log_likelihood(squares, whole.n_rows)

    def left(squares: FloatArray) -> float:
        """Cross-validated mean square in multiples of the noise of the model, mean of the outputs."""
        noise = whole.state.prediction.noise_through(whole.weighting.density)
        return float(np.mean(squares.sum(axis=1) / int(whole.weighting.kept.sum()) / noise))

    before = whole.blocks.squares
    law, found = item, before
    for tried in (law for law in _laws(item, whole) if _may_gain(law, whole)):
        squares = with_law(*others, tried)
        if squares is not None and predicted(squares) > predicted(found):
            law, found = tried, squares
    doubt = deviation(before, found, whole.n_rows)
    own, least = left(before), left(found)
    gain = predicted(found) - predicted(before)
    if gain <= max(THRESHOLDS.least_penalised_gain, doubt) or least >= own:
        return LackOfFit()
    floor = min(1.0, least)  # what the law leaves is noise as far as it is below the stated level
    without, both = with_law(*others), with_law(*whole.state.placed, law)
    if without is None or both is None:
        return LackOfFit()
    # Where much else is missing, a law may explain more of that. The effect is then as good beside the law.
    kept, alone = least - left(both), max(left(without) - own, np.finfo(float).tiny)
    share = (least - floor) / (own - floor)
    assert isinstance(law.effect, NonparametricLaw)
    return LackOfFit(law.effect.of, share) if kept < THRESHOLDS.stands_in * alone else LackOfFit()


def _may_gain(law: Placed, whole: Fit) -> bool:
    """Whether a law beside all effects may outdo the first, by projection.

    It must gain more than as many free values do in noise, and leave clearly less above the noise than the effects.
    """
    weighting, prediction = whole.weighting, whole.state.prediction
    own = law.effect.columns(prediction, law.at, law.shape)
    columns = np.concatenate(
        [whole.projected_columns, weighting.projected(weighting.rows(own), whole.state.beginning)]
    )
    columns /= norms_or_one(columns, axis=1)[:, None]
    onto = columns @ whole.error
    closed = float(onto @ np.linalg.pinv(columns @ columns.T, rcond=RANK, hermitian=True) @ onto) / whole.cost
    gain = -0.5 * whole.n_rows * len(whole.state.rows) * math.log1p(-min(closed, 1 - RANK))
    above = whole.mean_square - 1
    if whole.mean_square * (1 - closed) - 1 > _HOPELESS * above > 0:
        return False
    return gain > THRESHOLDS.least_penalised_gain + len(law.amplitudes) / 2


def _laws(item: Placed, fit: Fit) -> Iterator[Placed]:
    """Laws without a shape at the place of an effect, or at the drives for one elsewhere, as far as rows suffice."""
    prediction = fit.state.prediction
    places = [item.at] if item.at in prediction.joints else sorted(prediction.record.driven_bodies)
    for place in places:
        for law in _LAWS:
            if fit.n_rows >= _ROWS_PER_VALUE * len(law.amplitudes):
                yield Placed(law, place, (), (0.0,) * len(law.amplitudes))
