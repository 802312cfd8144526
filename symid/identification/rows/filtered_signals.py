"""Recorded signals of a log, low-passed and moved in time for its rows."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import SHORT_LOG, Log
from symid.identification.rows.settings import Preparation
from symid.signal_processing import LowPass, QuinticSpline, ZeroPhaseFilter

_WIDEST = 0.4
"""Highest cutoff of a widened filter, over the sampling frequency."""


@dataclass(frozen=True, eq=False)
class Filtered:
    """A recorded signal that is filtered, and moved in time, where it is read: no copy of the whole is kept."""

    recorded: FloatArray  # shape (n,): the signal; of shape (n_courses, n) `at` sparse places alone
    low_pass: ZeroPhaseFilter | None  # what it passes
    earlier: float = 0.0  # samples by which it is moved to an earlier time
    held: float = 0.0  # samples for which it is held, over which it is averaged

    @property
    def size(self) -> int:
        """Number of samples of the recorded signal."""
        n_samples: int = self.recorded.shape[-1]
        return n_samples

    @property
    def is_low_passed(self) -> bool:
        """Whether it passes a filter and is not moved."""
        return self.low_pass is not None and not (self.earlier or self.held)

    def __getitem__(self, part: slice) -> FloatArray:
        first, last, _ = part.indices(self.size)
        return self._short[first:last] if self.size <= SHORT_LOG else self._read(first, last)

    @cached_property
    def _short(self) -> FloatArray:
        return self._read(0, self.size)  # rows of several kinds are made of it

    def at(self, places: slice) -> FloatArray:
        """Values at sparse places, without filtering all samples where that is possible."""
        if self.low_pass is None or not self.is_low_passed:
            return self[places.start : places.stop][:: places.step]
        low = max(places.start - self.low_pass.reach, 0)
        high = min(places.stop + self.low_pass.reach, self.size)
        kept = slice(places.start - low, places.stop - low, places.step)
        rows = np.atleast_2d(self.recorded)[:, low:high]
        return self.low_pass.apply_thinned(rows, kept).reshape(*self.recorded.shape[:-1], -1)

    def _read(self, first: int, last: int) -> FloatArray:
        reach = self.low_pass.reach if self.low_pass else 0
        moved = bool(self.earlier or self.held)
        reach += QuinticSpline.reach(abs(self.earlier) + self.held) if moved else 0
        low, high = max(first - reach, 0), min(last + reach, self.size)
        values = self.recorded[low:high]
        if self.low_pass:
            values = self.low_pass.apply(values)
        if moved:
            values = QuinticSpline(values).mean_earlier(self.earlier, self.held)
        return values[first - low : last - low]


Signal = FloatArray | Filtered


def low_pass_of(chosen: Preparation, widening: float, sampling_frequency: float) -> LowPass:
    """Low-pass of signals before they are differentiated."""
    assert chosen.cutoff_hz is not None
    cutoff = max(chosen.cutoff_hz, min(widening * chosen.cutoff_hz, _WIDEST * sampling_frequency))
    return LowPass(cutoff, chosen.order)


def filtered(
    model: GeneratedModel, log: Log, chosen: Preparation, widening: float, names: Iterable[str]
) -> dict[str, Filtered]:
    """Low-passed signals at the times at which they were; forces are filtered only if the preparation filters them."""
    rate = log.sampling_frequency
    low_pass = low_pass_of(chosen, widening, rate).run_over(log.n_samples, rate)
    found: dict[str, Filtered] = {}
    for name in names:
        passes = low_pass if chosen.filter_force or name not in model.forces else None
        earlier = chosen.late.get(name, 0.0) / log.sampling_period
        held = chosen.hold / log.sampling_period if name in model.forces else 0.0
        found[name] = log.kept(
            (name, passes, earlier, held), partial(Filtered, log[name], passes, earlier, held)
        )
    return found
