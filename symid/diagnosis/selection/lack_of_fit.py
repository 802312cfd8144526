"""Lack-of-fit test of the effect found first: a law of any shape in its place must not explain clearly more.

The library holds laws of a given shape: a friction that varies as a wave along the stroke, a gain that bends with the
square of the force. A machine may have another law of the same quantity. The best effect of the library then takes away
most of the gap and is still not the cause. It shows in a law without a shape, a piecewise linear function of the
position, velocity or acceleration, in either direction of motion: in the place of the right effect it explains no
more, in the place of a wrong one much more, on blocks that are left out of the fit (compare the classical lack-of-fit
test against a saturated model, N. R. Draper and H. Smith, Applied Regression Analysis, 1998).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.effects import Placed
from symid.diagnosis.effects.nonparametric_law import NonparametricLaw
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import with_effects
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError

_ITERATIONS = 2
_ROWS_PER_VALUE = 10.0
"""Least number of independent rows for each value of a law without a shape."""
_FIRST_TERMS = ("coulomb_friction", "viscous_friction")
"""Effects that any friction has, whatever its shape: another shape is a second effect beside them."""
_LAWS = tuple(NonparametricLaw(of) for of in ("position", "velocity", "acceleration"))


@dataclass(frozen=True)
class LackOfFit:
    """The best law without a shape in the place of the first effect."""

    of: str = ""  # quantity of which it is a law; empty if there is none
    # cross-validated mean square above the noise that the model leaves with it, relative to that with the effect
    share: float = math.inf

    @property
    def outdoes(self) -> bool:
        """Whether it explains clearly more than the effect: the library may lack the law."""
        return self.share < THRESHOLDS.outdone


def lack_of_fit(first: Fit, whole: Fit) -> LackOfFit:
    """The best law without a shape that takes over what the first effect explains; none if rows are too few for one.

    `first` is the re-identified model, `whole` the one with all effects.
    """
    floor = whole.state.prediction.noise_through(whole.weighting.density)
    known, own = len(first.state.placed), _excess(whole, floor)

    def left(*placed: Placed) -> float:
        """Mean square left by a model with other effects, fitted from its values; infinite if that fails."""
        try:
            state = with_effects(whole.state, whole.weighting, placed)
            return _excess(fitted(state, whole.weighting, _ITERATIONS), floor)
        except (SettingError, np.linalg.LinAlgError, OverflowError):
            return math.inf

    item = whole.state.placed[known]
    # A refinement of the effect would take its place, as presliding friction takes that of Coulomb friction.
    others = tuple(x for x in whole.state.placed if x is not item and not x.contains(item.key))
    if own <= 0 or item.effect.name in _FIRST_TERMS:
        return LackOfFit()
    least, law = math.inf, None
    for tried in _laws(item, whole):
        if (after := left(*others, tried)) < least:
            least, law = after, tried
    if law is None or least >= THRESHOLDS.outdone * own:
        return LackOfFit(share=1.0 if law is None else least / own)
    without, both = left(*others), left(*whole.state.placed, law)
    if not math.isfinite(without) or not math.isfinite(both):
        return LackOfFit()
    # Where much else is missing, a law may explain more of that. The effect is then as good beside the law.
    kept = (least - both) / max(without - own, np.finfo(float).tiny)
    assert isinstance(law.effect, NonparametricLaw)
    return LackOfFit(law.effect.of, least / own) if kept < THRESHOLDS.stands_in else LackOfFit()


def _laws(item: Placed, fit: Fit) -> Iterator[Placed]:
    """Laws without a shape at the place of an effect, or at the drives for one elsewhere, as far as rows suffice."""
    prediction = fit.state.prediction
    places = [item.at] if item.at in prediction.joints else sorted(prediction.record.driven_bodies)
    for place in places:
        for law in _LAWS:
            if fit.n_rows >= _ROWS_PER_VALUE * len(law.amplitudes):
                yield Placed(law, place, (), (0.0,) * len(law.amplitudes))


def _excess(fit: Fit, floor: FloatArray) -> float:
    """Cross-validated mean square above the noise, mean of the outputs; `floor` is that of one model for all."""
    squares = fit.blocks.squares.sum(axis=1) / int(fit.weighting.kept.sum())
    return float(np.mean(squares / floor)) - 1.0
