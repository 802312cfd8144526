"""Loops over samples, compiled by numba and kept on disk, where there is a place for them."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys


def jitted(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of numbers and arrays as machine code, which is compiled at the first call.

    Machine code is kept beside the module, or in the user's cache if that cannot be written; where neither can,
    each process compiles again. It is made for the sources that it comes from: after a change it is compiled again.

    Examples
    --------
    >>> jitted(lambda x: x * x)(3.0)
    9.0
    """
    return _compiled(function)


def inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """As `jitted`, for a function that compiled code alone calls.

    It has no entry from Python, which for records of many arrays takes longer to compile than the function itself.
    """
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """As `inner`, for a function that is called in one place: it becomes a part of its caller.

    Numba makes machine code of a function together with all that it calls, once for each of its callers.
    """
    return _compiled(function, inline="always")


def _compiled(function: Callable[..., Any], **options: bool | str) -> Callable[..., Any]:
    function.__qualname__ += f"_{_fingerprint(function)}"  # a part of the name under which code is kept
    njit: Any = numba.njit  # whose annotations do not know all options
    try:
        kept = njit(cache=True, error_model="numpy", **options)(function)
    except RuntimeError:  # no place that can be written
        return njit(error_model="numpy", **options)(function)  # type: ignore[no-any-return]
    cache, files = kept._cache, kept._cache._cache_file
    load_index = files._load_index

    def load_if_readable() -> Any:
        try:  # kept by another version of symid, code may be for records that are no longer there: it is made again
            return load_index()
        except (AttributeError, ImportError):
            return {}

    def load_overload(signature: Any, target: Any) -> Any:
        # Numba would first load all that it compiles by, for 0.25 s: code that is kept needs its memory manager alone.
        rtsys.initialize(target)
        with cache._guard_against_spurious_io_errors():
            return cache._load_overload(signature, target)

    files._load_index, cache.load_overload = load_if_readable, load_overload
    return kept  # type: ignore[no-any-return]


def _fingerprint(function: Callable[..., Any]) -> str:
    """Hash of the module of a function, and of the compiled functions and constants that it imports.

    Numba asks for changes of the function's file only, though machine code contains what it calls.
    """
    source = Path(function.__code__.co_filename)
    digest = hashlib.sha256(source.read_bytes() if source.is_file() else b"")
    for name, value in sorted(function.__globals__.items()):
        if isinstance(value, Dispatcher) and value.py_func.__module__ != function.__module__:
            digest.update(f"{name} {value.py_func.__qualname__}".encode())
        elif isinstance(value, int | float) and not name.startswith("__"):
            digest.update(f"{name} {value!r}".encode())
    return digest.hexdigest()[:12]
