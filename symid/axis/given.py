"""An axis given by its declaration, its name, the path of its file, or a model of it."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, Protocol, TypeAlias, TypeVar

from symid.axis.axis import Axis
from symid.axis.loading import load_axis
from symid.errors import SettingError


class ModelOfAxis(Protocol):
    """A derived or generated model, which knows its axis or the name of it."""

    @property
    def axis(self) -> Axis | str:
        """The declaration, or its name."""
        ...


AnyAxis: TypeAlias = Axis | str | os.PathLike[str] | ModelOfAxis
"""A declaration, the name or path of its file, or a model of it."""
P = ParamSpec("P")
R = TypeVar("R")


def axis_of(given: AnyAxis) -> Axis:
    """The declaration of an axis given as such, by name or path, or by a model.

    Raises
    ------
    SettingError
        If it is anything else.

    Examples
    --------
    >>> axis_of("rigid_1m").drives[0].signal
    'F'
    """
    named = given if isinstance(given, (Axis, str, os.PathLike)) else getattr(given, "axis", None)
    if isinstance(named, Axis):
        return named
    if isinstance(named, (str, os.PathLike)):
        return load_axis(os.fspath(named))
    raise SettingError(
        f"{type(given).__name__} is not an axis: give an Axis, the name or path of its file, or a model of it"
    )


def of_any_axis(function: Callable[Concatenate[Axis, P], R]) -> Callable[Concatenate[AnyAxis, P], R]:
    """Let a function of a declared axis also take a name, a path or a model.

    >>> of_any_axis(lambda axis: axis.drives[0].signal)("rigid_1m")
    'F'
    """

    @wraps(function)
    def by_any(axis: AnyAxis, *args: P.args, **settings: P.kwargs) -> R:
        return function(axis_of(axis), *args, **settings)

    return by_any  # type: ignore[return-value]  # the first argument may still be named
