"""A force that hardly changes while the axis moves: friction alone can explain all of it."""

from collections.abc import Sequence

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.identification.rows.excerpts import Excerpt

_CHANGES = 0.01
"""Rms of a force beside a part with the sign of the motion, relative to the whole, below which it is constant."""
_DIFFERS, _SELDOM = 0.05, 0.02
"""Relative change of a force that shows friction, and the part of the motion in which filters seem to show it."""
_MOVES = 0.02
"""Column of a row as part of its largest value above which the axis moves."""
CONSTANT = (
    "{} hardly changes while the axis moves, so that the log does not distinguish friction from inertia and damping: "
    "move with several forces and in both directions, or leave the friction out"
)


def constant_force(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a force that is constant in each direction of the motion; empty without one.

    Friction of that size, without any inertia, then fits exactly, and so does every mixture of it with the true
    values: a step response determines a time constant and a gain, but no third value. A known inertia is the third
    one.
    """
    for equation, force in enumerate(model.output_names):
        laws = [column for j, column in model.law_columns if j == equation]
        if force not in model.forces or not laws or model.known:
            continue
        used = np.concatenate([used_samples(p, equation) for p in parts])
        acting = np.concatenate([p.log[force] for p in parts])[used]
        signs = np.stack([np.concatenate([law_sign(p, equation, law) for p in parts])[used] for law in laws])
        if is_constant(acting, signs):
            return CONSTANT.format(force)
    return ""


def friction_unseen(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a constant force in a model without dry friction, which it would hide; empty otherwise.

    Friction of a part of the force divides all parameters by the rest, and leaves no residual.
    """
    dry = {equation for equation, _ in model.law_columns}
    for equation, force in enumerate(model.output_names):
        if force not in model.forces or equation in dry or model.known:
            continue
        acting = np.concatenate([p.log[force][_in_motion(p, equation)] for p in parts])
        usual = float(np.median(acting)) if acting.size else 0.0
        if usual and np.mean(np.abs(acting - usual) > _DIFFERS * abs(usual)) < _SELDOM:
            return (
                f"{force} hardly changes while the axis moves: Coulomb friction, which the model does not have, would "
                "change all parameters by one factor and leave no residual; move with several forces"
            )
    return ""


def is_constant(force: FloatArray, signs: FloatArray) -> bool:
    """Whether a force hardly differs from a combination of signs of velocities, of shape (n_signs, n).

    >>> sign = np.repeat([1.0, -1.0], 50)
    >>> is_constant(3 * sign, sign[None]), is_constant(3 * sign + np.linspace(0, 1, 100), sign[None])
    (True, False)
    """
    whole, along = float(force @ force), signs @ force
    explained = along @ np.linalg.lstsq(signs @ signs.T, along, rcond=None)[0]
    return whole > 0 and whole - float(explained) < _CHANGES**2 * whole


def law_sign(part: Excerpt, equation: int, column: int) -> FloatArray:
    """Sign of a friction law at every sample."""
    return part.kept(
        (law_sign, equation, column),
        lambda: np.sign(at_samples(part, np.sign(part.observation.W[equation, :, column]))),
    )


def used_samples(part: Excerpt, equation: int) -> BoolArray:
    """Samples of the log whose nearest row of an equation is used."""
    return part.kept(
        (used_samples, equation), lambda: np.asarray(at_samples(part, part.observation.valid[equation]) > 0.5)
    )


def _in_motion(part: Excerpt, equation: int) -> BoolArray:
    """Samples of the log at which a column of an equation is not small."""
    columns = np.abs(part.observation.W[equation])
    relative = columns / np.maximum(columns.max(axis=0, initial=0.0), np.finfo(float).tiny)
    return used_samples(part, equation) & (at_samples(part, relative.max(axis=1)) > _MOVES)


def at_samples(part: Excerpt, rows: FloatArray | BoolArray) -> FloatArray:
    """Values of the rows at every sample of the log, by lines between them; those of the first and the last beyond."""
    values, step = np.asarray(rows, dtype=float), part.observation.preparation.decimation or 1
    first = round((float(part.observation.time[0]) - part.log.start) / part.log.sampling_period)
    between = values[:-1, None] + np.diff(values)[:, None] * (np.arange(step) / step)
    ends = np.full(first, values[0]), np.full(part.log.n_samples - first - between.size, values[-1])
    return np.concatenate([ends[0], between.ravel(), ends[1]])
