"""An axis as a functional mock-up unit: FMI 2.0 or 3.0 for co-simulation, compiled from the exported C."""

import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import quoteattr

from symid.axis import Axis, axis_of
from symid.errors import SettingError
from symid.export.c_source import c_source, internal_step
from symid.files import replacing, written_path
from symid.symbolic import DerivedModel
from symid.units import BASE_UNITS, Unit

_DESCRIPTION = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{fmi}.0" modelName="{name}" {token}="{guid}" generationTool="symid"
    variableNamingConvention="flat"{events}>
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true"{sources}
  <UnitDefinitions>
{units}
  </UnitDefinitions>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.001"/>
  <ModelVariables>
{variables}
  </ModelVariables>
  <ModelStructure>
{outputs}
  </ModelStructure>
</fmiModelDescription>
"""

_SOURCES_2 = """
      canNotUseMemoryManagementFunctions="true">
    <SourceFiles><File name="{name}_fmu.c"/></SourceFiles>
  </CoSimulation>"""

_BUILD_3 = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{name}">
    <SourceFileSet language="C99"><SourceFile name="{name}_fmu.c"/></SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""

_LIBRARIES = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib")}
_FOLDERS_3 = {"linux64": "linux", "darwin64": "darwin", "win64": "windows"}
FmiVersion = Literal[2, 3]


def write_fmu(
    model: DerivedModel | Axis, values: Mapping[str, float], file: str | Path, fmi: FmiVersion = 2
) -> tuple[str, ...]:
    """Write an axis as a unit for co-simulation, and return its losses.

    Inputs are the signals of the drives (their commands if they have a gain), held over a step; outputs are the
    readings of all sensors. Physical parameters and `internal_step`, the step of `<axis>_step`, can be set before the
    start.

    Parameters
    ----------
    model : DerivedModel or Axis
        The axis; the unit's sources contain the regressor of a model.
    values : mapping of str to float
        Physical parameters, SI.
    file : path-like
        File with suffix .fmu.
    fmi : {2, 3}
        FMI 2.0 or 3.0.

    Raises
    ------
    SettingError
        If the suffix is not .fmu, no machine has the values, or there is no C compiler.
    """
    path, axis = written_path("unit", file, ".fmu"), axis_of(model)
    exported = c_source(model, values)
    if sys.platform not in _LIBRARIES:
        raise SettingError(
            f"FMUs cannot be built on {sys.platform}: export to C and compile the sources there"
        )
    with tempfile.TemporaryDirectory() as place:
        sources = Path(place)
        files = {**exported.files, "_fmu.c": _wrapper(axis, exported.text, fmi)}
        for ending, text in files.items():
            (sources / f"{axis.name}{ending}").write_text(text, encoding="utf-8")
        built = _binaries(sources / f"{axis.name}_fmu.c", axis.name)
        with replacing(path) as unfinished, zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as unit:
            unit.writestr("modelDescription.xml", _description(axis, values, fmi))
            if fmi == 3:
                unit.writestr("sources/buildDescription.xml", _BUILD_3.format(name=axis.name))
            architecture = platform.machine().lower()
            architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(architecture, architecture)
            for machine, library in built.items():
                # In FMI 3.0 a folder is named such as x86_64-linux; the Windows binary is for x86_64.
                processor = "x86_64" if machine == "win64" else architecture
                folder = f"{processor}-{_FOLDERS_3[machine]}" if fmi == 3 else machine
                unit.write(library, f"binaries/{folder}/{library.name}")
            for source in sorted(sources.glob("*.[ch]")):
                unit.write(source, f"sources/{source.name}")
    kept = [loss for loss in exported.losses if not loss.startswith("Friction at rest")]
    more = "" if "win64" in built else " (win64: pip install ziglang)"
    return (
        *kept,
        f"The binary runs on {' and '.join(built)} only{more}; for another machine, compile the files in sources/.",
    )


def _binaries(source: Path, name: str) -> dict[str, Path]:
    """Libraries compiled beside a source, by platform: this one, and Windows if its cross compiler is installed."""
    compiler = next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None)
    if compiler is None:
        raise SettingError(
            "an FMU needs a C compiler, and none is on the path: install gcc or clang, or take `to=c`"
        )
    folder, suffix = _LIBRARIES[sys.platform]
    built = {folder: source.parent / f"{name}{suffix}"}
    _compile(source, built[folder], (compiler,))
    if folder != "win64" and find_spec("ziglang") is not None:
        built["win64"] = source.parent / f"{name}.dll"
        zig = (sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu")
        _compile(source, built["win64"], zig)
    return built


def _compile(source: Path, library: Path, compiler: Sequence[str]) -> None:
    options = ["-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
    command = [*compiler, *options, source.name, "-lm", "-o", library.name]
    done = subprocess.run(command, cwd=source.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        message = next(iter(done.stderr.splitlines()), "no message")
        raise SettingError(f"{' '.join(compiler)} cannot compile the FMU: {message}")


def _description(axis: Axis, values: Mapping[str, float], fmi: FmiVersion) -> str:
    """Model description. Its variables have the order of the wrapper: inputs, readings, parameters, step, time."""
    units, fed = axis.signal_units, 'causality="input" variability="continuous"'
    sent = [drive.command or drive.signal for drive in axis.drives]
    rows = [_Variable(name, fed, units.get(name), "command of the drive", 0.0) for name in sent]
    rows += [
        _Variable(
            s.signal,
            'causality="output" variability="continuous" initial="calculated"',
            units[s.signal],
            f"reading of the {type(s).__name__.lower()} sensor",
        )
        for s in axis.sensors
    ]
    first, last = len(axis.drives) + 1, len(rows)
    fixed = 'causality="parameter" variability="fixed" initial="exact"'
    rows += [
        _Variable(name, fixed, unit, "physical parameter", values[name])
        for name, unit in axis.physical_parameters.items()
    ]
    step = internal_step(axis, values)
    rows.append(_Variable("internal_step", fixed, Unit.of("s"), "step of the integration inside", step))
    if fmi == 2:
        unknowns = "".join(f'      <Unknown index="{k}"/>\n' for k in range(first, last + 1))
        outputs = "\n".join(
            f"    <{what}>\n{unknowns}    </{what}>" for what in ("Outputs", "InitialUnknowns")
        )
    else:
        of_time = 'causality="independent" variability="continuous"'
        rows.append(_Variable("time", of_time, Unit.of("s"), "simulated time"))
        outputs = "\n".join(
            f'    <{what} valueReference="{k}"/>'
            for what in ("Output", "InitialUnknown")
            for k in range(first - 1, last)
        )
    defined = dict.fromkeys(row.unit for row in rows if row.unit is not None and str(row.unit))
    return _DESCRIPTION.format(
        fmi=fmi,
        name=axis.name,
        token="guid" if fmi == 2 else "instantiationToken",
        guid=axis.signature,
        events=' numberOfEventIndicators="0"' if fmi == 2 else "",
        sources=_SOURCES_2.format(name=axis.name) if fmi == 2 else "/>",
        units="\n".join(_defined(unit) for unit in defined),
        variables="\n".join(row.element(k, fmi) for k, row in enumerate(rows)),
        outputs=outputs,
    )


@dataclass(frozen=True)
class _Variable:
    """A variable of the unit."""

    name: str
    kind: str
    unit: Unit | None
    what: str
    start: float | None = None

    def element(self, reference: int, fmi: FmiVersion) -> str:
        """XML element of the variable in the model description."""
        unit = f" unit={quoteattr(str(self.unit))}" if self.unit is not None and str(self.unit) else ""
        start = "" if self.start is None else f' start="{float(self.start)!r}"'
        named = f'name={quoteattr(self.name)} valueReference="{reference}"'
        named = f"{named} description={quoteattr(self.what)} {self.kind}"
        if fmi == 3:
            return f"    <Float64 {named}{unit}{start}/>"
        return f"    <ScalarVariable {named}><Real{unit}{start}/></ScalarVariable>"


def _defined(unit: Unit) -> str:
    """Definition of a unit by SI base units."""
    powers = dict(zip(BASE_UNITS, unit.exponents, strict=True))
    volts = powers.pop("V")
    for base, power in {"kg": 1, "m": 2, "s": -3, "A": -1}.items():
        powers[base] += volts * power
    given = "".join(f' {base}="{power}"' for base, power in powers.items() if power)
    return f"    <Unit name={quoteattr(str(unit))}><BaseUnit{given}/></Unit>"


def _wrapper(axis: Axis, source: str, fmi: FmiVersion) -> str:
    """C source of the interface of an exported axis."""
    parts = ("fmi_instance.c", f"fmi{fmi}_interface.c")
    text = "\n".join((Path(__file__).parent / part).read_text(encoding="utf-8") for part in parts)
    words = {
        "AXIS_SOURCE": f'"{axis.name}.c"',
        "AXIS_GUID": f'"{axis.signature}"',
        "AXIS_INPUTS": str(len(axis.drives)),
        "AXIS_FORCES(u)": ", ".join(f"{d.factor!r}*(u)[{i}]" for i, d in enumerate(axis.drives)),
        "AXIS_PARAMETERS": str(len(axis.physical_parameters)),
    }
    names = {
        f"AXIS_{word}": f"{axis.name}_{word}"
        for word in ("parameters", "values", "step", "derivative", "sensors")
    }
    sizes = {"AXIS_STATES": f"{axis.name}_states", "AXIS_READINGS": f"{axis.name}_readings"}
    if f"{axis.name}_way" in source:
        names |= {f"AXIS_{word}": f"{axis.name}_{word}" for word in ("way", "advance")}
    if f"{axis.name}_settle" in source:
        names["AXIS_settle"] = f"{axis.name}_settle"
    defined = "".join(f"#define {key} {value}\n" for key, value in {**words, **names, **sizes}.items())
    return f"{defined}{text}"
