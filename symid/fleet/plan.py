"""Plan of a batch: its log files, and its axes in a form that other processes and machines can use."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from glob import glob, has_magic
from itertools import chain
from pathlib import Path

import symid
from symid.axis import AnyAxis, Axis, axis_of
from symid.codegen import GeneratedModel, StoredModule, model_of, stored_module
from symid.data.formats import FOLDER_SUFFIXES, suffix_of
from symid.errors import EliminationError, SettingError, SymidError
from symid.fleet.batch_settings import BatchSettings
from symid.fleet.results import holds_results
from symid.fleet.row import AFTER, BEFORE, DIAGNOSIS, FACTORS
from symid.identification.signals import axis_columns

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class FleetAxis:
    """An axis with its generated modules as text and its settings: all that a worker needs."""

    axis: Axis  # the declaration
    # by set of sensors; without any, models are derived
    modules: tuple[tuple[tuple[str, ...], StoredModule], ...]
    settings: BatchSettings  # those that apply to this axis

    @cached_property
    def fingerprint(self) -> str:
        """Hash of declaration, modules, settings and version of symid, on which a row depends besides its log."""
        texts = [module.text for _, module in self.modules]
        declared = (self.axis.name, self.axis.elements, self.axis.drive, self.axis.sensors)
        parts = (symid.__version__, self.axis.signature, repr(declared), self.settings.canonical, *texts)
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    def __getstate__(self) -> dict[str, object]:
        """The plan as sent to a worker, with the fingerprint: each group of logs arrives with a new copy."""
        return {**self.__dict__, "fingerprint": self.fingerprint}

    def model(self, measured: Sequence[str]) -> GeneratedModel:
        """Generated model of a set of sensors; one that was not generated is derived."""
        wanted = tuple(sensor.signal for sensor in self.axis.measured(measured))
        module = dict(self.modules).get(wanted)
        return model_of(self.axis, wanted) if module is None else _compiled(module)

    def with_known(self, values: Mapping[str, float]) -> FleetAxis:
        """The axis of a log of which more values are known."""
        return replace(self, axis=_with_known(self.axis, values), modules=()) if values else self

    def is_held_in(self, columns: frozenset[str]) -> bool:
        """Whether a file with these columns contains the forces and a sensor of the axis."""
        expected, alternatives = axis_columns(self.axis, self.settings.measured)
        mapped = self.settings.columns

        def has(signal: str) -> bool:
            return mapped.get(signal, signal) in columns

        forces = {drive.signal for drive in self.axis.drives}
        made = {force for force in forces & alternatives.keys() if has(alternatives[force][0])}
        sensors = (signal for signal in expected if signal not in forces)
        return all(map(has, forces - made)) and any(map(has, sensors))


@lru_cache(maxsize=256)
def _compiled(module: StoredModule) -> GeneratedModel:
    return module.compiled()


def _with_known(axis: Axis, values: Mapping[str, float]) -> Axis:
    return axis.with_known({name: value for name, value in values.items() if name in axis.parameter_units})


def fleet_axes(
    axes: AnyAxis | Sequence[AnyAxis],
    settings: BatchSettings,
    known: Mapping[str, float] | None = None,
) -> tuple[FleetAxis, ...]:
    """Axes of a batch from names, paths or declarations.

    Parameters that are `known` in each log are not part of the results; their values are those of the first log.
    """
    several = axes if isinstance(axes, Sequence) and not isinstance(axes, str) else (axes,)
    named = [axis if isinstance(axis, str) else axis_of(axis) for axis in several]
    if known:
        parameters = {name for axis in named for name in axis_of(axis).parameter_units}
        if strange := sorted(set(known) - parameters):
            raise SettingError(
                f"{strange[0]!r} is not a parameter: choose from {', '.join(sorted(parameters))}"
            )
        named = [_with_known(axis_of(axis), known) for axis in named]
    declared = [axis_of(axis) for axis in named]
    names = [axis.name for axis in declared]
    if not names or len(set(names)) < len(names):
        raise SettingError(
            "give each axis once: " + (f"{', '.join(names)} are given" if names else "none is given")
        )
    settings.check(tuple(declared))
    _require_no_column(declared)
    planned = []
    for source, axis in zip(named, declared, strict=True):
        restricted = settings.of_axis(axis)
        sets = (restricted.measured,) if restricted.measured else axis.sensor_sets
        planned.append(FleetAxis(axis, tuple(_modules(source, axis, sets)), restricted))
    return tuple(planned)


def _require_no_column(axes: Sequence[Axis]) -> None:
    """SettingError if a parameter has the name of a column of the results."""
    names = [(axis, name) for axis in axes for name in axis.physical_parameters]
    columns = {*BEFORE, *AFTER, *DIAGNOSIS, FACTORS}
    deviations = {f"{name}_std" for _, name in names}
    for axis, name in names:
        if name in columns | deviations or f"{name}_std" in columns:
            raise SettingError(
                f"axis {axis.name!r} has a parameter {name!r}, which is a column of the results: rename it"
            )


def _modules(
    source: str | Axis, axis: Axis, sets: Sequence[tuple[str, ...]]
) -> Iterator[tuple[tuple[str, ...], StoredModule]]:
    """Current modules of an axis; if there is none, the first one that can be derived."""
    any_model, refused = False, list[EliminationError]()
    for measured in sets:
        try:
            module = stored_module(source, measured)
            module.compiled()
        except SymidError:
            if any_model:
                continue
            try:
                model_of(axis, measured)
            except EliminationError as error:
                refused.append(error)
                continue
            module = stored_module(axis, measured)
        any_model = True
        yield tuple(sensor.signal for sensor in axis.measured(measured)), module
    if not any_model:
        raise refused[0]


def log_files(logs: PathLike | Iterable[PathLike], exclude: Iterable[PathLike] = ()) -> tuple[str, ...]:
    """Paths of logs without duplicates: files, all logs in folders, and all matches of patterns, folders among them.

    A missing file is kept and becomes a row with an error. Paths to `exclude` and results of other batches are
    dropped. SettingError if a folder or a pattern contains no log.
    """
    items = (logs,) if isinstance(logs, (str, os.PathLike)) else tuple(logs)
    if strange := next((item for item in items if not isinstance(item, (str, os.PathLike))), None):
        raise SettingError(
            f"a batch reads files, not {type(strange).__name__}: write it to a Parquet file, or identify it alone"
        )
    skipped = {os.path.abspath(path) for path in exclude}
    files: dict[str, str] = {}
    for item in (str(os.fspath(path)) for path in items):
        paths = [path for path in _expanded(item) if os.path.abspath(path) not in skipped]
        if not paths:
            raise SettingError(
                f"{item}: there is no log: give {', '.join(FOLDER_SUFFIXES)} files, or a folder of them"
            )
        for path in (path for path in paths if not holds_results(path)):
            files.setdefault(os.path.abspath(path), path)
    if not files:
        raise SettingError("there is no log: give at least one file, folder or pattern that holds one")
    return tuple(files.values())


def _expanded(item: str) -> list[str]:
    """Files of a path, folder or pattern, and unreadable folders in it, which become rows with errors."""
    if os.path.isdir(item):
        return sorted(_logs_in(item))
    if has_magic(item) and not os.path.exists(item):
        places = glob(os.path.dirname(item) or os.curdir, recursive=True)
        closed = [p for p in places if os.path.isdir(p) and not os.access(p, os.R_OK | os.X_OK)]
        matches = (_logs_in(path) if os.path.isdir(path) else (path,) for path in glob(item, recursive=True))
        return sorted({*closed, *chain.from_iterable(matches)})
    return [item]


def _logs_in(folder: str) -> Iterator[str]:
    closed: list[OSError] = []
    for place, _, names in os.walk(folder, onerror=closed.append):
        for name in names:
            if suffix_of(Path(name)) in FOLDER_SUFFIXES:
                yield str(Path(place, name))
    yield from (str(Path(error.filename)) for error in closed)
