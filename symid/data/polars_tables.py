"""What polars reads of a file: its source, the values of a column, and the exceptions for one that it cannot read."""

import io
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl

from symid.arrays import FloatArray

POLARS_FAILURES: Final = (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError)
"""Exceptions of polars for a file that it cannot read."""


def source_of(path: Path) -> Path | io.BytesIO:
    """Source that polars reads: the bytes of a file if its name is not UTF-8, which polars cannot open."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        return io.BytesIO(path.read_bytes())
    return path


def values_of(numbers: pl.Series) -> FloatArray:
    """Values of a column, NaN where it has none."""
    whole = numbers.fill_null(float("nan")) if numbers.has_nulls() else numbers
    return np.asarray(whole.to_numpy(), dtype=np.float64)
