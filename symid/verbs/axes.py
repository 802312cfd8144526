"""Axes, given by declaration, name, path or model."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Concatenate, ParamSpec, TypeAlias, TypeVar

from symid.axis import Axis, load_axis
from symid.codegen import GeneratedModel
from symid.errors import SettingError

if TYPE_CHECKING:
    from symid.symbolic import DerivedModel

AnyAxis: TypeAlias = "Axis | str | GeneratedModel | DerivedModel"
"""A declaration, the name or path of its file, or a model of it."""
P = ParamSpec("P")
R = TypeVar("R")


def axis_of(given: AnyAxis) -> Axis:
    """The declaration of an axis given as such, by name or path, or by a model; SettingError for anything else."""
    if isinstance(given, Axis):
        return given
    if isinstance(given, str):
        return load_axis(given)
    if isinstance(given, GeneratedModel):
        return load_axis(given.axis)
    axis = getattr(given, "axis", None)
    if isinstance(axis, Axis):
        return axis
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
