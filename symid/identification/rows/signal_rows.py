"""The part of the rows of a log that some signals make, as they are, moved in time, or of another course."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.identification.rows.filtered_signals import Filtered, Signal, filtered
from symid.identification.rows.noise import coefficients
from symid.identification.rows.sampling import Sampling, linear_part, sampled_rows
from symid.identification.rows.settings import Preparation, Scheme
from symid.signal_names import split_derivative
from symid.signal_processing import QuinticSpline

Rows = tuple[FloatArray, FloatArray]
"""Rows of W and y that a signal makes, as in `Observation`."""
_STEP = 0.25
"""Half the shift between the signals whose difference is the derivative by their time, in samples."""


@dataclass(frozen=True, eq=False)
class SignalRows:
    """Contribution of some signals to the rows of a log, to which rows are linear, and its change under a delay."""

    sampling: Sampling  # of these signals; all others are 0
    flat: tuple[str, ...]  # flat names of these signals and of their derivatives in the model
    # shape (n_equations, n_columns + 1, n_flat): of these, in W and y
    factors: FloatArray

    @classmethod
    def of(cls, model: GeneratedModel, log: Log, chosen: Preparation, *names: str) -> SignalRows:
        """Rows from the filtered signals of a log; the preparation is the complete one of its observation."""
        before, after = chosen.trim or (0, 0)
        own = filtered(model, log, chosen, 1.0, names)
        rest = log.n_samples - before - after
        scheme = Scheme(chosen.difference_order)
        flat, factors = _factors(model, names)
        return cls(Sampling(model, chosen, scheme, log.sampling_period, own, {}, before, rest), flat, factors)

    @cached_property
    def rows(self) -> Rows:
        """Rows of W and y of the window."""
        return self._rows(self.sampling.signals)

    def change(self, late: float) -> Rows:
        """Change of W and y if the signals are moved `late` seconds to an earlier time."""
        signals = self.sampling.signals
        return self._moved(lambda name, kept: self._earlier(name, late, kept) - signals[name][:][kept])

    @cached_property
    def slope(self) -> Rows:
        """Derivative of W and y by `late`, per second, by central differences over a part of a sample."""
        step = _STEP * self.sampling.period
        return self._moved(
            lambda name, kept: (
                (self._earlier(name, step, kept) - self._earlier(name, -step, kept)) / (2 * step)
            )
        )

    def of_courses(self, courses: FloatArray) -> Rows:
        """Rows that courses of the only signal, shape (n_courses, n_samples), make if prepared alike, by course."""
        ((name, own),) = self.sampling.signals.items()
        assert isinstance(own, Filtered)
        if self._needs_kept_alone and own.is_low_passed:
            return self._rows({name: replace(own, recorded=courses)})
        every = [self._rows({name: replace(own, recorded=course)}) for course in courses]
        return np.stack([W for W, _ in every]), np.stack([y for _, y in every])

    @property
    def _needs_kept_alone(self) -> bool:
        """Whether rows need no other samples of the signals than those that are kept."""
        sampling = self.sampling
        return sampling.is_sparse and not any(map(sampling.model.highest_derivatives.get, sampling.signals))

    @cached_property
    def _splines(self) -> dict[str, QuinticSpline]:
        return {name: QuinticSpline(x[:]) for name, x in self.sampling.signals.items()}

    def _earlier(self, name: str, late: float, kept: slice) -> FloatArray:
        return self._splines[name].earlier(late / self.sampling.period, kept)

    def _moved(self, values: Callable[[str, slice], FloatArray]) -> Rows:
        """Rows that samples of each signal make, which are made for those that are kept alone if that is enough."""
        sampling = self.sampling
        if self._needs_kept_alone:
            return self._made({name: values(name, sampling.kept) for name in sampling.signals})
        return self._rows({name: values(name, slice(None)) for name in sampling.signals})

    def _rows(self, signals: Mapping[str, Signal]) -> Rows:
        sampling = replace(self.sampling, signals=signals)
        if sampling.model.known_laws:
            moved, y = sampled_rows(replace(sampling, model=linear_part(sampling.model)))
            return moved.transpose(0, 2, 1), y
        return self._made(sampling.thinned())

    def _made(self, thinned: Mapping[str, FloatArray]) -> Rows:
        made = self.factors @ np.stack([thinned[name] for name in self.flat], axis=-2)[..., None, :, :]
        return made[..., :-1, :].swapaxes(-1, -2), made[..., -1, :]


@lru_cache(maxsize=64)  # every excerpt asks for them
def _factors(model: GeneratedModel, names: tuple[str, ...]) -> tuple[tuple[str, ...], FloatArray]:
    """Flat names of signals in a model, and their factors in W and y."""
    mine = [i for i, flat in enumerate(model.signals) if split_derivative(flat)[0] in names]
    return tuple(model.signals[i] for i in mine), coefficients(model)[..., mine]
