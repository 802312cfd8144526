"""Generated models of an axis: loaded from the folder `generated/`, or derived on demand."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from symid.axis import AnyAxis, Axis, axis_file, axis_of
from symid.codegen.model import GeneratedModel, declared_delays, passed_over
from symid.codegen.store import FORMAT, generated_folder, module_name, stored_text
from symid.codegen.vetting import vetted
from symid.errors import GeneratedModuleError, SymidError

_FORMAT = re.compile(r"^FORMAT = (\d{1,9})$", re.MULTILINE)


def load_generated(
    axis: AnyAxis, measured: Sequence[str] | None = None, folder: Path | None = None
) -> GeneratedModel:
    """Generated model of an axis and a set of sensors. Needs no sympy.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        Name or path of an axis file; an `Axis` object needs `folder`, unless its file is found by its name. A model has
        its own sensors.
    measured : sequence of str, optional
        Signals of the sensors; the first sensor by default.
    folder : Path, optional
        Folder of the module; by default that of the axis file.

    Raises
    ------
    GeneratedModuleError
        If the module is missing, damaged, or older than the declaration.

    Examples
    --------
    >>> load_generated("direct_2m1s", ("q2",)).signals
    ('Fm', 'Fm_d1', 'Fm_d2', 'q2_d1', 'q2_d2', 'q2_d3', 'q2_d4')
    """
    if not isinstance(axis, (Axis, str)):
        measured = measured or getattr(axis, "measured", None)
        axis = axis_of(axis)
    return stored_module(axis, measured, folder).compiled()


def model_of(axis: str | Axis, measured: Sequence[str] | None = None) -> GeneratedModel:
    """The generated model of an axis; if no current module exists, it is derived and kept in memory.

    Parameters
    ----------
    axis : str or Axis
        Name or path of an axis file, or a declaration without a file.
    measured : sequence of str, optional
        Signals of the sensors; the first sensor by default.

    Raises
    ------
    SymidError
        If the axis does not exist or cannot be derived.

    Examples
    --------
    >>> from symid.axis import Axis, Body, Drive, Position
    >>> body = Body("body", mass="M")
    >>> model_of(Axis("free", (body,), Drive("F", body), (Position("q", body),))).signals
    ('F', 'q_d2')
    """
    declared = axis_of(axis)
    signals = tuple(sensor.signal for sensor in declared.measured(measured))
    try:
        return load_generated(axis, signals)
    except SymidError:
        # sympy is imported only if there is no module.
        from symid.codegen.generation.module import module_text
        from symid.symbolic import derive

        text = module_text(derive(declared, signals))
        DERIVED[declared.signature, declared.name, signals] = text
        return load_generated(declared, signals)


@dataclass(frozen=True)
class StoredModule:
    """Text of a generated module, which can be sent to another process.

    Signature, delays and imperfections are those of the present declaration; the command `cure` regenerates the module.
    """

    name: str
    text: str
    signature: str
    delays: tuple[tuple[str, float], ...]
    passed_over: tuple[str, ...]
    cure: str

    def compiled(self) -> GeneratedModel:
        """The module as a record; GeneratedModuleError as in `load_generated`."""
        model = compile_module(self.text, self.name, self.cure)
        if model.signature != self.signature:
            raise GeneratedModuleError(
                f"generated module {self.name} is older than the declaration of {model.axis!r}; {self.cure}"
            )
        return replace(model, delays=dict(self.delays), passed_over=self.passed_over)


def stored_module(
    axis: str | Axis, measured: Sequence[str] | None = None, folder: Path | None = None
) -> StoredModule:
    """Text of the module that `load_generated` runs; GeneratedModuleError if it does not exist.

    >>> stored_module("emps").name
    'emps__q.py'
    """
    name_or_path = axis.name if isinstance(axis, Axis) else axis
    declared = axis_of(axis)
    signals = tuple(sensor.signal for sensor in declared.measured(measured))
    late, missed = tuple(declared_delays(declared, signals).items()), passed_over(declared)
    module = f"{module_name(declared.name, signals)}.py"
    if folder is None and (text := DERIVED.get((declared.signature, declared.name, signals))):
        return StoredModule(module, text, declared.signature, late, missed, "derive it again")
    folder = folder or generated_folder(axis_file(name_or_path))
    path = folder / module
    cure = f"run: symid generate {name_or_path} --measured {','.join(signals)}"
    if not path.is_file():
        raise GeneratedModuleError(f"there is no generated module {path.name}; {cure}")
    return StoredModule(path.name, stored_text(path), declared.signature, late, missed, cure)


DERIVED: dict[tuple[str, str, tuple[str, ...]], str] = {}
"""Texts of modules derived in this process, by signature and name of the axis, and sensors."""


def compile_module(text: str, name: str, cure: str = "generate it again") -> GeneratedModel:
    """Run the text of a generated module; GeneratedModuleError if it was edited or contains more than arithmetic."""
    namespace: dict[str, object] = {"__name__": name}
    found = _FORMAT.search(text)
    if found and int(found[1]) != FORMAT:
        raise GeneratedModuleError(
            f"generated module {name} has format {found[1]}, this symid reads {FORMAT}; {cure}"
        )
    try:
        exec(compile(vetted(text), name, "exec"), namespace)
        return GeneratedModel.from_namespace(namespace)
    except GeneratedModuleError as error:
        raise GeneratedModuleError(f"generated module {name} {error}; {cure}") from error
    except Exception as error:
        raise GeneratedModuleError(
            f"generated module {name} is damaged ({type(error).__name__}: {error}); {cure}"
        ) from error


def compiled(axis: AnyAxis, measured: Sequence[str] | None = None) -> GeneratedModel:
    """Generated model of an axis or of a derived model, in memory; a generated model is returned as it is.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        The axis, the name or path of its file, or a model of it, which has its own sensors.
    measured : sequence of str, optional
        Sensors to use; by default those that the axis requires.

    Examples
    --------
    >>> compiled("rigid_1m").output_names
    ('F',)
    """
    if isinstance(axis, GeneratedModel):
        return axis
    from symid.codegen.generation.module import module_text  # loads sympy
    from symid.symbolic import DerivedModel, derive

    model = axis if isinstance(axis, DerivedModel) else derive(axis, measured)
    found = compile_module(module_text(model), module_name(model.axis.name, model.measured))
    return replace(
        found, delays=declared_delays(model.axis, model.measured), passed_over=passed_over(model.axis)
    )
