"""Prior knowledge of physical parameters: bounds that they keep, and priors with a deviation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.errors import SettingError
from symid.files import is_finite_number, shortened

Bounds = Mapping[str, tuple[float | None, float | None]]
Priors = Mapping[str, tuple[float, float]]

Made = TypeVar("Made")

_SHARPEST, _SMALLEST = 1e-13, 1e-100
"""Least relative and absolute deviation of a prior: its inverse square must not overflow."""


@dataclass(frozen=True)
class Constraints:
    """Bounds and priors of physical parameters, SI."""

    bounds: Bounds = field(default_factory=dict)
    """Lowest and highest value; None for no bound."""
    prior: Priors = field(default_factory=dict)
    """Mean and standard deviation of the prior."""

    def __bool__(self) -> bool:
        return bool(self.bounds or self.prior)

    @classmethod
    def of(cls, model: GeneratedModel, bounds: Bounds | str | None, prior: Priors | None) -> Constraints:
        """Checked constraints of a model; ``bounds="physical"`` keeps all that must not be negative from being so.

        SettingError if a parameter is not one of the model, or a value is not possible.
        """
        if isinstance(bounds, str):
            if bounds != "physical":
                raise SettingError(
                    f"bounds {bounds!r} are not known: give 'physical', or low and high by parameter"
                )
            bounds = {name: (0.0, None) for name in model.physical_units if name not in model.signed}
        faults: list[str] = []
        given = cls(
            dict(_checked(_bounds, bounds or {}, faults)), dict(_checked(_prior, prior or {}, faults))
        )
        named = dict.fromkeys((*(bounds or {}), *(prior or {})))
        if strange := [name for name in named if name not in model.physical_units]:
            known = " (its value is known)" if strange[0] in model.known else ""
            which = "is not an unknown parameter" if len(strange) == 1 else "are no unknown parameters"
            faults.append(
                f"{', '.join(map(repr, strange))} {which} of axis {model.axis!r}{known}: "
                f"choose from {', '.join(model.physical_units)}"
            )
        highest = {name: high for name, (_, high) in given.bounds.items() if high is not None}
        for name, value in (*highest.items(), *((name, mean) for name, (mean, _) in given.prior.items())):
            if value < 0 and name in model.physical_units and name not in model.signed:
                claim = "bounds say" if name in highest else "prior says"
                faults.append(
                    f"{name} is at least 0 by its declaration, and its {claim} {value:g}: give SI values above 0"
                )
        if faults:
            raise SettingError("; ".join(faults))
        return given

    def ranges(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest values of parameters, infinite without a bound."""
        pairs = [self.bounds.get(name, (None, None)) for name in names]
        low = [-np.inf if pair[0] is None else pair[0] for pair in pairs]
        high = [np.inf if pair[1] is None else pair[1] for pair in pairs]
        return np.array(low, dtype=float), np.array(high, dtype=float)

    def means(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Means of priors, 0 without one, and the inverse of their deviations, 0 without one."""
        pairs = [self.prior.get(name, (0.0, math.inf)) for name in names]
        return np.array([mean for mean, _ in pairs]), np.array([1 / deviation for _, deviation in pairs])


def _checked(
    make: Callable[[str, object], Made], values: Mapping[str, object], faults: list[str]
) -> Iterator[tuple[str, Made]]:
    """What is made of the values by parameter; the faults of others are added."""
    for name, value in values.items():
        try:
            yield name, make(name, value)
        except SettingError as fault:
            faults.append(str(fault))


def _bounds(name: str, value: object) -> tuple[float | None, float | None]:
    low, high = _pair(name, value, "bounds", "low and high")
    if low is not None and high is not None and not low < high:
        raise SettingError(f"bounds of {name}: {low:g} is not below {high:g}")
    return low, high


def _pair(name: str, value: object, what: str, meaning: str) -> tuple[float | None, float | None]:
    fits = isinstance(value, (tuple, list)) and len(value) == 2
    if not (fits and all(one is None or is_finite_number(one) for one in value)):  # type: ignore[attr-defined]
        raise SettingError(
            f"{what} of {name} are {shortened(value)}: give a pair of numbers, {meaning}, in SI units"
        )
    pair: tuple[float | None, float | None] = (value[0], value[1])  # type: ignore[index]
    return None if pair[0] is None else float(pair[0]), None if pair[1] is None else float(pair[1])


def _prior(name: str, value: object) -> tuple[float, float]:
    mean, deviation = _pair(name, value, "mean and deviation of the prior", "mean and deviation")
    if mean is None or deviation is None or deviation <= 0:
        raise SettingError(
            f"the prior of {name} is {shortened(value)}: give its mean and a deviation above 0, in SI units"
        )
    if deviation < max(_SHARPEST * abs(mean), _SMALLEST):
        raise SettingError(
            f"the prior of {name} has a deviation of {deviation:g}, finer than numbers are: give the value as known "
            f"(`fixed` {name}={mean:g})"
        )
    return mean, deviation
