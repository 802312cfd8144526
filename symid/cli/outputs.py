"""Output files of commands, checked before any work is done: recordings and inputs are never overwritten."""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
from click import option
from click.shell_completion import CompletionItem

from symid.axis import axis_file, axis_names
from symid.errors import SettingError, SymidError
from symid.files import read_json

Kind = str | Callable[[Mapping[str, Any]], str]
_BEGINNINGS: Final[Mapping[str, tuple[bytes, ...]]] = {
    "html": (b"<!doctype html",),
    "picture": (b"\x89png", b"%pdf", b"<?xml", b"<svg"),
    "c": (b"#include <math.h>", b"/* axis "),
    "exported": (b"<", b"(*"),
    "fmu": (b"pk\x03\x04",),
    "log": (),
    "axis": (),
    "results": (b"",),  # a batch looks into them itself
}
"""First bytes of the kinds of file that a command may replace; a log or an axis file may be a user's work."""
_RECORDS: Final[Mapping[str, tuple[tuple[str, str], ...]]] = {
    "identify": (("axis", "method"),),
    "diagnose": (("axis", "verdict"),),
    "show": (("axis", "regressor"),),
    "tune": (("axis", "first_sampling_hz"), ("axis", "noise")),
    "simulate": (("axis", "largest_force"),),
    "excite": (("axis", "tried"),),
    "export": (("axis", "to"), ("axis", "signature")),
    "new": (("axis", "file"),),
    "import": (("log", "columns"),),
    "batch": (("logs", "output"),),
    "fleet": (("logs", "sentence"),),
    "compare": (("files", "together"),),
    "generate": (("checked", "written"),),
    "demo": (("identification", "diagnosis"),),
    "mapping": (("columns", "guesses"),),
}
"""Names by which a command recognises its own JSON; other JSON may be a log, or written by hand."""
_BESIDE: Final[Mapping[str, tuple[str, str]]] = {"axis": (".json", "values"), "c": (".h", "c")}
"""Suffix and kind of a second file that is written beside one of a kind."""
_BYTES_LOOKED_AT: Final = 4096
_AXES: Final = ("axis", "axes", "also", "declared")
"""Parameters of commands that name axes."""

overwrite_option = option("--overwrite", is_flag=True, help="Replace an existing log of the same name.")


class Output(click.types.StringParamType):
    """A file to write, of one of the kinds json, mapping, html, picture, c, exported, fmu, log, axis and results.

    A function of all options may give the kind.
    """

    name = "FILE"

    def __init__(self, kind: Kind) -> None:
        self.kind = kind


@dataclass(frozen=True)
class _OutputFile:
    """A file that a command is going to write."""

    option: str
    path: Path
    kind: str

    @property
    def as_given(self) -> str:
        """The option as the user wrote it."""
        return f"{self.option} {str(self.path)!r}"


class AxisName(click.types.StringParamType):
    """An axis by its name or the path of its file; a shell completes the names."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Names of the axes that can be loaded, and files."""
        names = [CompletionItem(name) for name in axis_names() if name.startswith(incomplete)]
        return names or [CompletionItem(incomplete, type="file")]


class SafeCommand(click.Command):
    """A command whose help shows defaults, and whose outputs are checked before it does anything."""

    def __init__(self, name: str | None, **settings: Any) -> None:
        settings["context_settings"] = {"show_default": True, **(settings.get("context_settings") or {})}
        super().__init__(name, **settings)
        for parameter in self.params:
            if parameter.name in _AXES and type(parameter.type) is click.types.StringParamType:
                parameter.type = AxisName()

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, after a check that outputs are not inputs, replace only their kind, and are writable."""
        wanted = tuple(_wanted(self, ctx.params))
        if wanted:
            seen: dict[str, _OutputFile] = {}
            for output in wanted:
                if not output.path.exists() or output.path.is_file():
                    other = seen.setdefault(os.path.realpath(output.path), output)
                    if other is not output:
                        raise SettingError(
                            f"{other.as_given} and {output.as_given} are one file: give each a separate name"
                        )
            inputs = dict(_inputs(self, ctx.params))
            for output in wanted:
                _require_writable(output, inputs, overwrite=bool(ctx.params.get("overwrite")))
        return super().invoke(ctx)


def _wanted(command: click.Command, values: Mapping[str, Any]) -> Iterator[_OutputFile]:
    for parameter in command.params:
        if not isinstance(parameter.type, Output) or parameter.name is None:
            continue
        for file in _texts(values.get(parameter.name)):
            if file == "-":
                continue
            given, option = parameter.type.kind, parameter.opts[-1]
            kind = given if isinstance(given, str) else given(values)
            # A record is replaced only by one of the same command.
            yield _OutputFile(option, Path(file), command.name or kind if kind == "json" else kind)
            if kind in _BESIDE and Path(file).name:
                suffix, other = _BESIDE[kind]
                yield _OutputFile(option, Path(file).with_suffix(suffix), other)


def _inputs(command: click.Command, values: Mapping[str, Any]) -> Iterator[tuple[tuple[int, int], str]]:
    """Input files of the command by device and inode."""
    outputs = {parameter.name for parameter in command.params if isinstance(parameter.type, Output)}
    for name, value in values.items():
        if name in outputs:
            continue
        for text in _texts(value):
            path = text
            if name in _AXES:
                try:
                    path = str(axis_file(text))
                except SymidError:
                    continue  # reported when the axis is loaded
            identity = _identity(path)
            if identity is not None and os.path.isfile(path):
                yield identity, path


def _texts(value: object) -> tuple[str, ...]:
    if isinstance(value, str):
        return (value,)
    return tuple(item for item in value if isinstance(item, str)) if isinstance(value, tuple) else ()


def _identity(path: str | Path) -> tuple[int, int] | None:
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_dev, status.st_ino


def _require_writable(output: _OutputFile, inputs: Mapping[tuple[int, int], str], *, overwrite: bool) -> None:
    path = output.path
    if not path.name:
        raise SettingError(f"{output.as_given} does not name a file: give one")
    if path.is_dir():
        raise SettingError(f"{output.as_given} is a folder: give the name of a file")
    if not path.exists():
        folder = path.parent
        if not folder.is_dir():
            raise SettingError(f"{path}: No such file or directory: give a file in a folder that exists")
        if not os.access(folder, os.W_OK):
            raise SettingError(f"{path}: Permission denied: choose a folder that can be written")
        return
    if not path.is_file():
        return  # a pipe or a device, such as /dev/stdout
    if (used := inputs.get(_identity(path) or (0, 0))) is not None:
        raise SettingError(
            f"{output.as_given} is {used!r}, which this command reads: give another name, it would be lost"
        )
    if output.kind == "log" and overwrite:
        return
    if path.stat().st_size and not _is_of_kind(path, output.kind):
        cure = "give another name, or remove it first"
        if output.kind == "log":
            cure = "give another name, remove it first, or add --overwrite"
        what = "" if output.kind == "log" else " and was not written by this command"
        raise SettingError(f"{output.as_given} exists{what}: {cure}")


def _is_of_kind(path: Path, kind: str) -> bool:
    """Whether a file is of a kind that a command may replace."""
    if kind in _RECORDS:
        try:
            record = read_json(path)
        except SettingError:
            return False
        return isinstance(record, dict) and any(record.keys() >= {*pair} for pair in _RECORDS[kind])
    if kind == "values":  # of the axis beside them, which was written with them
        axis = path.with_suffix(".py")
        return axis.is_file() and _is_of_kind(axis, "axis")
    with path.open("rb") as file:
        begin = file.read(_BYTES_LOOKED_AT).removeprefix(b"\xef\xbb\xbf").lstrip().lower()
    if kind == "axis":
        return b"with what a diagnosis found." in begin.partition(b"\n")[0]
    if kind in ("c", "exported") and b"symid" not in begin:
        return False
    return begin.startswith(_BEGINNINGS[kind]) if _BEGINNINGS[kind] else False
