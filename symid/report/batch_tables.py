"""The summary of a batch as tables."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from symid.report.console import TextTable, plain, report_console
from symid.report.number_text import MISSING, significant, words

_MOST_LINES = 10


def print_batch(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the summary of `symid.fleet.summary_of`."""
    console = console or report_console()
    reused = f", {record['reused']} of them as they were" if record["reused"] else ""
    console.print(f"{record['logs']} logs{reused}", highlight=False)
    console.print(_counts("Status", record["status"]))
    for axis, parameters in record["parameters"].items():
        if parameters:
            console.print(_parameters(axis, parameters))
    if "effects" in record:
        console.print(_counts("Verdict", {words(name): n for name, n in record["verdicts"].items()}))
        effects = TextTable("Effects", "", "at", "logs", "axes", right=("logs",))
        for e in record["effects"]:
            axes = ", ".join(f"{axis} {n}" for axis, n in e["axes"].items())
            effects.add(words(e["effect"]), e["at"], str(e["logs"]), axes)
        console.print(effects)
    for trouble in record["not_ok"][:_MOST_LINES]:
        console.print(plain(f"{trouble['log']}: {trouble['status']}: {trouble['message']}"))
    if (more := record["logs"] - record["status"].get("ok", 0) - _MOST_LINES) > 0:
        console.print(f"and {more} more that are not ok: see the column message")
    if record["former_table"]:
        console.print(plain(f"the former table held other logs too: it is kept as {record['former_table']}"))
    if record["output"]:
        console.print(plain(f"rows: {', '.join(record['output'])}"))


def _counts(title: str, logs: dict[str, int]) -> TextTable:
    table = TextTable(title, "", "logs", right=("logs",))
    for name, count in logs.items():
        table.add(name, str(count))
    return table


def _parameters(axis: str, parameters: list[dict[str, Any]]) -> TextTable:
    numbers = ("logs", "median", "spread", "std of one log")
    title = f"Parameters of {axis} over the logs that are ok"
    table = TextTable(title, "", "sensors", *numbers, "unit", right=numbers)
    for p in parameters:
        std = MISSING if p["std"] is None else significant(p["std"])
        sizes = (str(p["logs"]), significant(p["median"], 6), significant(p["spread"]), std)
        table.add(p["name"], p["measured"], *sizes, p["unit"])
    return table
