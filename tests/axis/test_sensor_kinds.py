"""A kind of sensor is one class: whatever reads sensors follows from the derivative that it declares."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from symid import GROUND, MotionSensor, Velocity, axis_source, derive, load_axis
from symid.errors import SettingError
from symid.export import mjcf
from symid.report.figures.schematic import schematic_svg
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

VALUES = {"Ms": 100.0, "Fvs": 50.0, "Ks": 1e6, "Mm": 20.0, "Fvm": 30.0, "Fsm": 10.0}


@dataclass(frozen=True)
class Gyroscope(MotionSensor):
    """A rate sensor."""

    derivative: ClassVar = 1


def test_a_new_kind_is_derived_simulated_exported_and_drawn_as_the_kind_of_its_derivative() -> None:
    axis = load_axis("direct_2m1s")
    structure = axis.bodies[0]
    new, known = (
        replace(axis, sensors=(*axis.sensors[:1], kind("v", structure, relative_to=GROUND)))
        for kind in (Gyroscope, Velocity)
    )
    assert str(new.signal_units["v"]) == "m/s"
    assert str(derive(new, ("q2", "v"))) == str(derive(known, ("q2", "v")))
    assert mjcf(new, VALUES).text == mjcf(known, VALUES).text
    assert 'id="sensor v"' in schematic_svg(new)
    reference = trapezoids([0.02], [0.2], acceleration=4.0, jerk=400.0, dwell=0.05, sampling_period=1e-3)
    controller = tuned_cascade(plant_of(new, VALUES), "q2")
    first, second = (simulate(one, VALUES, reference, controller).log for one in (new, known))
    assert np.ptp(first["v"]) > 0
    np.testing.assert_array_equal(first["v"], second["v"])


def test_an_axis_file_cannot_be_written_with_a_kind_that_symid_does_not_have() -> None:
    axis = load_axis("rigid_1m")
    foreign = replace(axis, sensors=(*axis.sensors, Gyroscope("v", axis.bodies[0])))
    with pytest.raises(SettingError, match="Gyroscope of axis 'rigid_1m' is not one of symid's"):
        axis_source(foreign)
