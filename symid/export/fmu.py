"""An axis as a functional mock-up unit: FMI 2.0 for co-simulation, made of the exported C and a compiler."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

from symid.axis import Axis
from symid.errors import SettingError
from symid.export.c_source import c_source, internal_step
from symid.files import replacing
from symid.symbolic.pipeline import DerivedModel

_DESCRIPTION = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{guid}" generationTool="symid"
    variableNamingConvention="flat" numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true"
      canNotUseMemoryManagementFunctions="true">
    <SourceFiles><File name="{name}_fmu.c"/></SourceFiles>
  </CoSimulation>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.001"/>
  <ModelVariables>
{variables}
  </ModelVariables>
  <ModelStructure>
    <Outputs>
{outputs}
    </Outputs>
    <InitialUnknowns>
{outputs}
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""

_LIBRARIES = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib")}


def write_fmu(model: DerivedModel, values: Mapping[str, float], file: str | Path) -> tuple[str, ...]:
    """Write an axis as a unit for co-simulation, and return what it loses.

    The input is the drive's signal (its command where it has a gain), held over a step; outputs are the readings of all
    sensors; physical parameters and `internal_step` can be set before the start. Inside, `<axis>_step` runs at
    `internal_step`.

    Parameters
    ----------
    model : DerivedModel
        Axis and sensors.
    values : mapping of str to float
        Physical parameters, SI.
    file : path-like
        Ends with .fmu.

    Raises
    ------
    SettingError
        If the suffix is another one, or there is no C compiler.
    """
    path, axis = Path(file), model.axis
    if path.suffix != ".fmu":
        raise SettingError(f"unit {path.name!r} is of no known kind: end its name with .fmu")
    exported = c_source(model, values)
    folder, suffix = _platform()
    with tempfile.TemporaryDirectory() as place:
        sources = Path(place)
        for ending, text in exported.files.items():
            (sources / f"{axis.name}{ending}").write_text(text, encoding="utf-8")
        (sources / f"{axis.name}_fmu.c").write_text(_wrapper(axis, exported.text), encoding="utf-8")
        library = sources / f"{axis.name}{suffix}"
        _compile(sources / f"{axis.name}_fmu.c", library)
        with replacing(path) as unfinished, zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as unit:
            unit.writestr("modelDescription.xml", _description(axis, values))
            unit.write(library, f"binaries/{folder}/{library.name}")
            for source in sorted(sources.glob("*.[ch]")):
                unit.write(source, f"sources/{source.name}")
    kept = [loss for loss in exported.losses if not loss.startswith("Friction at rest")]
    return (*kept, f"The binary runs on {folder} only; for another machine, compile what is in sources/.")


def _platform() -> tuple[str, str]:
    if sys.platform not in _LIBRARIES:
        raise SettingError(
            f"no unit can be made on {sys.platform}: export to C and compile the sources there"
        )
    return _LIBRARIES[sys.platform]


def _compile(source: Path, library: Path) -> None:
    compiler = next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)
    if compiler is None:
        raise SettingError(
            "a unit needs a C compiler, and none is on the path: install gcc or clang, or use --to c"
        )
    options = ["-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
    command = [compiler, *options, source.name, "-lm", "-o", library.name]
    done = subprocess.run(command, cwd=source.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SettingError(f"{compiler} cannot compile the unit: {done.stderr.splitlines()[0]}")


def _description(axis: Axis, values: Mapping[str, float]) -> str:
    """The variables, numbered as the wrapper numbers them: input, readings, parameters, internal step."""
    drive = axis.only_drive
    names = [drive.command or drive.signal, *(s.signal for s in axis.sensors)]
    lines = [_variable(0, names[0], 'causality="input" variability="continuous"', 0.0)]
    for k, name in enumerate(names[1:], 1):
        lines.append(_variable(k, name, 'causality="output" variability="continuous" initial="calculated"'))
    settings = {
        **{name: values[name] for name in axis.physical_parameters},
        "internal_step": internal_step(axis, values),
    }
    fixed = 'causality="parameter" variability="fixed" initial="exact"'
    lines += [
        _variable(len(names) + k, name, fixed, value) for k, (name, value) in enumerate(settings.items())
    ]
    return _DESCRIPTION.format(
        name=axis.name,
        guid=axis.signature,
        variables="\n".join(lines),
        outputs="\n".join(f'      <Unknown index="{k + 1}"/>' for k in range(1, len(names))),
    )


def _variable(reference: int, name: str, kind: str, start: float | None = None) -> str:
    real = "<Real/>" if start is None else f'<Real start="{float(start)!r}"/>'
    return f'    <ScalarVariable name={quoteattr(name)} valueReference="{reference}" {kind}>{real}</ScalarVariable>'


def _wrapper(axis: Axis, source: str) -> str:
    """C source of the interface of an exported axis."""
    text = (Path(__file__).parent / "fmi2_interface.c").read_text(encoding="utf-8")
    words = {
        "AXIS_SOURCE": f'"{axis.name}.c"',
        "AXIS_GUID": f'"{axis.signature}"',
        "AXIS_GAIN": repr(axis.only_drive.factor),
        "AXIS_PARAMETERS": str(len(axis.physical_parameters)),
    }
    names = {
        f"AXIS_{word}": f"{axis.name}_{word}"
        for word in ("parameters", "values", "step", "derivative", "sensors")
    }
    sizes = {"AXIS_STATES": f"{axis.name}_states", "AXIS_READINGS": f"{axis.name}_readings"}
    if f"{axis.name}_way" in source:
        names |= {f"AXIS_{word}": f"{axis.name}_{word}" for word in ("way", "advance")}
    defined = "".join(f"#define {key} {value}\n" for key, value in {**words, **names, **sizes}.items())
    return f"{defined}{text}"
