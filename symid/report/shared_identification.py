"""Parameters that groups of logs share, as a JSON record and as a table."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from symid.identification import SharedIdentification
from symid.report.console import TextTable, report_console
from symid.report.identification import identification_record


def shared_record(found: SharedIdentification) -> dict[str, Any]:
    """Record of `symid identify --known ... --json`: the physical parameters, and each group of logs."""
    first = found.groups[0]
    return {
        "axis": found.axis,
        "measured": list(first.model.measured),
        "method": first.fit.method,
        "log": [log for group in found.groups for log in group.logs],
        "status": found.status,
        "message": found.message,
        "physical": {
            name: {
                "value": value,
                "std": std,
                "std_corrected": std,
                "relative_std_percent": 100 * std / abs(value) if value else None,
                "unit": unit,
            }
            for (name, unit), value, std in zip(
                found.physical_units.items(),
                found.parameters.tolist(),
                found.standard_deviations.tolist(),
                strict=True,
            )
        },
        "relations": {
            "number": found.relations,
            "disagreement": found.disagreement,
            "probability": found.probability,
        },
        "groups": [
            {**identification_record(group), "known": dict(known)}
            for group, known in zip(found.groups, found.known, strict=True)
        ],
    }


def print_shared(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `shared_record`."""
    console = console or report_console()
    console.print(f"[bold]{record['axis']}[/bold] from {', '.join(record['measured'])}", end="")
    console.print(f", {len(record['groups'])} groups of logs: {record['status']}", markup=False)
    if record["message"]:
        console.print(record["message"], markup=False)
    for group in record["groups"]:
        given = ", ".join(f"{name} = {value:.6g}" for name, value in group["known"].items())
        console.print(f"  {given}: {', '.join(group['log'])}", markup=False)
    table = TextTable("", "parameter", "value", "std", "%", "unit")
    for name, one in record["physical"].items():
        share = "" if one["relative_std_percent"] is None else f"{one['relative_std_percent']:.2g}"
        table.add(name, f"{one['value']:.6g}", f"{one['std']:.2g}", share, one["unit"])
    console.print(table)
