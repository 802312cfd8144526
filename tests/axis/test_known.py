"""Parameters that are known, and parameters that several elements share."""

import math

import pytest

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    OffsetForce,
    Position,
    QuadraticDrag,
    Spring,
    ViscousFriction,
    load_axis,
)
from symid.axis import write_axis
from symid.errors import DeclarationError, SettingError


def axis_of(*elements: object, known: dict[str, float] | None = None, body: Body | None = None) -> Axis:
    body = body or Body("table", mass="M")
    return Axis("a", (body, *elements), Drive("F", body), (Position("q", body),), known or {})


def faults_of(*elements: object, known: object = None, body: Body | None = None) -> str:
    with pytest.raises(DeclarationError) as refused:
        axis_of(*elements, known=known, body=body)
    return str(refused.value)


def test_numbers_are_known_parameters_named_after_element_and_field() -> None:
    motor = Body("motor", inertia=2e-4)
    load = Body("load", mass="M")
    screw = Between(first=motor, second=load, ratio=0.01)
    axis = Axis(
        "screw",
        (motor, ViscousFriction(motor, 0.5), load, Spring("nut", screw, stiffness=1e8, damping="Ft")),
        Drive("T", motor),
        (Position("q", motor),),
    )
    assert list(axis.physical_parameters) == ["M", "Ft"]
    assert axis.known_parameters == {"motor_inertia": 2e-4, "motor_coefficient": 0.5, "nut_stiffness": 1e8}
    assert list(axis.parameter_units) == ["motor_inertia", "motor_coefficient", "M", "nut_stiffness", "Ft"]


def test_known_values_change_the_signature_and_survive_a_file(tmp_path) -> None:
    axis = load_axis("emps")
    known = axis.with_known({"M": 95.0, "OF": -3.0})
    assert known.signature != axis.signature
    assert known.with_known({}).signature == known.signature
    written = write_axis(known, tmp_path / "emps_known.py")
    assert load_axis(str(tmp_path / "emps_known.py")) == written
    assert written.known_parameters == {"M": 95.0, "OF": -3.0}


def test_shared_parameters_must_be_one_quantity() -> None:
    body = Body("table", mass="M")
    fault = faults_of(QuadraticDrag(body, "M"), body=body)
    assert "parameter 'M' is in kg and in kg/m" in fault or "'M' is in kg and in N*s^2/m^2" in fault


@pytest.mark.parametrize(
    ("known", "fault"),
    [
        ({"M": -1.0}, "the known value of 'M' is -1.0: it must be a finite number of at least 0"),
        ({"M": math.nan}, "it must be a finite number of at least 0"),
        ({"M": "heavy"}, "'heavy'"),
        ({"Mx": 1.0}, "there is no parameter 'Mx': choose from Fs, M, OF"),
        ({"M": 1.0, "Fs": 1.0, "OF": -1.0}, "every parameter is known"),
        ([("M", 1.0)], "must be a mapping"),
    ],
)
def test_impossible_values_are_refused(known: object, fault: str) -> None:
    body = Body("table", mass="M")
    assert fault in faults_of(CoulombFriction(body, "Fs"), OffsetForce(body, "OF"), known=known, body=body)


def test_a_number_must_be_possible_too() -> None:
    body = Body("table", mass=-2.0)
    assert "'table_mass' is -2.0" in faults_of(ViscousFriction(body, "Fv"), body=body)
    body = Body("table", mass="M")
    assert "has several values" in faults_of(
        ViscousFriction(body, 1.0), ViscousFriction(body, 2.0), body=body
    )


def test_fixing_what_is_not_there_is_refused() -> None:
    with pytest.raises(SettingError, match="there is no parameter 'Q'"):
        load_axis("emps").with_known({"Q": 1.0})
    with pytest.raises(SettingError, match="at least 0"):
        load_axis("emps").with_known({"M": -1.0})


def test_faults_of_values_stand_beside_all_others() -> None:
    table = Body("table", mass=-1.0)
    with pytest.raises(DeclarationError) as raised:
        Axis("a", (table, ViscousFriction(table, "Fv")), Drive("F", table), (Position("F", table),))
    assert "'table_mass' is -1.0" in str(raised.value)
    assert "signal 'F' is used more than once" in str(raised.value)
