"""C sources compiled by the machine's own compiler and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symid.export import Exported

Array = np.ndarray
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1")

RUN = """
/* States and readings of an axis with one drive after each force, which is held for `steps` steps of h. */
void {name}_run(const {name}_parameters *p, const SYMID_REAL *forces, int samples, int steps, SYMID_REAL h,
                SYMID_REAL *states, SYMID_REAL *readings)
{{
    enum {{ n = {name}_states, m = {name}_readings }};
    SYMID_REAL x[n] = {{0}}, y[m];
    {memory}
    for (int k = 0; k < samples; k++) {{
        for (int i = 0; i < steps; i++) {{
            {step}
        }}
        for (int i = 0; i < n; i++) states[k*n + i] = x[i];
        for (int i = 0; i < m; i++) readings[k*m + i] = y[i];
    }}
}}
"""
STEPPED = (
    "SYMID_REAL before[n], change[n];",
    """for (int j = 0; j < n; j++) before[j] = x[j];
            {name}_step(p, x, forces[k], h);
            for (int j = 0; j < n; j++) change[j] = (x[j] - before[j])/h;
            {name}_sensors(x, change, y);""",
)
ADVANCED = ("static {name}_way way;", "{name}_advance(p, &way, x, forces[k], h, y);")
"""What a loop declares and does at each step without delays, and with them."""


def with_run(exported: Exported, name: str) -> Exported:
    """An export with a function that takes all steps: a call of each from Python takes longer than the step."""
    header = exported.files[".h"]
    memory, step = (part.format(name=name) for part in (ADVANCED if f"{name}_way" in header else STEPPED))
    text = RUN.format(name=name, memory=memory, step=step)
    return replace(exported, files={**exported.files, ".c": exported.files[".c"] + text})


def compiler() -> str:
    """The C compiler; a machine without one cannot check the export, which is a failure and no reason to skip."""
    found = next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None)
    assert found, "no C compiler on the path: install one (apt-get install gcc)"
    return found


@dataclass(frozen=True)
class Compiled:
    """An exported axis as a shared library."""

    library: ctypes.CDLL
    name: str

    @classmethod
    def of(cls, exported: Exported, name: str, folder: Path, *options: str) -> Compiled:
        """Compile an export; any warning is an error."""
        for suffix, text in exported.files.items():
            (folder / f"{name}{suffix}").write_text(text, encoding="utf-8")
        library = folder / f"{name}.so"
        subprocess.run(
            [compiler(), *STRICT, *options, "-shared", "-fPIC", f"{name}.c", "-lm", "-o", library.name],
            cwd=folder,
            check=True,
        )
        return cls(ctypes.CDLL(str(library)), name)

    def function(self, name: str, *arguments: Array | float, shape: tuple[int, ...]) -> Array:
        """Call a function whose last argument is what it writes."""
        result = np.full(shape, np.nan)
        passed = [a.ctypes if isinstance(a, np.ndarray) else ctypes.c_double(a) for a in (*arguments, result)]
        self.library[f"{self.name}_{name}"](*passed)
        return result

    def run(
        self, values: Mapping[str, float], forces: Array, held: float, h: float, sizes: tuple[int, int]
    ) -> tuple[Array, Array]:
        """States and readings, of these `sizes`, after each force, which is held, in steps of h; see `with_run`."""
        states, readings = (np.full((forces.size, size), np.nan) for size in sizes)
        given = np.ascontiguousarray(forces)
        step = self.library[f"{self.name}_run"]
        ends = ctypes.c_double(h), states.ctypes, readings.ctypes
        step(self.parameters(values).ctypes, given.ctypes, forces.size, round(held / h), *ends)
        return states, readings

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Parameters as the structure that the functions take."""
        return np.array([float(value) for value in values.values()])
