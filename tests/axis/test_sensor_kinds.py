"""A kind of sensor is one class: whatever reads sensors follows from the derivative that it declares."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from axes.force_sensors import DRIVE, MOTOR, VALUES, celled

from symid import (
    GROUND,
    Drive,
    Force,
    MotionSensor,
    Position,
    Sensor,
    Spring,
    Velocity,
    axis_source,
    derive,
    load_axis,
)
from symid.axis import Joint
from symid.axis.sensors import ReadingPart
from symid.errors import DeclarationError, SettingError
from symid.export import c_source, mjcf
from symid.report.figures.schematic import schematic_svg
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

VALUES_2M1S = {"Ms": 100.0, "Fvs": 50.0, "Ks": 1e6, "Mm": 20.0, "Fvm": 30.0, "Fsm": 10.0}


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
    assert mjcf(new, VALUES_2M1S).text == mjcf(known, VALUES_2M1S).text
    assert 'id="sensor v"' in schematic_svg(new)
    reference = trapezoids([0.02], [0.2], acceleration=4.0, jerk=400.0, dwell=0.05, sampling_period=1e-3)
    controller = tuned_cascade(plant_of(new, VALUES_2M1S), "q2")
    first, second = (simulate(one, VALUES_2M1S, reference, controller).log for one in (new, known))
    assert np.ptp(first["v"]) > 0
    np.testing.assert_array_equal(first["v"], second["v"])


@dataclass(frozen=True)
class Tension(Sensor):
    """What a belt carries, which is no quantity of symid's own sensors."""

    of: Spring
    quantity: ClassVar = "tension"

    @property
    def joint(self) -> Joint:
        return self.of.at

    @property
    def element(self) -> Spring:
        return self.of

    @property
    def parts(self) -> tuple[ReadingPart, ...]:
        return Force(self.signal, self.of).parts


def test_a_kind_of_another_quantity_is_one_class() -> None:
    known = celled()
    cell = next(sensor for sensor in known.sensors if isinstance(sensor, Force))
    assert isinstance(cell.of, Spring)
    new = replace(
        known,
        sensors=tuple(
            Tension(s.signal, cell.of, noise=cell.noise) if s is cell else s for s in known.sensors
        ),
    )
    assert str(new.signal_units["cell"]) == "N"
    assert str(derive(new, ("qm", "cell"))) == str(derive(known, ("qm", "cell")))
    assert 'id="sensor cell"' in schematic_svg(new)
    assert mjcf(new, VALUES).text == mjcf(known, VALUES).text
    other = Spring("other", MOTOR, stiffness="K2")
    with pytest.raises(
        DeclarationError, match="sensor 't' reads Spring 'other', which is not part of the axis"
    ):
        celled((Position("qm", MOTOR), Tension("t", other)))


def test_an_axis_file_cannot_be_written_with_a_kind_that_symid_does_not_have() -> None:
    axis = load_axis("rigid_1m")
    foreign = replace(axis, sensors=(*axis.sensors, Gyroscope("v", axis.bodies[0])))
    with pytest.raises(SettingError, match="Gyroscope of axis 'rigid_1m' is not a class of symid"):
        axis_source(foreign)


def test_force_sensors_are_declared_of_elements_of_their_axis() -> None:
    axis = celled()
    text = axis_source(axis)
    assert 'shaft = Spring("shaft"' in text
    assert 'Force("cell", shaft, noise=0.05)' in text
    names: dict[str, object] = {}
    exec(text, names)
    assert names["axis"] == axis
    assert 'id="sensor cell"' in schematic_svg(axis)
    assert (str(axis.signal_units["cell"]), axis.sensors[2].quantity) == ("N", "force")
    other = Spring("other", MOTOR, stiffness="K2")
    with pytest.raises(
        DeclarationError, match="sensor 'f' reads Spring 'other', which is not part of the axis"
    ):
        celled((Position("qm", MOTOR), Force("f", other)))
    current = Drive("iq", MOTOR, unit="A")
    with pytest.raises(DeclarationError, match="a drive is in another unit"):
        celled((Position("qm", MOTOR), Force("f", current)), current)
    with pytest.raises(DeclarationError, match="must be the Spring or Drive object itself"):
        celled((Position("qm", MOTOR), Force("f", "shaft")))  # type: ignore[arg-type]


def test_faults_of_a_scale() -> None:
    with pytest.raises(DeclarationError, match="unit 'V' needs a gain"):
        celled((Position("qm", MOTOR, unit="V"),))
    with pytest.raises(DeclarationError, match="the gain of a sensor must be positive"):
        celled((Position("qm", MOTOR, gain=0.0),))
    with pytest.raises(DeclarationError, match="must be a finite number of at least 0"):
        celled((Position("qm", MOTOR, gain=-1.0),))
    assert celled((Position("qm", MOTOR, gain="c", offset=-0.5),)).known_parameters == {"qm_offset": -0.5}


def test_export_of_force_sensors() -> None:
    transducer = celled((Position("qm", MOTOR), Force("fd", DRIVE)))
    exported = mjcf(celled(), VALUES)
    assert any("cell: MuJoCo has no sensor of the force in a spring" in loss for loss in exported.losses)
    assert '<actuatorfrc name="fd" actuator="F"' in mjcf(transducer, VALUES).text
    with pytest.raises(SettingError, match="fd reads the force of a drive"):
        c_source(transducer, VALUES)
