"""`derive`, `simulate`, `tune` and the models of any axis."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from symid.axis import AnyAxis, Axis, axis_of, of_any_axis
from symid.codegen import GeneratedModel, as_generated
from symid.codegen import load_generated as load_generated_of
from symid.simulation import simulate as simulate_axis
from symid.symbolic import DerivedModel
from symid.symbolic import derive as derive_axis
from symid.tuning import tune as tune_axis

derive = of_any_axis(derive_axis)
simulate = of_any_axis(simulate_axis)
tune = of_any_axis(tune_axis)


def compiled(axis: AnyAxis, measured: Sequence[str] | None = None) -> GeneratedModel:
    """The generated model of an axis, in memory; one that is derived already has its own sensors.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        The axis, the name or path of its file, or a model of it.
    measured : sequence of str, optional
        Sensors to use; by default those that the axis requires.

    Examples
    --------
    >>> compiled("rigid_1m").output_names
    ('F',)
    """
    if isinstance(axis, (GeneratedModel, DerivedModel)):
        return as_generated(axis)
    return as_generated(derive(axis, measured))


def load_generated(
    axis: AnyAxis, measured: Sequence[str] | None = None, folder: Path | None = None
) -> GeneratedModel:
    """The generated module of an axis, as `symid.codegen.load_generated`; that of a model has its sensors.

    Parameters
    ----------
    axis : Axis, str, path-like or model
        The axis, the name or path of its file, or a model of it.
    measured : sequence of str, optional
        Sensors to use; by default those that the axis requires.
    folder : Path, optional
        Folder of generated modules; that of the working folder, then that of symid, by default.

    Examples
    --------
    >>> load_generated("direct_2m1s", ("q2",)).signals
    ('Fm', 'Fm_d1', 'Fm_d2', 'q2_d1', 'q2_d2', 'q2_d3', 'q2_d4')
    """
    if isinstance(axis, (GeneratedModel, DerivedModel)):
        measured = measured or axis.measured
    return load_generated_of(axis if isinstance(axis, (Axis, str)) else axis_of(axis), measured, folder)
