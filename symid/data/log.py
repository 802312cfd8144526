"""The record of one run of a machine: measured signals on one uniform clock."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray, read_only
from symid.data.frames import Frame, uniform
from symid.errors import LogError, SettingError
from symid.shown import Shown

if TYPE_CHECKING:
    import polars as pl

Kept = TypeVar("Kept")

SHORT_LOG = 65_536
"""Samples of a log up to which intermediate results of its length are kept."""
_MOST_KEPT = 16
_LARGEST = 1e30
"""Magnitude above which a value marks a missing one or an unstable simulation; its powers would overflow."""


@dataclass(frozen=True, eq=False, repr=False)
class Log(Shown):
    """Signals of one run in SI units, uniformly sampled.

    Parameters
    ----------
    source : str
        Where the signals come from: the path of the file or a word of the caller.
    start : float
        Time of the first sample, s.
    sampling_period : float
        Time between two samples, s.
    signals : Mapping of str to array of shape (n_samples,)
        Values of each signal, SI, 64 bit. The record keeps read-only views and makes no copy.
    notes : tuple of str
        Irregularities of the data that do not prevent its use; each names the channel and the time.

    Raises
    ------
    LogError
        If the log has no signals, one is not a vector, lengths differ, or the sampling period is not positive.

    Examples
    --------
    >>> log = Log.from_arrays({"q": [0.0, 0.1, 0.4], "F": [1.0, 1.0, 0.0]}, sampling_period=0.5)
    >>> log.n_samples, log.sampling_frequency, log.time.tolist()
    (3, 2.0, [0.0, 0.5, 1.0])
    >>> log.window(1, 3)["q"].tolist()
    [0.1, 0.4]
    """

    source: str
    start: float
    sampling_period: float
    signals: Mapping[str, FloatArray]
    notes: tuple[str, ...] = ()
    _kept: dict[Hashable, Any] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sampling_period) and self.sampling_period > 0.0):
            raise LogError(
                f"{self.source}: sampling period {self.sampling_period:g} s is impossible: it must be > 0"
            )
        signals = {name: read_only(values) for name, values in self.signals.items()}
        if not signals:
            raise LogError(f"{self.source}: the log has no signals: give at least one")
        for name, values in signals.items():
            if values.ndim != 1 or values.size == 0:
                shape = f"signal {name!r} has shape {values.shape}"
                raise LogError(f"{self.source}: {shape}: a vector of samples is required")
        if len({values.size for values in signals.values()}) > 1:
            lengths = ", ".join(f"{name} {values.size}" for name, values in signals.items())
            raise LogError(
                f"{self.source}: the signals differ in length ({lengths}): give as many samples of each"
            )
        object.__setattr__(self, "signals", MappingProxyType(signals))
        object.__setattr__(self, "notes", tuple(self.notes))

    def __reduce__(self) -> tuple[Any, ...]:
        # A mapping proxy cannot be pickled; building the record also makes the arrays read-only again.
        return (Log, (self.source, self.start, self.sampling_period, dict(self.signals), self.notes))

    @property
    def headline(self) -> str:
        """Summary: signals, number of samples and rate."""
        rate = f"{self.n_samples} samples at {self.sampling_frequency:g} Hz"
        return f"{self.source}: {', '.join(self.signals)}, {rate}"

    @classmethod
    def from_arrays(
        cls,
        signals: Mapping[str, npt.ArrayLike],
        *,
        sampling_period: float,
        start: float = 0.0,
        source: str = "arrays",
    ) -> Log:
        """Log of copies of the given arrays, which must be in SI units.

        Parameters
        ----------
        signals : Mapping of str to array_like of shape (n_samples,)
            Values of each signal.
        sampling_period : float
            Time between two samples, s.
        start : float
            Time of the first sample, s.
        source : str
            Name of the data in messages and results.

        Raises
        ------
        LogError
            If values are not finite real numbers, lengths differ, or the sampling period is not positive.
        """
        return cls(
            source=source,
            start=start,
            sampling_period=sampling_period,
            signals={name: _finite_copy(source, name, values) for name, values in signals.items()},
        )

    @classmethod
    def from_frame(
        cls,
        frame: Frame,
        *,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        gains: Mapping[str, float] | None = None,
        sampling_period: float | None = None,
        source: str = "frame",
    ) -> Log:
        """Log of a data frame: a column for each signal, in the unit of its header or SI, and one of the time.

        Parameters
        ----------
        frame : data frame or mapping of str to array
            Of pandas, polars, pyarrow or columns by name, such as ``t``, ``q`` and ``F [kN]``. Columns without numbers
            are left out with a note. Moments and durations become seconds.
        columns, units, gains : mapping, optional
            Column, unit and factor by signal, as in `symid.read_log`.
        sampling_period : float, optional
            Time between two samples, s, of a frame without a column of the time.
        source : str
            Name of the data in messages and results.

        Raises
        ------
        LogError
            If the clock is not uniform, a value is not finite, or a unit is not known or depends on what is measured
            (`symid.read_axis_log` knows that).

        Examples
        --------
        >>> log = Log.from_frame({"Time [ms]": range(30), "q [mm]": range(30)}, columns={"t": "Time"})
        >>> log.sampling_period, log["q"][:3].tolist()
        (0.001, [0.0, 0.001, 0.002])
        """
        columns_si, clock = uniform(
            frame, columns=columns, units=units, gains=gains, sampling_period=sampling_period, source=source
        )
        signals = {name: _finite_copy(source, name, values) for name, values in columns_si.items()}
        return cls(source, clock.start, clock.period, signals, clock.notes)

    def to_frame(self) -> pl.DataFrame:
        """A polars data frame with a column ``t`` of the time, s, and one for each signal, SI.

        Its ``to_pandas`` and ``to_arrow`` give those of other libraries.

        Examples
        --------
        >>> Log.from_arrays({"q": [0.0, 0.1]}, sampling_period=0.5).to_frame().rows()
        [(0.0, 0.0), (0.5, 0.1)]
        """
        import polars as pl

        return pl.DataFrame({"t": self.time, **self.signals})

    @property
    def n_samples(self) -> int:
        """Number of samples of each signal."""
        return next(iter(self.signals.values())).size

    @property
    def sampling_frequency(self) -> float:
        """Samples per second, Hz."""
        return 1.0 / self.sampling_period

    @property
    def time(self) -> FloatArray:
        """Time of each sample, s, shape (n_samples,)."""
        return self.start + self.sampling_period * np.arange(self.n_samples, dtype=np.float64)

    def __getitem__(self, name: str) -> FloatArray:
        """Values of one signal, shape (n_samples,), read-only; LogError if the log does not have it."""
        try:
            return self.signals[name]
        except KeyError:
            there = ", ".join(self.signals)
            raise LogError(f"{self.source}: there is no signal {name!r}: the log has {there}") from None

    def kept(self, key: Hashable, computed: Callable[[], Kept]) -> Kept:
        """Value that is computed once per key and cached. The cache holds 16 of them, of a long log none.

        Examples
        --------
        >>> log = Log.from_arrays({"q": [0.0, 0.1]}, sampling_period=0.5)
        >>> [log.kept("length", lambda: 2), log.kept("length", lambda: 3)]
        [2, 2]
        """
        if self.n_samples > SHORT_LOG:
            return computed()
        if key not in self._kept:
            while len(self._kept) >= _MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = computed()
        value: Kept = self._kept[key]
        return value

    def window(self, start_index: int, stop_index: int) -> Log:
        """Part of the log from sample `start_index` to before sample `stop_index`; shares the arrays.

        Raises
        ------
        LogError
            Unless ``0 <= start_index < stop_index <= n_samples``.
        """
        check_window(self.source, start_index, stop_index, self.n_samples)
        return Log(
            source=self.source,
            start=self.start + start_index * self.sampling_period,
            sampling_period=self.sampling_period,
            signals={name: values[start_index:stop_index] for name, values in self.signals.items()},
            notes=self.notes,
        )


def _finite_copy(source: str, name: str, values: npt.ArrayLike) -> FloatArray:
    try:
        array = np.asarray(values)
        if np.iscomplexobj(array):
            raise LogError(f"{source}: signal {name!r} is complex: give real numbers")
        copy = np.array(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise LogError(
            f"{source}: signal {name!r} does not hold numbers: give an array of real numbers"
        ) from error
    bad = np.flatnonzero(~np.isfinite(copy))
    if bad.size:
        raise LogError(
            f"{source}: signal {name!r} has {bad.size} values that are not finite, "
            f"the first at index {bad[0]}: cut them out or repair them"
        )
    if copy.size and np.abs(copy).max() > _LARGEST:
        at = int(np.argmax(np.abs(copy)))
        raise LogError(
            f"{source}: signal {name!r} is {copy[at]:.3g} at index {at}, which no machine reaches: "
            "cut it out or repair it"
        )
    return copy


def require_times_within(source: str, late: Mapping[str, float], duration: float) -> None:
    """SettingError if a signal is late by as much as the duration of a log, s, or more.

    >>> require_times_within("run.csv", {"F": 1e3}, 8.0)
    Traceback (most recent call last):
    ...
    symid.errors.SettingError: run.csv: F is late by 1000 s, and the log takes 8 s: give a time within it, such as 125us
    """
    if name := next((name for name, seconds in late.items() if not abs(seconds) < duration), None):
        raise SettingError(
            f"{source}: {name} is late by {late[name]:g} s, and the log takes {duration:g} s: "
            "give a time within it, such as 125us"
        )


def check_window(source: str, start_index: int, stop_index: int, n_samples: int) -> None:
    """LogError unless samples `start_index` to before `stop_index` are a part of a log of `n_samples`."""
    if not 0 <= start_index < stop_index <= n_samples:
        raise LogError(
            f"{source}: samples {start_index} to {stop_index} are not part of the log: "
            f"choose 0 <= start < stop <= {n_samples}"
        )
