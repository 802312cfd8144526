"""Kinds of damage of the values of a log, and of its columns.

Each takes the good columns, a generator of random numbers, and the extent of the damage between 0 and 1.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.damage.log import Columns
from benchmarks.damage.of_files import Generator

OfColumns = Callable[[Columns, Generator, float], Columns]


OF_COLUMNS: dict[str, OfColumns] = {}


def _kind(damage: OfColumns) -> OfColumns:
    OF_COLUMNS[damage.__name__] = damage
    return damage


def _span(columns: Columns, rng: Generator, extent: float) -> slice:
    n = columns["t"].size
    length = 1 + int(extent * (n - 1))
    start = int(rng.integers(0, n - length + 1))
    return slice(start, start + length)


def _signal(rng: Generator) -> str:
    return str(rng.choice(["q", "F"]))


def _changed(columns: Columns, name: str, part: slice, value: object) -> Columns:
    values = columns[name].copy()
    values[part] = value
    return {**columns, name: values}


@_kind
def nan_run(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Values that are missing."""
    return _changed(columns, str(rng.choice(["t", "q", "F"])), _span(columns, rng, extent), np.nan)


@_kind
def infinite(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A span of one channel is infinite."""
    value = rng.choice([np.inf, -np.inf])
    return _changed(columns, str(rng.choice(["t", "q", "F"])), _span(columns, rng, extent * 0.1), value)


@_kind
def swapped(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Two columns under each other's names."""
    one, other = rng.permutation(["t", "q", "F"])[:2]
    return {**columns, one: columns[other], other: columns[one]}


@_kind
def swapped_midway(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Position and force that change places in a part of the log."""
    part = _span(columns, rng, extent)
    q = _changed(columns, "q", part, columns["F"][part])
    return _changed(q, "F", part, columns["q"][part])


@_kind
def repeated_time(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A time that stands still."""
    part = _span(columns, rng, max(extent, 0.001))
    return _changed(columns, "t", part, columns["t"][part.start])


@_kind
def backward_time(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A time that jumps back, as where a recorder was restarted."""
    start = _span(columns, rng, 0.0).start
    t = columns["t"].copy()
    t[start:] -= 0.002 + extent * t[start]
    return {**columns, "t": t}


@_kind
def reversed_rows(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Part of the rows in backward order."""
    part = _span(columns, rng, max(extent, 0.01))
    return {
        name: np.concatenate([x[: part.start], x[part][::-1], x[part.stop :]]) for name, x in columns.items()
    }


@_kind
def time_jump(columns: Columns, rng: Generator, extent: float) -> Columns:
    """The time jumps once by more than a sampling period."""
    t = columns["t"].copy()
    t[int(rng.integers(1, t.size)) :] += 0.002 + 10 * extent
    return {**columns, "t": t}


@_kind
def lost_rows(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Missing rows, visible in the time."""
    part = _span(columns, rng, extent)
    return {name: np.delete(x, part) for name, x in columns.items()}


@_kind
def lost_rows_untold(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Missing rows with a renumbered time: the position jumps."""
    part = _span(columns, rng, 0.02 + 0.5 * extent)
    fewer = {name: np.delete(x, part) for name, x in columns.items()}
    return {**fewer, "t": np.arange(fewer["q"].size) / 1000.0}


@_kind
def jittering_time(columns: Columns, rng: Generator, extent: float) -> Columns:
    """White noise is added to the times."""
    t = columns["t"] + 2e-3 * extent**2 * rng.standard_normal(columns["t"].size)
    return {**columns, "t": t}


@_kind
def slower_midway(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A sampling period that changes."""
    at, factor = int(rng.integers(100, 2900)), 1.0 + 0.01 + 3 * extent
    t = columns["t"]
    return {**columns, "t": np.where(np.arange(t.size) < at, t, t[at] + factor * (t - t[at]))}


@_kind
def constant(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that never changes."""
    return _changed(columns, str(rng.choice(["t", "q", "F"])), slice(None), rng.normal())


@_kind
def stuck(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that keeps a value for a while."""
    name, part = _signal(rng), _span(columns, rng, 0.1 + 0.9 * extent)
    return _changed(columns, name, part, columns[name][part.start])


@_kind
def clipped(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that is limited."""
    name = _signal(rng)
    limit = np.abs(columns[name]).max() * (1.0 - 0.9 * extent)
    return {**columns, name: np.clip(columns[name], -limit, limit)}


@_kind
def huge(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A few numbers near the end of the range."""
    value = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(20, 308)
    name = str(rng.choice(["t", "q", "F"]))
    return _changed(columns, name, _span(columns, rng, 0.05 * extent), value)


@_kind
def denormal(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel of numbers so small that digits are lost."""
    name = _signal(rng)
    return {**columns, name: columns[name] * 10.0 ** (-290.0 - 33.0 * extent)}


@_kind
def spikes(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Single values far off."""
    name = _signal(rng)
    x = columns[name].copy()
    places = rng.integers(0, x.size, 1 + int(20 * extent))
    x[places] += 10.0 ** rng.uniform(2, 6) * np.ptp(x) * rng.choice([-1.0, 1.0])
    return {**columns, name: x}


@_kind
def overflow(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Integers that wrap around."""
    name = _signal(rng)
    scaled = columns[name] / np.abs(columns[name]).max() * 32768 * (1.1 + 4 * extent)
    wrapped = (np.round(scaled).astype(np.int64) + 32768) % 65536 - 32768
    return {**columns, name: wrapped * np.abs(columns[name]).max() / 32768 / (1.1 + 4 * extent)}


@_kind
def other_unit_midway(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel scaled by 1000 in 5 to 75 % of the log: were it nearly all, only the trimmed ends would tell."""
    name, part = _signal(rng), _span(columns, rng, 0.05 + 0.7 * extent)
    return _changed(columns, name, part, 1000.0 * columns[name][part])


@_kind
def foreign_unit(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A header with a unit that the signal cannot have, or that there is not."""
    name, unit = _signal(rng), rng.choice(["degC", "V", "bananas", "m/s", "", "µ?", "rad", "N*m"])
    return {(f"{key} [{unit}]" if key == name else key): x for key, x in columns.items()}


@_kind
def wrong_unit(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A whole channel in another unit than its header says."""
    name = str(rng.choice(["t", "q", "F"]))
    return {**columns, name: columns[name] * rng.choice([1e-3, 57.3, 1e3, 0.0254])}


@_kind
def opposite_sign(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that counts the other way."""
    name = _signal(rng)
    return {**columns, name: -columns[name]}


@_kind
def white_noise(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that holds nothing but noise."""
    name = _signal(rng)
    return {**columns, name: columns[name].std() * rng.standard_normal(columns[name].size)}


@_kind
def moved(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A channel that is late."""
    return {**columns, "F": np.roll(columns["F"], int(rng.choice([-1, 1])) * (1 + int(300 * extent)))}


@_kind
def few_rows(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Only the first few rows, 60 at most, are left."""
    rows = int(rng.integers(0, 60))
    return {name: x[:rows] for name, x in columns.items()}


@_kind
def booleans(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A column of truth values."""
    name = str(rng.choice(["t", "q", "F"]))
    return {**columns, name: columns[name] > 0}


@_kind
def missing_column(columns: Columns, rng: Generator, extent: float) -> Columns:
    """A column that is not there."""
    missing = rng.choice(["t", "q", "F"])
    return {name: x for name, x in columns.items() if name != missing}


@_kind
def single_precision(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Signals are rounded to 32 bit numbers."""
    return {name: x if name == "t" else x.astype(np.float32) for name, x in columns.items()}


@_kind
def more_columns(columns: Columns, rng: Generator, extent: float) -> Columns:
    """Columns that nobody asked for, of any content."""
    return {"température [µ°]": columns["q"] * np.nan, **columns, "b": np.arange(columns["q"].size)}
