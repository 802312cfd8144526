"""A batch in short: how many logs have each status, each parameter over the logs, which effects were found where."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import Any

import numpy as np

from symid.fleet.batch import Batch
from symid.fleet.results import count_effects
from symid.fleet.spread import robust_deviation

_MOST_TROUBLES = 20


def summary_of(batch: Batch) -> dict[str, Any]:
    """Record of `symid batch --json`.

    The spread of a parameter is a standard deviation too, from the median absolute deviation over the logs of status
    "ok", which stray logs do not move; ``std`` is the median of what the logs promise.

    Parameters
    ----------
    batch : Batch
        Its rows.
    """
    troubles = [row for row in batch.rows if row["status"] != "ok"]
    record: dict[str, Any] = {
        "logs": len(batch.rows),
        "reused": batch.reused,
        "status": batch.statuses,
        "seconds_of_work": sum(float(row.get("seconds") or 0.0) for row in batch.rows),
        "parameters": {axis: _parameters(batch, axis) for axis in batch.units},
        "not_ok": [
            {name: row.get(name) for name in ("log", "status", "message")}
            for row in troubles[:_MOST_TROUBLES]
        ],
        "output": [str(file) for file in batch.files],
        "former_table": str(batch.replaced) if batch.replaced else None,
    }
    if batch.diagnosed:
        verdicts = Counter(row["verdict"] for row in batch.rows if row.get("verdict"))
        record["verdicts"] = dict(verdicts.most_common())
        found = ((str(row.get("axis")), row.get("effect"), row.get("at")) for row in batch.rows)
        record["effects"] = [asdict(one) for one in count_effects(found)]
    return record


def _parameters(batch: Batch, axis: str) -> list[dict[str, Any]]:
    """Each parameter over the logs of an axis with the same sensors."""
    found = []
    for measured, units in batch.units[axis].items():
        wanted = {"axis": axis, "measured": measured, "status": "ok"}.items()
        rows = [r for r in batch.rows if wanted <= r.items()]
        for name, unit in units.items():
            values = np.array([r[name] for r in rows if r.get(name) is not None], dtype=float)
            found_stds = [r[f"{name}_std"] for r in rows if r.get(f"{name}_std") is not None]
            deviations = np.array(found_stds, dtype=float)
            if not values.size:
                continue
            found.append(
                {
                    "name": name,
                    "measured": measured,
                    "logs": values.size,
                    "median": float(np.median(values)),
                    "spread": robust_deviation(values),
                    "std": float(np.median(deviations)) if deviations.size else None,
                    "unit": unit,
                }
            )
    return found
