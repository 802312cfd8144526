"""Generated models of any axis: the stored ones, or ones that are derived on the spot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from symid.axis import Axis, load_axis
from symid.codegen.model import GeneratedModel
from symid.codegen.store import DERIVED, load_generated
from symid.errors import SymidError

if TYPE_CHECKING:
    from symid.symbolic.pipeline import DerivedModel


def model_of(axis: str | Axis, measured: Sequence[str] | None = None) -> GeneratedModel:
    """The generated model of an axis; without a current module it is derived and kept in memory.

    Parameters
    ----------
    axis : str or Axis
        Name or path of an axis file, or a declaration, which need not be in any file.
    measured : sequence of str, optional
        Signals of the sensors; the first sensor by default.

    Raises
    ------
    SymidError
        If the axis does not exist or cannot be derived.

    Examples
    --------
    >>> from symid.axis import Axis, Body, Drive, Position
    >>> body = Body("body", mass="M")
    >>> model_of(Axis("free", (body,), Drive("F", body), (Position("q", body),))).signals
    ('F', 'q_d2')
    """
    declared = axis if isinstance(axis, Axis) else load_axis(axis)
    signals = tuple(
        sensor.signal for sensor in declared.measured(None if measured is None else tuple(measured))
    )
    try:
        return load_generated(axis, signals)
    except SymidError:
        # sympy is needed only without a module.
        from symid.codegen.generate import derived_text

        DERIVED[declared.signature, declared.name, signals] = derived_text(declared, signals)
        return load_generated(declared, signals)


def as_generated(model: GeneratedModel | DerivedModel) -> GeneratedModel:
    """Generated model of a derived one; a generated model is returned as it is."""
    if isinstance(model, GeneratedModel):
        return model
    # A derived model exists only where sympy is loaded already.
    from symid.codegen.generate import compiled

    return compiled(model)
