"""Settings of a batch."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

from symid.axis import Axis
from symid.data import MEMORY, Layout, Rate
from symid.errors import SettingError
from symid.fleet.worker_limits import MOST_SECONDS
from symid.identification import Preparation
from symid.identification.signals import axis_columns
from symid.verbs import method_of

ROW_METHODS = ("wls", "ols")
"""Methods that need only the triangular factors of a log."""


@dataclass(frozen=True)
class BatchSettings:
    """Settings that all logs of a batch share.

    Parameters
    ----------
    method : {"wls", "ols", "iv", "oe"}
        Weighted or ordinary least squares, instrumental variables, or output error.
    measured : tuple of str, optional
        Sensors to use; by default those that each log contains.
    columns, units, gains : mapping of str to str, str, float
        Column, unit and factor of signals in foreign files, as in `symid.read_axis_log`.
    layout, sampling_period, resample
        Properties of foreign files, as in `symid.read_axis_log`.
    preparation : Preparation
        Preprocessing; settings that are not given are chosen for each log.
    held : tuple of str
        Held forces (zero-order hold), in addition to those that axes declare as held.
    ddof : int, optional
        As in `symid.identify`.
    nominal : mapping of str to float, optional
        Nominal physical parameters, SI: initial values of the identification, and the model that is diagnosed.
    bounds : mapping of str to (float or None, float or None)
        Lower and upper bound of physical parameters, None for no bound.
    prior : mapping of str to (float, float)
        Prior mean and standard deviation of physical parameters.
    controller : mapping of str to float
        Gains of the machine's controller by the fields of `symid.simulation.Cascade`, for "iv" and "oe".
    rate_hz : float, optional
        Sampling rate of the controller.
    diagnose : bool
        Whether each log is diagnosed too, which takes seconds per log.
    examine : bool
        Whether timing and bias are examined, see `symid.identify`.
    joint : bool
        Whether rows keep the triangular factors of their logs, a few hundred numbers each, so that the logs of an axis
        can be joined without reading them again; for "wls" and "ols".
    memory : int
        Memory limit of a log in bytes; a longer CSV or Parquet file is identified in blocks by "wls" and "ols".
    seconds : float
        Time limit of a log; a worker that exceeds it is terminated.

    Raises
    ------
    SettingError
        If the method is unknown or does not allow another setting.
    """

    method: Literal["wls", "ols", "iv", "oe"] = "wls"
    measured: tuple[str, ...] | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    gains: Mapping[str, float] = field(default_factory=dict)
    layout: Layout | None = None
    sampling_period: float | None = None
    resample: Rate | None = None
    preparation: Preparation = field(default_factory=Preparation)
    held: tuple[str, ...] = ()
    ddof: int | None = None
    nominal: Mapping[str, float] | None = None
    bounds: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)
    prior: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    controller: Mapping[str, float] = field(default_factory=dict)
    rate_hz: float | None = None
    diagnose: bool = False
    examine: bool = True
    joint: bool = False
    memory: int = MEMORY
    seconds: float = MOST_SECONDS

    def __post_init__(self) -> None:
        method_of(self.method, {"ddof": self.ddof, "bounds": self.bounds, "prior": self.prior})
        if isinstance(self.held, (bool, str)):
            raise SettingError(
                f"held is {self.held!r}: give the forces that are held as a tuple, such as ('F',), or all of them by "
                "preparation=Preparation(held=True)"
            )
        if self.joint and self.method not in ROW_METHODS:
            raise SettingError(f"method {self.method!r} leaves no factors to join: take one of wls, ols")

    @property
    def canonical(self) -> str:
        """Text that is equal for equal settings in every process."""
        return repr(_sorted(replace(self, memory=MEMORY, seconds=MOST_SECONDS)))  # limits change no result

    def of_axis(self, axis: Axis) -> BatchSettings:
        """The settings restricted to the signals and parameters of one axis."""

        def of(mapping: Mapping[str, Any], known: Collection[str]) -> dict[str, Any]:
            return {name: value for name, value in mapping.items() if name in known}

        signals, free = _signals(axis), axis.physical_parameters
        sensors = {sensor.signal for sensor in axis.sensors}
        held = True if any(d.signal in self.held for d in axis.drives) else self.preparation.held
        late = of(self.preparation.late, axis.signal_units)
        return replace(
            self,
            measured=tuple(name for name in self.measured or () if name in sensors) or None,
            columns=of(self.columns, signals),
            units=of(self.units, signals),
            gains=of(self.gains, signals),
            bounds=of(self.bounds, free),
            prior=of(self.prior, free),
            preparation=replace(self.preparation, late=late, held=held),
            held=(),
        )

    def check(self, axes: tuple[Axis, ...]) -> None:
        """SettingError for a signal, parameter or nominal value that does not match the axes."""
        known = frozenset().union(*map(_signals, axes))
        named = (*(self.measured or ()), *self.columns, *self.units, *self.gains)
        for signal in (*named, *self.preparation.late):
            if signal not in known:
                names = ", ".join(axis.name for axis in axes)
                signals = dict.fromkeys(name for axis in axes for name in axis.signal_units)
                raise SettingError(f"signal {signal!r} is not known: {names} has {', '.join(signals)}")
        free = {name for axis in axes for name in axis.physical_parameters}
        if strange := [name for name in (*self.bounds, *self.prior) if name not in free]:
            raise SettingError(
                f"{strange[0]!r} is not an unknown parameter: choose from {', '.join(sorted(free))}"
            )
        forces = [drive.signal for axis in axes for drive in axis.drives]
        if unknown := [signal for signal in self.held if signal not in forces]:
            raise SettingError(
                f"held signal {unknown[0]!r} is not a force of an axis: give {', '.join(forces)}"
            )
        for axis in axes:
            nominal = axis.physical_parameters if self.nominal is None else self.nominal
            missing = [name for name in axis.physical_parameters if name not in nominal]
            if missing:
                raise SettingError(
                    f"nominal values for {', '.join(missing)} of axis {axis.name!r} are missing: give all"
                )


def _signals(axis: Axis) -> frozenset[str]:
    """All names that settings may use for the columns of a log."""
    expected, alternatives = axis_columns(axis)
    return frozenset({"t", "reference", *expected, *(column for column, _ in alternatives.values())})


def _sorted(value: object) -> object:
    """Nested tuples of names and values in a fixed order."""
    if isinstance(value, (BatchSettings, Preparation)):
        return tuple((f.name, _sorted(getattr(value, f.name))) for f in fields(value))
    if isinstance(value, Mapping):
        return tuple(sorted((name, _sorted(item)) for name, item in value.items()))
    return float(value) if isinstance(value, float) else value
