"""Coulomb friction beside a drive, which is subtracted from its force before the force is differentiated.

Rows are linear in the level of such friction. Columns of a friction of level 1 are added to those of W, recorded as
if it were the force: the columns that hold the force, and the output. Rows without friction of any level, and their
triangular factor, are combinations of all these.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import TriangularFactor, triangle
from symid.identification.rows.filtered_signals import Filtered, low_pass_of
from symid.identification.rows.sampling import STANDSTILL_SHARE, Sampling, linear_part, sample_into
from symid.signal_names import split_derivative


def force_columns(model: GeneratedModel) -> tuple[list[int], ...]:
    """Columns of W that hold the force of the drive beside each friction."""
    linear, found = linear_part(model), []
    for force in model.coulomb_drives:
        units = np.array([float(split_derivative(name)[0] == force) for name in model.signals])
        found.append(np.flatnonzero(np.any(linear.regressor(*units[:, None]) != 0.0, axis=(0, 1))).tolist())
    return tuple(found)


def more_columns(model: GeneratedModel) -> int:
    """Number of columns that friction beside drives needs after those of W: of the force, and of the output."""
    return sum(len(columns) + 1 for columns in force_columns(model))


def sample_friction(sampling: Sampling, W: FloatArray, velocities: FloatArray) -> None:
    """Fill the columns of W after those of the model with friction, by sliding velocities of shape (n_sliding, n)."""
    model, rate, size = sampling.model, 1 / sampling.period, velocities.shape[1]
    linear, begin = linear_part(model), len(model.minimal_units)
    own = (
        low_pass_of(sampling.chosen, 1.0, rate).run_over(size, rate) if sampling.chosen.filter_force else None
    )
    for (row, _), force, columns in zip(
        model.coulomb_at_drive, model.coulomb_drives, force_columns(model), strict=True
    ):
        of_force = replace(
            linear,
            minimal_units=dict.fromkeys(map(str, columns), "1"),
            regressor=lambda *signals, columns=columns: linear.regressor(*signals)[..., columns],
        )
        friction = {force: Filtered(direction(velocities[row]), own)}
        end = begin + len(columns)
        sample_into(replace(sampling, model=of_force, signals=friction, wide={}), W[:, begin:end], W[:, end])
        begin = end + 1


def without_friction(model: GeneratedModel, equation: int, levels: Sequence[float]) -> FloatArray:
    """Matrix that makes [W | y] without friction of an equation's columns [W | friction | y].

    The output gets the friction of the given levels back where a column of W is that friction.
    """
    p, place = len(model.minimal_units), len(model.minimal_units)
    taken = np.zeros((p + more_columns(model) + 1, p + 1))
    taken[:p, :p], taken[-1, -1] = np.eye(p), 1.0
    for (_, parameter), level, columns in zip(
        model.coulomb_at_drive, levels, force_columns(model), strict=True
    ):
        for column in (*columns, p):
            taken[place, column] = -level
            place += 1
        if (equation, parameter) in model.law_columns:
            taken[parameter, p] += level
    return taken


def factors_without(
    model: GeneratedModel, factors: Sequence[TriangularFactor], levels: Sequence[float]
) -> list[TriangularFactor]:
    """Triangular factors of rows without friction, from those of rows with columns of it, of all logs."""
    taken = [without_friction(model, j, levels) for j in range(len(model.output_names))]
    return [
        TriangularFactor(triangle(factor.R @ taken[k % len(taken)]), factor.rows)
        for k, factor in enumerate(factors)
    ]


def take_off(model: GeneratedModel, W: FloatArray, y: FloatArray, levels: Sequence[float]) -> None:
    """Subtract friction from rows in place: W of shape (n_equations, n_parameters + more_columns, n_rows), and y."""
    p = len(model.minimal_units)
    for j, (columns, output) in enumerate(zip(W, y, strict=True)):
        taken = without_friction(model, j, levels)
        for source, place in np.argwhere(taken[:-1] - np.eye(len(taken) - 1, p + 1)).tolist():
            changed = output if place == p else columns[place]
            changed += taken[source, place] * columns[source]


def direction(velocity: FloatArray) -> FloatArray:
    """Sign of a velocity that changes once per reversal and keeps its last value at standstill.

    A slow span in which it changes twice at most is a reversal there and back, and is taken as it is: noise around
    a standstill changes it more often.

    >>> direction(np.array([1.0, 0.001, -0.001, 0.001, -0.001, -1.0, 0.0, -0.001, -1.0])).tolist()
    [1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0]
    >>> direction(np.array([1.0, 0.001, -0.001, -0.001, 0.001, 1.0])).tolist()
    [1.0, 1.0, -1.0, -1.0, 1.0, 1.0]
    """
    sign = np.sign(velocity)
    if not velocity.size:
        return sign
    level = STANDSTILL_SHARE * max(float(velocity.max()), -float(velocity.min()))
    slow = np.flatnonzero((velocity <= level) & (velocity >= -level))
    if not slow.size:
        return sign
    begins = np.flatnonzero(np.diff(slow, prepend=-2) > 1)  # of each span of slow samples
    lengths = np.diff(begins, append=slow.size)
    last = np.minimum(slow[begins + lengths - 1] + 1, velocity.size - 1)
    changed = (sign[slow] != sign[np.maximum(slow - 1, 0)]) + 3 * (sign[slow] == 0.0)
    changes = np.add.reduceat(changed, begins) + (sign[last] != sign[last - 1])
    before = np.repeat(sign[np.maximum(slow[begins] - 1, 0)], lengths)
    behind = np.repeat(sign[last], lengths)
    turned = (sign[slow] == behind) & (before != behind)
    # the first sample of a reversal that has the new direction, and all behind it
    since = np.maximum.accumulate(np.where(turned, np.arange(slow.size), -1)) >= np.repeat(begins, lengths)
    once = np.where(since, behind, before)
    sign[slow] = np.where(np.repeat(changes <= 2, lengths), sign[slow], once)
    return sign
