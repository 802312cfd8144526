"""`generate`: from axis files to generated modules, where the symbolic packages end and the numeric ones begin."""

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from symid.axis import AnyAxis, axis_file, axis_names, axis_of, load_axis
from symid.codegen.generation.dynamics_record import dynamics_record
from symid.codegen.generation.module import module_text
from symid.codegen.store import (
    GeneratedFile,
    dynamics_file,
    dynamics_text,
    generated_folder,
    module_name,
    orphans,
    planned_file,
    sensor_sets_in,
    write_stale,
)
from symid.errors import EliminationError, SettingError, SymidError
from symid.symbolic import derive


def plan(
    axes: Sequence[str] = (),
    measured: Sequence[str] | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
    refused: Callable[[Path, SymidError], None] | None = None,
) -> list[GeneratedFile]:
    """Required and present texts of the generated files; nothing is written.

    Without `measured`, all `sensor_sets` of an axis and those with an existing module are planned. `track` passes on
    the names and may show progress. `refused` is called with the error of each module that cannot be derived; without
    it, the error is raised.
    """
    left_out: list[Path] = []

    def leave_out(path: Path, error: SymidError) -> None:
        if refused is None:
            raise error
        left_out.append(path)
        refused(path, error)

    files: list[GeneratedFile] = []
    own: dict[Path, list[str]] = {}
    for name in track(axes or axis_names()):
        files += _plan_axis(name, measured, leave_out)
        own.setdefault(generated_folder(axis_file(name)), []).append(axis_file(name).stem)
    if measured is None:
        paths = [*(file.path for file in files), *left_out]
        files += [file for folder, names in own.items() for file in orphans(folder, paths, names)]
    return files


def generate(axes: AnyAxis | Sequence[AnyAxis] = (), measured: Sequence[str] | None = None) -> list[Path]:
    """Write the generated modules of axes that are not current.

    Parameters
    ----------
    axes : Axis, str, path-like, model, or sequence of them
        Names or paths of axis files, or what is declared in a file of its name in `models/`; all axes by default.
    measured : sequence of str, optional
        Signals of the sensors; all sensor sets by default.

    Returns
    -------
    list of Path
        Files that were written or removed.

    Raises
    ------
    SymidError
        If an axis cannot be loaded or derived, or is in no file; then no file is written.
    """
    several = axes if isinstance(axes, Sequence) and not isinstance(axes, str) else (axes,)
    files = plan([_file_name(axis) for axis in several], measured)
    write_stale(files)
    return [file.path for file in files if not file.is_current]


def _file_name(axis: AnyAxis) -> str:
    """Name or path of the file of an axis; SettingError if no file declares it."""
    if isinstance(axis, (str, os.PathLike)):
        return os.fspath(axis)
    declared = axis_of(axis)
    if declared.name not in axis_names():
        fault = f"axis {declared.name!r} is declared in no file"
    elif load_axis(declared.name).signature != declared.signature:
        fault = f"{axis_file(declared.name)} declares another axis {declared.name!r}"
    else:
        return declared.name
    raise SettingError(
        f"{fault}: write it with write_axis(axis, 'models/{declared.name}.py'), or generate nothing: identify, "
        "diagnose and simulate take it as it is"
    )


def _plan_axis(
    name: str, measured: Sequence[str] | None, leave_out: Callable[[Path, SymidError], None]
) -> list[GeneratedFile]:
    axis, folder = load_axis(name), generated_folder(axis_file(name))
    files = []
    for signals in (measured,) if measured else (*axis.sensor_sets, *sensor_sets_in(folder, axis)):
        ordered = tuple(sensor.signal for sensor in axis.measured(signals))
        path = folder / f"{module_name(axis.name, ordered)}.py"
        try:
            files.append(planned_file(path, module_text(derive(axis, ordered))))
        except EliminationError as error:
            leave_out(path, error)
    if measured is None:
        text = dynamics_text(axis, dynamics_record(axis))
        files.append(planned_file(dynamics_file(folder, axis.name), text))
    return files
