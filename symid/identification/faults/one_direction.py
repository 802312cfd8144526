"""Motion in one direction alone: dry friction is then a constant force."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from symid.arrays import FloatArray, unexplained_by
from symid.codegen import GeneratedModel
from symid.identification.criteria import CRITERIA
from symid.identification.rows.excerpts import Excerpt

_MOVE = "move in both directions"


def one_direction(model: GeneratedModel, parts: Sequence[Excerpt]) -> tuple[str, str]:
    """Statements on dry friction that another column imitates, and on what its estimate contains otherwise.

    Both are empty where the axis moves in both directions. Beside rests, where friction takes any value up to its
    level, filters leave a transient that seems to distinguish it from a constant force.
    """
    minimal = list(model.minimal_units)
    for equation, column in _dry_friction(model):
        W = np.concatenate([p.observation.W[equation][p.observation.valid[equation]] for p in parts])
        if not W.size or not _is_of_one_sign(W[:, column]):
            continue
        # In one direction the column is a constant. If the others explain it, the two cannot be separated.
        unexplained = unexplained_by(np.delete(W, column, axis=1), np.sign(W[:, column]))
        name = minimal[column]
        if np.sqrt(np.mean(unexplained**2)) < CRITERIA.friction_alike:
            return (
                f"the axis moves in one direction only, in which {name} and others are one force: {_MOVE}",
                "",
            )
        return "", (
            f"the axis moves in one direction only, in which a constant force, such as a weight or an offset of "
            f"{model.output_names[equation]}, counts as the friction {name}: {_MOVE} to tell them apart"
        )
    return "", ""


@lru_cache(maxsize=16)
def _dry_friction(model: GeneratedModel) -> list[tuple[int, int]]:
    """Equation and column of each law that depends on the direction of the motion alone, as the sign of a speed."""
    # At a random motion, at twice that and at its reverse: such a column ignores the size and follows the direction.
    once = dict(
        zip(model.signals, np.random.default_rng(0).standard_normal((len(model.signals), 9)), strict=True)
    )
    at, twice, back = (model.sample({name: k * x for name, x in once.items()})[0] for k in (1.0, 2.0, -1.0))
    return [
        (j, column)
        for j, column in model.law_columns
        if np.array_equal(at[j, :, column], twice[j, :, column])
        and np.array_equal(at[j, :, column], -back[j, :, column])
    ]


def _is_of_one_sign(column: FloatArray) -> bool:
    """Whether a column is a level of one sign, as that of dry friction in one direction.

    >>> _is_of_one_sign(np.full(5, -1.0)), _is_of_one_sign(np.array([1.0, -1.0])), _is_of_one_sign(np.arange(9.0))
    (True, False, False)
    """
    level = float(np.median(column))
    return bool(
        level != 0.0 and np.all(column * level >= 0.0) and np.std(column / level) < CRITERIA.friction_level
    )
