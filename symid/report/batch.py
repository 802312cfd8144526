"""The summary of a batch as tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from symid.report.console import plain, report_console
from symid.report.numbers import MISSING, significant, words

_MOST_LINES = 10


def print_batch(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the summary of `symid.fleet.summary_of`."""
    console = console or report_console()
    reused = f", {record['reused']} of them as they were" if record["reused"] else ""
    console.print(f"{record['logs']} logs{reused}", highlight=False)
    console.print(_table("Status", ("", "logs"), [(name, str(n)) for name, n in record["status"].items()]))
    for axis, parameters in record["parameters"].items():
        if parameters:
            console.print(_parameters(axis, parameters))
    if "effects" in record:
        console.print(
            _table("Verdict", ("", "logs"), [(words(v), str(n)) for v, n in record["verdicts"].items()])
        )
        console.print(_effects(record["effects"]))
    for trouble in record["not_ok"][:_MOST_LINES]:
        console.print(plain(f"{trouble['log']}: {trouble['status']}: {trouble['message']}"))
    if (more := record["logs"] - record["status"].get("ok", 0) - _MOST_LINES) > 0:
        console.print(f"and {more} more that are not ok: see the column message")
    if record["former_table"]:
        console.print(plain(f"the former table held other logs too: it is kept as {record['former_table']}"))
    if record["output"]:
        console.print(plain(f"rows: {', '.join(record['output'])}"))


def _parameters(axis: str, parameters: list[dict[str, Any]]) -> Table:
    lines = [
        (
            p["name"],
            p["measured"],
            str(p["logs"]),
            significant(p["median"], 6),
            significant(p["spread"]),
            MISSING if p["std"] is None else significant(p["std"]),
            p["unit"],
        )
        for p in parameters
    ]
    headings = ("", "sensors", "logs", "median", "spread", "std of one log", "unit")
    return _table(f"Parameters of {axis} over the logs that are ok", headings, lines)


def _effects(effects: list[dict[str, Any]]) -> Table:
    lines = [
        (
            words(e["effect"]),
            e["at"],
            str(e["logs"]),
            ", ".join(f"{axis} {n}" for axis, n in e["axes"].items()),
        )
        for e in effects
    ]
    return _table("Effects", ("", "at", "logs", "axes"), lines)


def _table(title: str, headings: tuple[str, ...], lines: Sequence[tuple[str, ...]]) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for heading in headings:
        table.add_column(heading, justify="right" if heading in _NUMBERS else "left")
    for line in lines:
        table.add_row(*map(plain, line))
    return table


_NUMBERS = ("logs", "median", "spread", "std of one log")
