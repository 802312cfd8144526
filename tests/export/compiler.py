"""C sources compiled by the machine's own compiler and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symid.export import Exported

Array = np.ndarray
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1")


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

    def parameters(self, values: Mapping[str, float]) -> Array:
        """Parameters as the structure that the functions take."""
        return np.array([float(value) for value in values.values()])
