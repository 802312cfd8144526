"""Settings that messages of the library name, as options of the command line."""

from __future__ import annotations

import re
from typing import Any, Final

_OPTIONS: Final = {
    "columns": "--column",
    "controller": "--controller-gain",
    "cutoff_hz": "--cutoff",
    "filter_force=True": "--filter all",
    "fixed": "--fix",
    "gains": "--gain",
    "nominal": "--nominal P.json",
    "prior": "--prior P.json",
    "rate_hz": "--rate",
    "sampling_period": "--rate",
    "seconds": "--timeout",
    "units": "--unit",
    **{
        name: f"--{name}"
        for name in (
            "held",
            "jobs",
            "joint",
            "known",
            "late",
            "measured",
            "memory",
            "method",
            "resample",
            "scheduler",
            "standstill",
            "to",
            "trim",
        )
    },
}
_SETTING: Final = re.compile(r"`((\w+)(?:=([^`]+))?)`")


def with_options(value: Any) -> Any:
    """Text, or a record with texts, in which settings between backquotes are written as options.

    >>> with_options("jitters: give `resample=own`, or lower `cutoff_hz`")
    'jitters: give --resample own, or lower --cutoff'
    >>> with_options({"notes": ["take `filter_force=True`", "column `x`"]})
    {'notes': ['take --filter all', 'column `x`']}
    """
    if isinstance(value, str):
        return _SETTING.sub(_option, value) if "`" in value else value
    if isinstance(value, dict):
        return {name: with_options(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [with_options(part) for part in value]
    return value


def _option(found: re.Match[str]) -> str:
    whole, name, value = found.groups()
    option = _OPTIONS.get(whole) or _OPTIONS.get(name)
    if option is None:
        return found[0]
    return f"{option} {value}" if value and whole not in _OPTIONS else option
