"""Logs as rows in blocks: a log in memory is one block, a long one is read and prepared window by window.

Whatever `identify` needs of a whole log is one of three things.

- *Sums over rows*: triangular factors, the refinement and the covariance of a correlated residual. They are added up
  block by block. A long log's rows are made again for each of them, since W is larger than the log, unless after
  decimation there are no more of them than samples in a block.
- *Local operations*: filters, differences, shifts in time, laws, decimation, standstill. A recursive filter forgets:
  a window that reaches as far to either side as its filters do gives the rows of the whole log, to rounding. Rows of a
  block are cut out of those of a wider window; at the ends of the log the window ends where the log does.
- *Statistics of the log*: spectra from which the cutoff is chosen, and the examination of timing and bias. They
  are taken from evenly spread windows, as they are of a log in memory above a million and above 65 536 samples. The
  highest speed, which defines standstill, is found by a pass over all blocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log, LongLog, spans
from symid.estimation import ObservationBlock, TriangularFactor
from symid.identification.rows.bands import completed
from symid.identification.rows.excerpts import block_of
from symid.identification.rows.observation import (
    Observation,
    highest_speeds,
    observe,
    trimmed_ends,
    without_levels,
)
from symid.identification.rows.settings import Preparation
from symid.identification.rows.usable_rows import reaches
from symid.signal_processing import kept_indices


@dataclass(frozen=True, eq=False)
class Run:
    """The rows of a log in blocks."""

    # all rows of a log in memory; those of the first block of a long log. Its preparation is that of the whole
    observation: Observation
    # returns the blocks in time order, from the start each time it is called
    read: Callable[[], Iterable[Observation]]
    # returns the run without friction of given levels beside the drives; this one can no longer be used
    without: Callable[[tuple[float, ...]], Run]
    n_rows: int  # of all blocks

    @classmethod
    def of(
        cls, model: GeneratedModel, log: AnyLog, preparation: Preparation, *, friction: bool = False
    ) -> Run:
        """Blocks of a log; parameters and errors as those of `observe`."""
        if isinstance(log, Log):
            return cls._in_memory(model, observe(model, log, preparation, friction=friction))
        return cls._in_blocks(replace(_settled(model, log, preparation), friction=friction))

    @classmethod
    def again(cls, model: GeneratedModel, log: AnyLog, seen: Observation) -> Run:
        """Blocks of a log whose rows, or those of its first block, are known."""
        if isinstance(log, Log):
            return cls._in_memory(model, seen)
        return cls.of(model, log, seen.preparation)

    @classmethod
    def _in_memory(cls, model: GeneratedModel, whole: Observation) -> Run:
        return cls(
            whole,
            lambda: (whole,),
            lambda levels: cls._in_memory(model, without_levels(model, whole, levels)),
            whole.time.size,
        )

    @classmethod
    def _in_blocks(cls, blocks: _Blocks) -> Run:
        if blocks.layout.n_rows <= blocks.log.block:
            every = [blocks.observation(i) for i in range(len(blocks.rows))]
            return cls._in_memory(blocks.model, _joined(every))
        first = blocks.observation(0)

        def without(levels: tuple[float, ...]) -> Run:
            chosen = replace(blocks.chosen, coulomb=levels)
            return cls._in_blocks(replace(blocks, chosen=chosen, friction=False))

        return cls(
            first,
            lambda: chain((first,), map(blocks.observation, range(1, len(blocks.rows)))),
            without,
            blocks.layout.n_rows,
        )

    def factors(self) -> tuple[TriangularFactor, ...]:
        """Triangular factor of each equation, with the columns of friction beside drives if there are any."""
        found: list[TriangularFactor] = []
        for seen in self.read():
            W = seen.W if seen.with_friction is None else seen.with_friction
            found = found or [TriangularFactor.empty(W.shape[2])] * len(W)
            found = [f.update(*rows) for f, *rows in zip(found, W, seen.y, seen.valid, strict=True)]
        return tuple(found)


def blocks_of_runs(runs: Sequence[Run]) -> Iterator[ObservationBlock]:
    """Blocks of all runs; every equation of every log is a separate equation."""
    for k, run in enumerate(runs):
        for i, seen in enumerate(run.read()):
            yield block_of(seen, k, continues=i > 0)


@dataclass(frozen=True)
class _Layout:
    """Positions of the rows of a long log.

    Samples trimmed at the ends, samples that become one row, samples of the log, and those on either side that filtered
    signals, and rows made of them, need.
    """

    before: int
    after: int
    factor: int
    n_samples: int
    signal_reach: int
    row_reach: int

    @property
    def n_rows(self) -> int:
        """Number of rows of the log."""
        return -(-(self.n_samples - self.before - self.after) // self.factor)

    def window(self, first: int, stop: int) -> tuple[int, int]:
        """Samples on which filtered signals from sample `first` to before `stop` depend."""
        return max(first - self.signal_reach, 0), min(stop + self.signal_reach, self.n_samples)

    def widened(self, first: int, stop: int) -> tuple[int, int]:
        """Rows from `first` to before `stop`, extended by the rows that the row filter needs."""
        more = math.ceil(self.row_reach / self.factor)
        return max(first - more, 0), min(stop + more, self.n_rows)

    def samples(self, first: int, stop: int) -> tuple[int, int]:
        """Samples that become the rows from `first` to before `stop`: the last of them is kept."""
        offset = self.before + kept_indices(self.n_samples - self.before - self.after, self.factor).start
        begin = offset + (first - 1) * self.factor + 1 if first else self.before
        return begin, offset + (stop - 1) * self.factor + 1


@dataclass(frozen=True, eq=False)
class _Blocks:
    """A long log with the settings that all of its blocks share."""

    model: GeneratedModel
    log: LongLog
    chosen: Preparation
    layout: _Layout
    speeds: FloatArray | None
    friction: bool = False

    @cached_property
    def rows(self) -> list[tuple[int, int]]:
        """First row of each block, and the one after the last."""
        return list(spans(self.layout.n_rows, max(1, self.log.block // self.layout.factor)))

    def observation(self, block: int) -> Observation:
        """Rows of a block, cut out of those of a wider window."""
        first, stop = self.rows[block]
        wide_first, wide_stop = self.layout.widened(first, stop)
        window, cut = _window(self.log, self.chosen, self.layout, *self.layout.samples(wide_first, wide_stop))
        seen = observe(self.model, window, cut, highest=self.speeds, friction=self.friction)
        rows = slice(first - wide_first, stop - wide_first)
        more = None if seen.with_friction is None else seen.with_friction[:, rows]
        return Observation(
            seen.W[:, rows],
            seen.y[:, rows],
            seen.valid[:, rows],
            seen.time[rows],
            self.chosen,
            more,
            seen.highest,
        )


def _joined(blocks: Sequence[Observation]) -> Observation:
    """The rows of consecutive blocks; W is a part of the columns with friction, from which `without` takes that off."""
    whole = [seen.W if seen.with_friction is None else seen.with_friction for seen in blocks]
    W = np.concatenate([rows.transpose(0, 2, 1) for rows in whole], axis=2).transpose(0, 2, 1)
    return replace(
        blocks[0],
        W=W[..., : blocks[0].W.shape[2]],
        y=np.concatenate([seen.y for seen in blocks], axis=1),
        valid=np.concatenate([seen.valid for seen in blocks], axis=1),
        time=np.concatenate([seen.time for seen in blocks]),
        with_friction=None if blocks[0].with_friction is None else W,
    )


def _settled(model: GeneratedModel, log: LongLog, given: Preparation) -> _Blocks:
    chosen = completed(given, log, model)
    before, after = trimmed_ends(chosen, log.n_samples)
    factor = chosen.decimation or 1
    layout = _Layout(before, after, factor, log.n_samples, *reaches(model, chosen, log.sampling_period))
    speeds = None
    if any(model.sliding) and chosen.standstill is None:
        speeds = _highest_speeds(model, log, chosen, layout)
    return _Blocks(model, log, chosen, layout, speeds)


def _window(
    log: LongLog, chosen: Preparation, layout: _Layout, begin: int, end: int
) -> tuple[Log, Preparation]:
    """Samples that filtered signals from `begin` to before `end` need, and a preparation that trims to these."""
    low, high = layout.window(begin, end)
    return log.window(low, high), replace(chosen, trim=(begin - low, high - end))


def _highest_speeds(model: GeneratedModel, log: LongLog, chosen: Preparation, layout: _Layout) -> FloatArray:
    before = layout.before
    highest = [
        highest_speeds(model, *_window(log, chosen, layout, before + first, before + stop))
        for first, stop in spans(log.n_samples - before - layout.after, log.block)
    ]
    return np.asarray(np.max(highest, axis=0))
