"""Effects and parameters that a diagnosis finds, with their probabilities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symid.diagnosis.findings.gap import Level, Removed
from symid.diagnosis.thresholds import THRESHOLDS


@dataclass(frozen=True)
class EffectParameter:
    """A parameter of an effect that was found."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was accepted."""

    effect: str
    at: str
    """`effect`, `at`: names of the effect and of its place."""
    probability: float
    """Among everything considered at its step."""
    probability_with_ties: float
    """That it, or one of `indistinguishable_from`, is right: one effect at either of two places, for instance."""
    parameters: Mapping[str, EffectParameter]
    """Its parameters, SI."""
    gap_after: Level
    """The gap with this effect and those before it added to the re-identified model."""
    removes: Removed
    """Share of the excess error that it removes on the validation data, after the effects before it."""
    indistinguishable_from: tuple[tuple[str, str], ...]
    """Effects and places that this log does not distinguish from it."""
    signal: str = ""
    """Force whose error `gap_after` is; with several drives, the one that shows the effect most."""
    shown_by: str = ""
    """Signal whose excess `removes` is a share of: this force, or a reading that alone shows the effect."""
    outdone_by: str = ""
    """Quantity a law of which, of any shape, explains clearly more in the place of the first effect: the library may
    lack the law. Empty if there is none."""

    def at_most(self, probability: float) -> FoundEffect:
        """The effect with no higher a probability; it keeps its share of that with its ties."""
        share = min(1.0, probability / max(self.probability, np.finfo(float).tiny))
        return replace(
            self,
            probability=share * self.probability,
            probability_with_ties=share * self.probability_with_ties,
        )


@dataclass(frozen=True)
class Alternative:
    """An effect that was considered."""

    effect: str
    at: str
    """`effect`, `at`: names of the effect and of its place."""
    probability: float
    """Among everything considered."""
    log_likelihood: float
    """Gain of the logarithm of the likelihood over the re-identified model."""
    gap_after: Level | None
    """Error on the identification data with it added; None where it was screened only."""


@dataclass(frozen=True)
class ParameterChange:
    """A physical parameter before and after."""

    name: str
    unit: str
    """`name`, `unit`: the parameter."""
    nominal: float
    """Nominal value, nan if there is none."""
    reidentified: float
    reidentified_std: float
    """`reidentified`, `reidentified_std`: of the declared structure."""
    explained: float
    explained_std: float
    """`explained`, `explained_std`: with the effects found."""
    absorbed: bool
    """Whether it left its interval when the effects were added: it had absorbed them."""
    at_bound: bool = False
    """Whether the fit with the effects ended at its lower bound, which keeps the axis from losing its mass."""

    @property
    def is_negative(self) -> bool:
        """Whether its value is below zero by more than three of its deviations."""
        return self.explained + THRESHOLDS.absorbed_deviations * self.explained_std < 0

    @property
    def is_shown(self) -> bool:
        """Whether its value exceeds its deviation."""
        return self.explained_std < abs(self.explained)

    @property
    def is_far_from_physical(self) -> bool:
        """Whether its value is below zero by many deviations, and by more than its nominal value is above.

        Another cause than the one found then distorts the model, as a late second encoder moves damping from one body
        to the other.
        """
        beyond = self.explained + THRESHOLDS.impossible_deviations * self.explained_std < 0
        return beyond and self.nominal > 0 and -self.explained > self.nominal

    @property
    def is_determined(self) -> bool:
        """Whether the log determines it, and not only a combination with other parameters."""
        return self.explained_std < math.inf
