"""A change within a log is sought in the directions of the parameters that the log shows."""

import numpy as np
import pytest

from symid.identification.deviations.stability import greatest_change
from symid.identification.deviations.whitened import Segment


def test_a_parameter_that_no_segment_sees_keeps_its_value() -> None:
    """Three parameters in two coordinates: the first doubles in the last quarter, the third is not seen."""
    rng = np.random.default_rng(1)
    rows, parts, squares = 50, 16, []
    columns = rng.standard_normal((parts, rows, 2)) / np.sqrt(parts * rows)
    for at, own in enumerate(columns):
        error = own @ np.array([80.0 if at >= 12 else 0.0, 0.0]) + 0.1 * rng.standard_normal(rows)
        squares.append(Segment(float(at), 0, own.T @ own, own.T @ error, float(np.sum(error**2)), error.size))
    root = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    change = greatest_change(tuple(squares), np.array([80.0, 1.0, 5.0]), root)
    assert change is not None
    assert change.begins == 12.0
    assert change.inside == pytest.approx([160.0, 1.0, 5.0], abs=4.0)
    assert change.inside[2] == change.outside[2] == 5.0
    assert change.deviations[2] == 0.0
