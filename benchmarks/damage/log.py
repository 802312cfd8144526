"""The good log that is damaged: a rigid axis with known parameters."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import polars as pl
import scipy
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Columns = dict[str, NDArray[np.generic]]

AXIS = "rigid_1m"
TRUTH: Mapping[str, float] = {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
SAMPLES = 3000
RATE = 1000.0
FORMS = ("csv", "parquet", "mat")


def good_log(seed: int) -> Columns:
    """Time, position and force: three sines, sensor noise of 0.1 um and 0.3 N on 20 N."""
    rng, t = np.random.default_rng(seed), np.arange(SAMPLES) / RATE
    q, v, a = np.zeros((3, SAMPLES))
    for amplitude, w in ((0.05, 9.0), (0.01, 23.0), (0.001, 71.0)):
        phase = rng.uniform(0, 2 * np.pi)
        q += amplitude * np.sin(w * t + phase)
        v += amplitude * w * np.cos(w * t + phase)
        a -= amplitude * w**2 * np.sin(w * t + phase)
    force = TRUTH["M"] * a + TRUTH["Fv"] * v + TRUTH["Fs"] * np.sign(v)
    noise = rng.standard_normal((2, SAMPLES))
    return {"t": t, "q": q + 1e-7 * noise[0], "F": force + 0.3 * noise[1]}


def as_bytes(columns: Columns, form: str) -> bytes:
    out = io.BytesIO()
    if form == "mat":
        scipy.io.savemat(out, {name.split(" ")[0]: values for name, values in columns.items()})
    elif form == "parquet":
        pl.DataFrame(columns, strict=False).write_parquet(out, row_group_size=1000)
    else:
        pl.DataFrame(columns, strict=False).write_csv(out)
    return out.getvalue()


def write(folder: Path, content: bytes, suffix: str) -> Path:
    file = folder / f"log.{suffix}"
    file.write_bytes(content)
    return file
