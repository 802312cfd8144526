"""Identified parameters with their units and covariance, as a record for JSON."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symid.codegen import compiled
from symid.errors import SettingError
from symid.estimation import correlation_matrix
from symid.export.exported import require_physical
from symid.symbolic import DerivedModel


def parameter_record(
    model: DerivedModel,
    values: Mapping[str, float],
    covariances: Mapping[str, Any] | None = None,
    minimal: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """Minimal and physical parameters: values, standard deviations, units, covariance and correlation.

    Parameters
    ----------
    model : DerivedModel
        Axis and sensors.
    values : mapping of str to float
        Physical parameters, SI.
    covariances : mapping, optional
        ``minimal`` and ``physical`` covariance in the order of the declaration, as `symid identify --json` writes
        them; without them, deviations and correlations are None.
    minimal : mapping of str to float, optional
        Estimated minimal parameters; by default they are computed from `values`.

    Raises
    ------
    SettingError
        If no machine has the values, or a covariance does not match this axis and these sensors.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.symbolic import derive
    >>> record = parameter_record(derive(load_axis("rigid_1m")), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> record["minimal"]["names"], record["minimal"]["values"], record["minimal"]["units"]
    (['X1', 'X2', 'X3'], [95.0, 200.0, 20.0], ['kg', 'N*s/m', 'N'])
    """
    module, axis = compiled(model), model.axis
    require_physical(axis, values)
    known = covariances or {}
    if minimal is None:
        minimal_values = module.minimal_parameters(*(values[name] for name in module.physical_units))
        minimal = dict(zip(module.minimal_units, map(float, minimal_values), strict=True))
    if missing := [name for name in module.minimal_units if name not in minimal]:
        raise SettingError(
            f"the minimal parameter {missing[0]} has no value: give `measured` as it was identified, or physical "
            "values alone"
        )
    return {
        "axis": axis.name,
        "signature": axis.signature,
        "measured": list(model.measured),
        "units": "SI",
        "minimal": _table("minimal", minimal, module.minimal_units, known.get("minimal")),
        "physical": _table("physical", values, module.physical_units, known.get("physical")),
    }


def _table(
    kind: str,
    values: Mapping[str, float],
    units: Mapping[str, str],
    covariance: Sequence[Sequence[float | None]] | None,
) -> dict[str, Any]:
    table: dict[str, Any] = {
        "names": list(units),
        "values": [values[name] for name in units],
        "units": list(units.values()),
        **dict.fromkeys(("std", "covariance", "correlation")),
    }
    if covariance is None:
        return table
    try:
        matrix = np.array(covariance, dtype=float)
    except (TypeError, ValueError) as error:
        raise SettingError(f"the covariance of the {kind} parameters is not a matrix of numbers") from error
    if matrix.shape != (len(units), len(units)):
        raise SettingError(
            f"the covariance of the {kind} parameters is of shape {matrix.shape}, there are {len(units)} of them: "
            "give `measured` as it was identified"
        )
    return {
        **table,
        "std": np.sqrt(np.maximum(np.diag(matrix), 0.0)).tolist(),
        "covariance": matrix.tolist(),
        "correlation": correlation_matrix(matrix).tolist(),
    }
