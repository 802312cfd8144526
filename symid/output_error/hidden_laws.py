"""Models of axes with nonlinear laws, such as Coulomb friction, at bodies whose motion no sensor determines.

No regressor has a column for such a law: it cannot be eliminated. Output error needs none, because it simulates. It
takes names and maps from the model of the axis without these laws; their parameters are minimal ones themselves.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray, combination_of
from symid.axis import Axis, PendulumWeight
from symid.codegen import GeneratedModel, model_of
from symid.errors import EliminationError
from symid.simulation import forward_dynamics


class Models(NamedTuple):
    """Models of an axis: with all parameters (its regressor is that of `visible`), and without laws at hidden bodies.

    Without hidden laws both are the same model.
    """

    whole: GeneratedModel
    visible: GeneratedModel


def models_of(axis: Axis, measured: Sequence[str]) -> Models:
    """Models of an axis for output error; EliminationError if it cannot be derived without the hidden laws either.

    >>> from symid.axis import CoulombFriction, load_axis
    >>> axis = load_axis("ballscrew_2m1s")
    >>> hidden = axis.with_effect(CoulombFriction(axis.bodies[1], "Fsl"))
    >>> list(models_of(hidden, ("qm",)).whole.minimal_units)[-2:]
    ['X7', 'Fsl']
    """
    try:
        model = model_of(axis, measured)
        return Models(model, model)
    except EliminationError:
        names = _at_hidden_joints(axis, measured)
        if not names:
            raise
    # Regressors exist without the hidden laws. Their parameters join the minimal ones as they are; only the simulation
    # of output error uses them.
    laws = [
        law for law in axis.laws if names.intersection(t.parameter for t in law.terms() if not t.is_linear)
    ]
    weights = [e for e in axis.elements if isinstance(e, PendulumWeight) and e.named("moment") in names]
    visible = model_of(axis.without(*laws, *weights), measured)
    units = {name: str(unit) for name, unit in axis.physical_parameters.items()}
    places = [i for i, name in enumerate(units) if name in visible.physical_units]
    others = {name: unit for name, unit in units.items() if name not in visible.physical_units}

    def minimal_parameters(*physical: float) -> FloatArray:
        seen = visible.minimal_parameters(*(physical[i] for i in places))
        return np.append(seen, [x for i, x in enumerate(physical) if i not in places])

    whole = replace(
        visible,
        signature=axis.signature,
        minimal_units={**visible.minimal_units, **others},
        physical_units=units,
        signed=axis.signed_parameters,
        per_log=(*visible.per_log, *(name for name in others if name in axis.log_parameters)),
        minimal_parameters=minimal_parameters,
        physical_parameters=None,
        assumptions=(*visible.assumptions, f"{', '.join(others)} act on hidden motion, which is simulated"),
    )
    return Models(whole, visible)


def _at_hidden_joints(axis: Axis, measured: Sequence[str]) -> set[str]:
    """Parameters of nonlinear laws in joints whose motion is not a combination of measured positions and velocities."""
    dynamics = forward_dynamics(axis)
    rows = np.stack(
        [
            sensor.row
            for name, sensor in dynamics.sensors.items()
            if name in measured and sensor.order in (0, 1)
        ]
    )
    names: set[str] = set()
    for direction, terms in dynamics.laws:
        if combination_of(rows, direction) is None:
            names = names.union(*(dynamics.names(term.parameter) for term in terms))
    return names
