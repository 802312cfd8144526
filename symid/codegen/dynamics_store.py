"""Files of forward dynamics in the folder `generated/`, with which a simulation needs no sympy."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from symid.axis import Axis, axis_file
from symid.codegen.store import DYNAMICS_END, HEADER, generated_folder
from symid.errors import SymidError


def dynamics_file(folder: Path, axis: str) -> Path:
    """File of the forward dynamics of an axis."""
    return folder / f"{axis}{DYNAMICS_END}"


def dynamics_text(axis: Axis, dynamics: Mapping[str, Any]) -> str:
    """Text of a file of forward dynamics: one entry per line, then the hash of all entries."""
    entries = {
        "about": f"Forward dynamics of axis {axis.name}. {HEADER}",
        "signature": axis.signature,
        **dynamics,
    }
    lines = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in entries.items()]
    return "{\n" + ",\n".join([*lines, f'"sha256": "{_hash(entries)}"']) + "\n}\n"


def _hash(entries: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(entries).encode()).hexdigest()


def stored_dynamics(axis: Axis) -> dict[str, Any] | None:
    """Forward dynamics from the folder of generated modules; None without an intact file for this declaration."""
    try:
        path = dynamics_file(generated_folder(axis_file(axis.name)), axis.name)
        entries = json.loads(path.read_text(encoding="utf-8"))
        is_whole = entries.pop("sha256") == _hash(entries)
    except (SymidError, OSError, ValueError, AttributeError, TypeError, KeyError, RecursionError):
        return None
    return entries if is_whole and entries["signature"] == axis.signature else None
