"""Logs of a rigid axis, short enough that a batch of them takes no time."""

from pathlib import Path

import numpy as np
import polars as pl

TRUE = {"M": 5.0, "Fv": 3.0, "Fs": 2.0}


def write_log(path: Path, seed: int, mass: float = TRUE["M"], offset: float = 0.0) -> Path:
    """A log of rigid_1m with noise of its own."""
    rng = np.random.default_rng(seed)
    t = np.arange(2000) / 1000
    q, v, a = np.zeros((3, t.size))
    for amplitude, w in ((0.1, 9.0), (0.02, 31.0), (0.006, 53.0)):
        q += amplitude * np.sin(w * t)
        v += amplitude * w * np.cos(w * t)
        a -= amplitude * w**2 * np.sin(w * t)
    force = mass * a + TRUE["Fv"] * v + TRUE["Fs"] * np.sign(v) + offset + 0.05 * rng.standard_normal(t.size)
    frame = pl.DataFrame({"t": t, "q": q, "F": force})
    if path.suffix == ".csv":
        frame.write_csv(path)
    else:
        frame.write_parquet(path)
    return path
