"""Tables of results as a batch writes them, drawn."""

from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl

BEGIN = datetime(2026, 1, 5, 6, tzinfo=UTC)


def drawn_rows(
    axis: str,
    runs: int,
    parameters: dict[str, tuple[float, float, float]],
    seed: int = 0,
    every: timedelta = timedelta(hours=8),
) -> dict[str, np.ndarray | list]:
    """Columns of one axis; of each parameter value, promised deviation and deviation between runs."""
    draw = np.random.default_rng(seed)
    columns: dict[str, np.ndarray | list] = {
        "log": [f"logs/{axis}/run_{i:04}.parquet" for i in range(runs)],
        "content": [f"{seed:02x}{i:06x}" for i in range(runs)],
        "axis": [axis] * runs,
        "measured": ["q"] * runs,
        "method": ["wls"] * runs,
        "status": ["ok"] * runs,
        "message": [""] * runs,
        "samples": [40_000] * runs,
        "cutoff_hz": [100.0] * runs,
        "condition_number": draw.uniform(20, 40, runs),
        "residual_relative": draw.uniform(0.02, 0.04, runs),
        "seconds": draw.uniform(0.05, 0.1, runs),
        "recorded": [(BEGIN + i * every).isoformat() for i in range(runs)],
    }
    for name, (value, promised, between) in parameters.items():
        deviations = promised * draw.uniform(0.7, 1.4, runs)
        columns[name] = value + draw.normal(0, np.hypot(deviations, between))
        columns[f"{name}_std"] = deviations
    return columns


def fleet_example(runs: int = 120) -> pl.DataFrame:
    """Three axes: a bolt tightened, a guide that wears, one that stays; some logs that failed, one outlier."""
    rail = drawn_rows(
        "rigid_1m", runs, {"M": (100.0, 0.2, 0.0), "Fv": (80.0, 1.0, 0.0), "Fs": (30.0, 0.25, 1.2)}, 1
    )
    rail["Fs"] = rail["Fs"] + np.where(np.arange(runs) >= runs // 2, 9.0, 0.0)
    rail["M"][runs // 3] += 4.0
    worn = drawn_rows(
        "emps", runs, {"M": (95.0, 0.1, 0.0), "Fv": (200.0, 2.0, 0.0), "Fc": (20.0, 0.3, 0.0)}, 2
    )
    worn["Fc"] = worn["Fc"] + np.linspace(0, 6, runs)
    steady = drawn_rows("direct_2m1s", runs, {"Ms": (3899.0, 30.0, 0.0), "Ks": (4.0e8, 2e6, 0.0)}, 3)
    tables = [pl.DataFrame(one) for one in (rail, worn, steady)]
    verdicts = ["effect", "no_gap", "no_gap", "parameters", "unexplained"]
    table = pl.concat(tables, how="diagonal").with_row_index("i")
    names = [name for name in table.columns if f"{name}_std" in table.columns or name.endswith("_std")]
    failed = (pl.col("i") % 17) == 5
    return table.with_columns(
        *(pl.when(failed).then(None).otherwise(pl.col(name)).alias(name) for name in names),
        pl.when(failed).then(pl.lit("unreadable")).otherwise(pl.col("status")).alias("status"),
        pl.when(failed).then(pl.lit("log is cut short")).otherwise(pl.col("message")).alias("message"),
        pl.Series("verdict", [verdicts[i % 5] for i in range(table.height)]),
        pl.Series("effect", ["stribeck_friction" if i % 5 == 0 else None for i in range(table.height)]),
        pl.Series("at", ["motor" if i % 5 == 0 else None for i in range(table.height)]),
        pl.Series("probability", [0.93 if i % 5 == 0 else None for i in range(table.height)]),
    ).drop("i")
