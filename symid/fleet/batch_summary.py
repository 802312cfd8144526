"""Summary of a batch: statuses, statistics of the parameters, logs that failed, effects found."""

from collections import Counter
from dataclasses import asdict
from typing import Any

import numpy as np

from symid.fleet.batch import Batch
from symid.fleet.results import count_effects, without_repeats
from symid.fleet.spread import robust_deviation

_MOST_TROUBLES = 20  # logs that are named


def summary_of(batch: Batch) -> dict[str, Any]:
    """Summary of a batch, the record of `symid batch --json`.

    ``spread`` is the robust standard deviation of a parameter over the logs of status "ok", from the median absolute
    deviation; ``std`` is the median of the standard deviations of these logs; a minimal parameter ``repeats`` what the
    physical ones say.

    Parameters
    ----------
    batch : Batch
        The batch.
    """
    troubles = [row for row in batch.rows if row["status"] != "ok"][:_MOST_TROUBLES]
    record: dict[str, Any] = {
        "logs": len(batch.rows),
        "reused": batch.reused,
        "status": batch.statuses,
        "seconds_of_work": sum(float(row.get("seconds") or 0.0) for row in batch.rows),
        "parameters": {axis: _parameters(batch, axis) for axis in batch.units},
        "not_ok": [{name: row.get(name) for name in ("log", "status", "message")} for row in troubles],
        "output": [str(file) for file in batch.files],
        "former_table": str(batch.replaced) if batch.replaced else None,
    }
    if batch.diagnosed:
        verdicts = Counter(row["verdict"] for row in batch.rows if row.get("verdict"))
        record["verdicts"] = dict(verdicts.most_common())
        effects = ((str(row.get("axis")), row.get("effect"), row.get("at")) for row in batch.rows)
        record["effects"] = [asdict(count) for count in count_effects(effects)]
    return record


def _parameters(batch: Batch, axis: str) -> list[dict[str, Any]]:
    """Statistics of each parameter over the logs of an axis, for each set of sensors."""
    records = []
    for measured, units in batch.units[axis].items():
        same = {"axis": axis, "measured": measured, "status": "ok"}.items()
        rows = [r for r in batch.rows if same <= r.items()]
        known = [name for name in units if any(row.get(name) is not None for row in rows)]
        shown = without_repeats(known, units)
        for name, unit in units.items():
            values, deviations = (
                np.array([row[column] for row in rows if row.get(column) is not None], dtype=float)
                for column in (name, f"{name}_std")
            )
            if values.size:
                records.append(
                    {
                        "name": name,
                        "measured": measured,
                        "logs": values.size,
                        "median": float(np.median(values)),
                        "spread": robust_deviation(values),
                        "std": float(np.median(deviations)) if deviations.size else None,
                        "unit": unit,
                        "repeats": name not in shown,
                    }
                )
    return records
