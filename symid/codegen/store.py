"""The folder `generated/`: writing it from `models/`, checking that it is up to date, loading from it."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from symid.axis import Axis, axis_file, load_axis
from symid.codegen.model import GeneratedModel
from symid.errors import GeneratedModuleError

if TYPE_CHECKING:
    from symid.symbolic.pipeline import DerivedModel

_MEASURED = re.compile(r"^MEASURED = \((.*)\)$", re.MULTILINE)

FORMAT = 2
"""Version of the layout of generated modules."""


def generated_folder(axis_path: Path) -> Path:
    """Folder of the modules of an axis file: `generated/` beside its folder `models/`, else beside the file."""
    folder = axis_path.parent
    return (folder.parent if folder.name == "models" else folder) / "generated"


def module_name(axis: str, measured: Sequence[str]) -> str:
    """Name of a generated module, without suffix.

    Examples
    --------
    >>> module_name("direct_2m1s", ("q2", "ddq1"))
    'direct_2m1s__q2_ddq1'
    """
    return f"{axis}__{'_'.join(measured)}"


@dataclass(frozen=True)
class GeneratedFile:
    """A module as it should be, and as it is."""

    path: Path
    wanted: str | None
    found: str | None

    @property
    def is_current(self) -> bool:
        """Whether the file holds what it should."""
        return self.wanted == self.found

    def diff(self) -> str:
        """Unified diff from what is there to what should be."""
        before, after = (text.splitlines(keepends=True) if text else [] for text in (self.found, self.wanted))
        return "".join(
            difflib.unified_diff(before, after, f"{self.path.name} (found)", f"{self.path.name} (wanted)")
        )


def planned_file(path: Path, text: str | None) -> GeneratedFile:
    """A wanted text beside what the file holds now."""
    return GeneratedFile(path, text, _text(path) if path.is_file() else None)


def _text(path: Path) -> str:
    """Text of a module; bytes that are no text only make it a damaged one."""
    return path.read_text(encoding="utf-8", errors="replace")


def orphans(folder: Path, wanted: Sequence[Path], axes: Sequence[str]) -> Iterator[GeneratedFile]:
    """Modules of the given axes that are not wanted any more, and those whose axis file is gone."""
    for path in sorted(folder.glob("*__*.py")):
        axis = path.name.split("__")[0]
        homes = (folder.parent / "models" / f"{axis}.py", folder.parent / f"{axis}.py")
        if path not in wanted and (axis in axes or not any(home.is_file() for home in homes)):
            yield planned_file(path, None)


def sensor_sets_in(folder: Path, axis: Axis) -> tuple[tuple[str, ...], ...]:
    """Sets of sensors of an axis for which there are modules, beyond those that are always generated."""
    known = {sensor.signal for sensor in axis.sensors}
    found = []
    for path in sorted(folder.glob(f"{axis.name}__*.py")):
        line = _MEASURED.search(_text(path))
        signals = tuple(re.findall(r'"([^"]+)"', line[1])) if line else ()
        if signals and known.issuperset(signals) and signals not in axis.sensor_sets:
            found.append(signals)
    return tuple(found)


def write(files: Sequence[GeneratedFile]) -> None:
    """Write the files that are not current, each as a whole or not at all."""
    for file in files:
        if file.is_current:
            continue
        if file.wanted is None:
            file.path.unlink()
            continue
        file.path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = file.path.with_suffix(".unfinished")
        try:
            unfinished.write_text(file.wanted, encoding="utf-8")
            os.replace(unfinished, file.path)
        finally:
            unfinished.unlink(missing_ok=True)


def load_generated(
    axis: str | Axis, measured: Sequence[str] | None = None, folder: Path | None = None
) -> GeneratedModel:
    """Generated model of an axis and a set of sensors. Needs no sympy.

    Parameters
    ----------
    axis : str or Axis
        Name or path of an axis file; an `Axis` object must come with `folder`, or be of a file found by its name.
    measured : sequence of str, optional
        Signals of the sensors; the first sensor by default.
    folder : Path, optional
        Folder of the module, if it is not the one that belongs to the axis file.

    Raises
    ------
    GeneratedModuleError
        If the module is missing, damaged, or does not belong to the declaration as it is now.

    Examples
    --------
    >>> load_generated("direct_2m1s", ("q2",)).signals
    ('Fm', 'Fm_d1', 'Fm_d2', 'q2_d1', 'q2_d2', 'q2_d3', 'q2_d4')
    """
    return stored_module(axis, measured, folder).compiled()


@dataclass(frozen=True)
class StoredModule:
    """Text of a generated module, which can be sent to another process.

    Parameters
    ----------
    name, text : str
        File name and contents.
    signature : str
        That of the declaration as it is now.
    cure : str
        The command that generates the module anew.
    """

    name: str
    text: str
    signature: str
    cure: str

    def compiled(self) -> GeneratedModel:
        """The module as a record; GeneratedModuleError as in `load_generated`."""
        model = compile_module(self.text, self.name, self.cure)
        if model.signature != self.signature:
            raise GeneratedModuleError(
                f"generated module {self.name} is older than the declaration of {model.axis!r}; {self.cure}"
            )
        return model


def stored_module(
    axis: str | Axis, measured: Sequence[str] | None = None, folder: Path | None = None
) -> StoredModule:
    """Text of the module that `load_generated` runs.

    Raises
    ------
    GeneratedModuleError
        If there is none.

    Examples
    --------
    >>> stored_module("emps").name
    'emps__q.py'
    """
    name_or_path = axis.name if isinstance(axis, Axis) else axis
    declared = axis if isinstance(axis, Axis) else load_axis(axis)
    signals = tuple(
        sensor.signal for sensor in declared.measured(None if measured is None else tuple(measured))
    )
    folder = folder or generated_folder(axis_file(name_or_path))
    path = folder / f"{module_name(declared.name, signals)}.py"
    cure = f"run: symid generate {name_or_path} --measured {','.join(signals)}"
    if not path.is_file():
        raise GeneratedModuleError(f"there is no generated module {path.name}; {cure}")
    return StoredModule(path.name, _text(path), declared.signature, cure)


def as_generated(model: GeneratedModel | DerivedModel) -> GeneratedModel:
    """Generated model of a derived one; a generated model is returned as it is."""
    if isinstance(model, GeneratedModel):
        return model
    # Only who holds a derived model has loaded sympy already.
    from symid.codegen.generate import compiled

    return compiled(model)


def compile_module(text: str, name: str, cure: str = "generate it again") -> GeneratedModel:
    """Run the text of a generated module.

    Raises
    ------
    GeneratedModuleError
        If the text is damaged or of another format.
    """
    namespace: dict[str, object] = {"__name__": name}
    try:
        exec(compile(text, name, "exec"), namespace)
        if namespace["FORMAT"] != FORMAT:
            raise GeneratedModuleError(
                f"generated module {name} has format {namespace['FORMAT']}, this symid reads {FORMAT}; {cure}"
            )
        return GeneratedModel.from_namespace(namespace)
    except GeneratedModuleError:
        raise
    except Exception as error:
        raise GeneratedModuleError(
            f"generated module {name} is damaged ({type(error).__name__}: {error}); {cure}"
        ) from error
