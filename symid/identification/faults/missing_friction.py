"""Tests of friction: for a law that the model lacks, and for Coulomb friction that varies with the speed."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.identification.criteria import CRITERIA
from symid.identification.delays.timing import Timing
from symid.identification.deviations.motion_shapes import decaying, has_speeds, speeds_of
from symid.identification.faults.added_column import AddedColumn
from symid.identification.faults.nonlinearity import ColumnTests
from symid.identification.results.identification_result import Identification
from symid.identification.results.reliability import is_beyond_intervals
from symid.identification.rows.coulomb import direction

_LAWS = {"Coulomb friction": "CoulombFriction", "viscous friction": "ViscousFriction"}
"""Laws by the names of their courses, as they are declared."""


def missing_friction(tests: ColumnTests, result: Identification, timing: Timing | None) -> str:
    """Statement on a friction law that the model lacks, where it explains more than a delay; empty without one.

    It counts if it moves parameters beyond their intervals. Without its law, friction resembles a late force: both are
    in phase with the velocity where the motion reverses.
    """
    if not has_speeds(tests.model):
        return ""
    by_delay = 1.0 - timing.remaining**2 if timing is not None and timing.is_significant else 0.0
    speeds = [speeds_of(part) for part in tests.parts]
    courses = {"viscous friction": speeds}
    if not any(tests.model.sliding):
        courses["Coulomb friction"] = [direction(v) for v in speeds]
    shares = {}
    for law, (column, outside, moves) in zip(courses, _beside(tests, result, courses.values()), strict=True):
        is_lacking = column.factor > 0.0 and outside > CRITERIA.independent  # friction takes power
        if is_lacking and moves and column.share > max(CRITERIA.friction_shape, by_delay):
            shares[law] = column.share
    if not shares:
        return ""
    law = max(shares, key=shares.__getitem__)
    return (
        f"the model lacks {law}, which explains {100 * shares[law]:.0f} % of the residual's power: declare "
        f"{_LAWS[law]}, and run `symid diagnose`"
    )


def friction_shape(tests: ColumnTests, result: Identification) -> str:
    """Statement on friction that varies with the speed, where that moves parameters beyond their intervals.

    The columns are friction that decays exponentially with the speed, at two rates.
    """
    if not any(tests.model.sliding):
        return ""
    speeds = [speeds_of(part) for part in tests.parts]
    highest = max(float(np.max(np.abs(v))) for v in speeds) or 1.0
    each = [decaying(v, highest) for v in speeds]
    for column, _, moves in _beside(tests, result, ([decays[name] for decays in each] for name in each[0])):
        if column.share > CRITERIA.friction_shape and moves:
            more = "more" if column.factor > 0 else "less"
            return (
                f"friction is not constant beside its viscous part ({more} of it at low speed explains "
                f"{100 * column.share:.2g} % of the residual's power), which biases parameters: see what `symid "
                "diagnose` finds, and declare its law (StribeckFriction, QuadraticDrag)"
            )
    return ""


def _beside(
    tests: ColumnTests, result: Identification, courses: Iterable[Sequence[FloatArray]]
) -> Iterator[tuple[AddedColumn, float, bool]]:
    """Effect of each friction, the share of its column that the model does not explain, and whether it counts.

    It counts if it is certain and moves parameters beyond their intervals.
    """
    Z, residual, y = tests.all_rows
    columns = tests.made_by(tests.model.force, *courses)
    certain = tests.certain(residual, CRITERIA.gain_certain)
    for made, column in zip(columns, AddedColumn.of_each(Z, residual, columns, y), strict=True):
        along = Z.T @ made
        outside = 1.0 - float(along @ along) / max(float(made @ made), np.finfo(float).tiny)
        without = tests.fit.solution - tests.fit.rank.inverse_root @ along * column.factor
        yield column, outside, column.share > certain and is_beyond_intervals(result, without)
