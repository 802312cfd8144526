"""Loops over samples, compiled by numba and kept on disk, where there is a place for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of numbers and arrays as machine code, which is compiled at the first call.

    Machine code is kept beside the module, or in the user's cache if that cannot be written; where neither can,
    each process compiles again.

    Examples
    --------
    >>> compiled(lambda x: x * x)(3.0)
    9.0
    """
    try:
        kept: Callable[..., Any] = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no place that can be written
        kept = numba.njit(error_model="numpy")(function)
    return kept
