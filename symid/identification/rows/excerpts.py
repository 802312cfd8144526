"""Logs as blocks of one observation, and excerpts of long logs on which an estimate is examined."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log, in_memory
from symid.estimation import LeastSquares, ObservationBlock, estimate, triangular_factors
from symid.identification.rows.noise import noise_levels, noise_of_rows
from symid.identification.rows.observation import Observation, observe
from symid.identification.rows.signal_rows import Rows, SignalRows

Kept = TypeVar("Kept")
Window = Callable[[AnyLog, int, int], Log]
"""Part of a log between two indices."""

_MOST_SAMPLES = 65_536
"""Samples of all logs together on which an estimate is checked: more would cost time and change little."""
_PARTS = 4  # of a long log, evenly spread


@dataclass(frozen=True, eq=False)
class Excerpt:
    """A part of a log with its observation, or a short log as a whole. Checks share its results, each computed once."""

    model: GeneratedModel
    """The model observed."""
    log: Log
    """The part."""
    observation: Observation
    """Its rows, prepared as those of the whole log."""
    of: int
    """Number of the log."""
    _kept: dict[object, Any] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def levels(self) -> dict[str, float]:
        """Noise of each signal, as `noise_levels`."""
        return noise_levels(self.model, self.log)

    def noise_of(self, name: str) -> float:
        """Standard deviation of the noise of a signal."""
        return math.sqrt(self.levels[name] * self.log.sampling_frequency / 2)

    @cached_property
    def noise(self) -> FloatArray:
        """Covariance of the noise of one row, as `noise_of_rows`."""
        return noise_of_rows(self.model, self.log, self.observation.preparation, self.levels)

    def moved(self, *names: str) -> SignalRows:
        """The part of the rows that some signals make."""
        return self.kept(
            names, lambda: SignalRows.of(self.model, self.log, self.observation.preparation, *names)
        )

    def made_by(self, name: str, *courses: FloatArray) -> list[Rows]:
        """W and y that each course of a signal makes in place of the recorded one, prepared as that is."""
        return list(zip(*self.moved(name).of_courses(np.stack(courses)), strict=True))

    def kept(self, key: object, computed: Callable[[], Kept]) -> Kept:
        """Cached result of a key, computed at the first call."""
        if key not in self._kept:
            self._kept[key] = computed()
        found: Kept = self._kept[key]
        return found


def excerpts(
    model: GeneratedModel,
    logs: Sequence[AnyLog],
    observations: Sequence[Observation],
    window: Window = lambda log, start, stop: log.window(start, stop),
) -> tuple[Excerpt, ...]:
    """Evenly spread parts of each long log in which rows are used, and short logs as they are.

    Parameters
    ----------
    model : GeneratedModel
        The model observed.
    logs, observations : sequence of logs and of Observation
        The logs, and what was made of them; of a long log, its first block.
    window : callable
        Takes a log, a first and a last index, and returns that part of it, which may be shared between calls.
    """
    most = max(_MOST_SAMPLES // len(logs), _MOST_SAMPLES // 16)
    return tuple(
        part
        for k, (log, whole) in enumerate(zip(logs, observations, strict=True))
        for part in (
            (_all_of(model, log, whole, k),)
            if log.n_samples <= most
            else _parts(model, partial(window, log), log, whole, k, most)
        )
    )


def _all_of(model: GeneratedModel, log: AnyLog, whole: Observation, number: int) -> Excerpt:
    if isinstance(log, Log):
        return Excerpt(model, log, whole, number)
    read = in_memory(log)
    return Excerpt(model, read, observe(model, read, whole.preparation), number)


def _parts(
    model: GeneratedModel,
    window: Callable[[int, int], Log],
    log: AnyLog,
    whole: Observation,
    number: int,
    most: int,
) -> tuple[Excerpt, ...]:
    chosen = replace(whole.preparation, trim=None)  # each part has its ends
    size = most // _PARTS

    def part(start: int) -> Excerpt:
        own = window(start, start + size)
        return Excerpt(model, own, observe(model, own, chosen, highest=whole.highest), number)

    # Of a log that mostly stands, parts are looked for more densely until some hold rows.
    n_parts = _PARTS
    found: list[Excerpt] = []
    while not found and n_parts * size < 2 * log.n_samples:
        starts = np.linspace(0, log.n_samples - size, n_parts).astype(int).tolist()
        found = [one for one in map(part, starts) if one.observation.valid.any()]
        n_parts *= 2
    return tuple(found[:_PARTS]) or (_all_of(model, log, whole, number),)


def running_integral(x: FloatArray, period: float) -> FloatArray:
    """Integral of a sampled signal from its first sample on, by trapezoids.

    >>> running_integral(np.array([0.0, 2.0, 2.0]), 0.5).tolist()
    [0.0, 0.5, 1.5]
    """
    return period * np.cumsum(np.concatenate([[0.0], (x[1:] + x[:-1]) / 2]))


def course_of(parts: Sequence[Excerpt], part: Excerpt) -> FloatArray:
    """Time of the rows of a part within its log, from -0.5 at the first row of its parts to 0.5 at their last."""
    times = np.concatenate([other.observation.time for other in parts if other.of == part.of])
    return np.asarray((part.observation.time - times.min()) / np.ptp(times) - 0.5)


def share_of_rows(parts: Sequence[Excerpt], rows: Sequence[int]) -> tuple[float, ...]:
    """Ratio of the rows of a log, `rows`, to the rows of its parts, for each part.

    A sum over the rows of the parts, times this ratio, estimates the sum over all rows; a log without rows adds none.
    """
    n_logs = parts[-1].of + 1
    seen = [sum(int(p.observation.valid.sum()) for p in parts if p.of == k) for k in range(n_logs)]
    whole = np.reshape(rows, (n_logs, -1)).sum(axis=1).tolist()
    return tuple(whole[p.of] / seen[p.of] if seen[p.of] else 0.0 for p in parts)


def blocks_of(
    observations: Sequence[Observation], instruments: Sequence[FloatArray] | None = None
) -> list[ObservationBlock]:
    """Observations as blocks; each log has separate equations. Instruments have the shape of W."""
    every: Sequence[FloatArray | None] = instruments or [None] * len(observations)
    return [
        block_of(seen, k, instruments=Z) for k, (seen, Z) in enumerate(zip(observations, every, strict=True))
    ]


def estimate_of(observations: Iterable[Observation | ObservationBlock]) -> LeastSquares:
    """Weighted least squares of the used rows; every equation of every observation has its own weight."""
    return estimate([factor for o in observations for factor in triangular_factors(o.W, o.y, o.valid)])


def estimate_of_parts(parts: Sequence[Excerpt]) -> LeastSquares:
    """Weighted least squares of the rows of excerpts, computed once."""
    return parts[0].kept((estimate_of, *parts), lambda: estimate_of(part.observation for part in parts))


def block_of(
    seen: Observation, number: int, *, continues: bool = False, instruments: FloatArray | None = None
) -> ObservationBlock:
    """Rows of log `number`, which has separate equations, as a block that starts the log or continues it."""
    return ObservationBlock(seen.W, seen.y, seen.valid, continues, instruments, number * seen.W.shape[0])
