"""Lack-of-fit test of the effect found first, against a nonparametric law in its place.

A machine may have another law of the same quantity than the library: friction that varies along the stroke, but not as
a sine. The best effect of the library then closes most of the gap without being the cause. A nonparametric law shows
this: a piecewise linear function of position, velocity or acceleration in either direction of motion. In the place of
the right effect it predicts blocks that are left out of the fit no better; in the place of a wrong one, far better
(compare the lack-of-fit test against a saturated model, N. R. Draper and H. Smith, Applied Regression Analysis, 1998).
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
"""Least number of independent rows for each value of a nonparametric law."""
_FIRST_TERMS = ("coulomb_friction", "viscous_friction", "offset_force")
"""Terms that any force of the motion has, whatever its shape: another shape is a second effect beside them."""
_LAWS = tuple(NonparametricLaw(of) for of in ("position", "velocity", "acceleration"))


@dataclass(frozen=True)
class LackOfFit:
    """The best nonparametric law in the place of the first effect."""

    of: str = ""  # quantity of which it is a law; empty if there is none
    # cross-validated mean square above the noise that the model leaves with it, relative to that with the effect; inf
    # where it predicts no better than the effect
    share: float = math.inf

    @property
    def outdoes(self) -> bool:
        """Whether it explains clearly more than the effect: the library may lack the law."""
        return self.share < THRESHOLDS.outdone


def lack_of_fit(first: Fit, whole: Fit) -> LackOfFit:
    """The best nonparametric law in the place of the first effect; none if the rows are too few for one.

    `first` is the re-identified model, `whole` the one with all effects.
    """
    item = whole.state.placed[len(first.state.placed)]
    # A refinement of the effect would take its place, as presliding friction takes that of Coulomb friction.
    others = tuple(x for x in whole.state.placed if x is not item and not x.refines(item.key))
    if item.effect.name in _FIRST_TERMS:
        return LackOfFit()
    # 1. The law of position, velocity or acceleration that predicts the blocks best in the place of the effect.
    before = whole.blocks.squares
    law, found = item, before
    for candidate in (law for law in _laws(item, whole) if _may_gain(law, whole)):
        squares = _squares_with(whole, *others, candidate)
        if squares is not None and _predicted(squares, whole) > _predicted(found, whole):
            law, found = candidate, squares
    # 2. It must predict them clearly better than the effect.
    own, least = _left(before, whole), _left(found, whole)
    gain, spread = (
        _predicted(found, whole) - _predicted(before, whole),
        deviation(before, found, whole.n_rows),
    )
    if gain <= max(THRESHOLDS.least_penalised_gain, spread) or least >= own:
        return LackOfFit()
    # 3. And it must replace the effect: where much else is missing, a law may explain more of that instead, and the
    # effect then removes as much error beside the law as it does alone.
    without, both = _squares_with(whole, *others), _squares_with(whole, *whole.state.placed, law)
    if without is None or both is None:
        return LackOfFit()
    beside_law, alone = least - _left(both, whole), max(_left(without, whole) - own, np.finfo(float).tiny)
    if not beside_law < THRESHOLDS.stands_in * alone:
        return LackOfFit()
    floor = min(1.0, least)  # the law may leave less than the stated level of the noise, which is then lower
    assert isinstance(law.effect, NonparametricLaw)
    return LackOfFit(law.effect.of, (least - floor) / (own - floor))


def _squares_with(whole: Fit, *placed: Placed) -> FloatArray | None:
    """Squared errors of the blocks left out, with other effects fitted from the values of a model; None if that fails.

    The fit itself is not kept: its columns are large.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            state = with_effects(whole.state, whole.weighting, placed)
            return fitted(state, whole.weighting, _ITERATIONS).blocks.squares
    except (SettingError, np.linalg.LinAlgError, OverflowError):
        return None


def _predicted(squares: FloatArray, whole: Fit) -> float:
    """Cross-validated log-likelihood from the squares of the blocks."""
    return log_likelihood(squares, whole.n_rows)


def _left(squares: FloatArray, whole: Fit) -> float:
    """Cross-validated mean square from the squares of the blocks, relative to noise, mean of the outputs."""
    noise = whole.state.prediction.noise_through(whole.weighting.density)
    return float(np.mean(squares.sum(axis=1) / int(whole.weighting.kept.sum()) / noise))


def _may_gain(law: Placed, whole: Fit) -> bool:
    """Whether a law beside all effects may fit better than the first effect, by projection.

    Its gain must exceed that of as many free values in noise, and its error above the noise be clearly smaller.
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
    if whole.mean_square * (1 - closed) - 1 > THRESHOLDS.may_outdo * above > 0:
        return False
    return gain > THRESHOLDS.least_penalised_gain + len(law.amplitudes) / 2


def _laws(item: Placed, fit: Fit) -> Iterator[Placed]:
    """Nonparametric laws at the place of an effect, or at the drives for one elsewhere, as far as rows suffice."""
    prediction = fit.state.prediction
    places = [item.at] if item.at in prediction.joints else sorted(prediction.record.driven_bodies)
    for place in places:
        for law in _LAWS:
            if fit.n_rows >= _ROWS_PER_VALUE * len(law.amplitudes):
                yield Placed(law, place, (), (0.0,) * len(law.amplitudes))
