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
        kept: Any = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no place that can be written
        return numba.njit(error_model="numpy")(function)
    # Kept by another version of symid, code may be for records that are no longer there: it is compiled again.
    files = kept._cache._cache_file
    load = files._load_index

    def load_if_readable() -> Any:
        try:
            return load()
        except (AttributeError, ImportError):
            return {}

    files._load_index = load_if_readable
    return kept  # type: ignore[no-any-return]
