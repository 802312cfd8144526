"""A payload that changes on a body of known mass: beside the motion under a constant force, by hand."""

import numpy as np
import pytest

from symid import Axis, Body, Drive, PayloadChange, Position, ViscousFriction
from symid.simulation import OpenLoop, simulate, trapezoids


@pytest.mark.parametrize(("mass", "known"), [("M", {}), ("M", {"M": 2.0}), (2.0, {})])
def test_the_mass_changes_whether_it_is_known_or_not(mass: str | float, known: dict[str, float]) -> None:
    table = Body("table", mass=mass)
    elements = (table, ViscousFriction(table, "Fv"), PayloadChange(table, 3.0, time=0.5))
    axis = Axis("loaded", elements, Drive("F", table, held=True), (Position("q", table),), known=known)
    path = trapezoids([0.1], 0.5, acceleration=1.0, jerk=50.0, dwell=0.2, sampling_period=1e-3)
    values = {"Fv": 0.0, "M": 2.0} if mass == "M" and not known else {"Fv": 0.0}
    log = simulate(axis, values, path, OpenLoop(np.full(path.n_samples, 10.0))).log
    assert log["q"][1000] == pytest.approx(0.625 + 2.5 * 0.5 + 0.25, rel=1e-9)
