"""Declarations: every fault at once, each with its cure; properties of a sound axis."""

import dataclasses
import math
import os
import subprocess
import sys

import pytest
from axes.catalogue import cases

import symid
from symid import (
    GROUND,
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Damper,
    Drive,
    Geared,
    OffsetForce,
    PendulumWeight,
    Position,
    Spring,
    Velocity,
    ViscousFriction,
    Weight,
    chain,
    load_axis,
)
from symid.errors import DeclarationError, SettingError, SymidError


def faults(*args: object, **kwargs: object) -> tuple[str, ...]:
    with pytest.raises(DeclarationError) as refused:
        Axis(*args, **kwargs)
    assert isinstance(refused.value, SymidError)
    assert "\n" not in str(refused.value)
    assert all(fault in str(refused.value) for fault in refused.value.faults)
    return refused.value.faults


def test_all_faults_are_reported_at_once() -> None:
    structure = Body("structure", mass="M1")
    motor = Body("motor", mass="M1", inertia="J", on=structure)
    loose = Body("loose", mass="M3")
    forgotten = Body("strutcure", mass="M4")
    turning = Body("turning", inertia="J5")
    found = faults(
        "many",
        (
            structure,
            motor,
            loose,
            turning,
            Spring("spring", Between(first=forgotten, second=motor), stiffness="q1"),
            Spring("spring", Between(first=structure, second=structure), stiffness="K_d1"),
            Damper("damper", Between(first=turning, second=structure), damping="F6"),
            Weight(structure, math.nan),
            Weight(turning),
            PendulumWeight(structure, "ml"),
        ),
        Drive("t", motor, gain=0.0, unit="lbf"),
        (Position("q1", motor), Position("q1", structure)),
    )
    expected = [
        "name 'K_d1' is not usable",
        "signal 'q1' is used more than once",
        "element name 'spring' is used more than once",
        "'q1' names a signal and a parameter",
        "name 't' is reserved",
        "body 'motor' needs either mass= (it slides) or inertia= (it turns)",
        "refers to body 'strutcure', which is not among the elements: add it, or did you mean 'structure'?",
        "Weight at 'structure': acceleration is nan: it must be a finite number other than 0",
        "drive 't': gain is 0.0: it must be a finite number other than 0",
        "drive 't': command and gain belong together",
        "drive 't': unit 'lbf' is not known",
        "Spring 'spring' lies between 'structure' and itself",
        "Damper 'damper' joins a turning and a sliding body: give the ratio",
        "Weight at 'turning': a weight acts on a sliding body",
        "PendulumWeight at 'structure': a pendulum weight acts on a turning body",
        "the drive cannot move body 'loose'",
    ]
    missing = [text for text in expected if not any(text in fault for fault in found)]
    assert missing == []


def test_faults_of_types_are_reported_together() -> None:
    motor = Body("motor", mass="M")
    found = faults(
        "2m1s",
        (motor, "spring", ViscousFriction("motor", "Fv"), Body("load", mass=(3.0,))),
        Drive("F", at=GROUND),
        ("q",),
    )
    expected = [
        "name '2m1s' is not an identifier",
        "'spring' is not an element",
        "at='motor' must be the Body or Between object itself",
        "mass=(3.0,) must be the name of a parameter, or its value",
        "'q' is not a sensor",
    ]
    missing = [text for text in expected if not any(text in fault for fault in found)]
    assert missing == []
    assert any("drive 'F': at=" in fault for fault in found)


@pytest.mark.parametrize(
    ("elements", "sensors", "fault"),
    [
        ([], (), "elements and sensors must be tuples"),
        ((), (), "there is no sensor"),
        ((), (Position("q", Body("motor", mass="M")),), "there is no body"),
    ],
)
def test_what_is_missing_is_reported(elements: object, sensors: object, fault: str) -> None:
    found = faults("empty", elements, Drive("F", Body("motor", mass="M")), sensors)
    assert any(fault in text for text in found)


def test_ends_of_a_between_must_be_bodies() -> None:
    motor = Body("motor", mass="M")
    spring = Spring("spring", Between(first="motor", second=motor), stiffness="K")
    assert any(
        "'motor' must be the Body object itself" in f
        for f in faults("a", (motor, spring), Drive("F", motor), (Position("q", motor),))
    )


def test_gears_are_checked() -> None:
    motor = Body("motor", inertia="J")
    by_name = Body("table", mass="M", geared="motor")
    found = faults("a", (motor, by_name), Drive("T", motor), (Position("q", motor),))
    assert any("must be Geared(to=BODY, ratio=NUMBER)" in fault for fault in found)
    unmoved = Body("table", mass="M", geared=Geared(to=motor, ratio=0))
    found = faults("a", (motor, unmoved), Drive("T", motor), (Position("q", motor),))
    assert any("ratio is 0" in fault for fault in found)


def test_a_sliding_body_on_a_turning_one_is_refused() -> None:
    screw = Body("screw", inertia="J")
    table = Body("table", mass="M", on=screw)
    found = faults(
        "a", (screw, table, ViscousFriction(table, "F")), Drive("T", screw), (Position("q", screw),)
    )
    assert any("'table' slides on 'screw', which turns" in fault for fault in found)


@pytest.mark.parametrize(
    "name", ["t", "reference", "np", "n_samples", "branch", "lambda", "q_d2", "2q", "", "a b", "ä"]
)
def test_names_that_no_signal_can_have_are_refused(name: str) -> None:
    motor = Body("motor", mass="M")
    found = faults("a", (motor,), Drive("F", motor), (Position(name, motor),))
    assert any(f"name {name!r} is" in fault for fault in found)


def test_a_parameter_cannot_take_the_name_of_a_minimal_parameter_but_a_sensor_can() -> None:
    motor = Body("motor", mass="X1")
    assert any(
        "'X1' is reserved" in f for f in faults("a", (motor,), Drive("F", motor), (Position("q", motor),))
    )
    motor = Body("motor", mass="M")
    assert Axis("a", (motor,), Drive("F", motor), (Position("X1", motor),)).sensors[0].signal == "X1"


def test_faults_come_in_the_same_order_in_every_process() -> None:
    program = (
        "from symid import Axis, Body, Drive, Position, ViscousFriction\n"
        "b = Body('b', mass='q_d1')\n"
        "parts = (b, ViscousFriction(b, 'w_d2'))\n"
        "try: Axis('a', parts, Drive('f_d1', b), (Position('q_d3', b), Position('r_d4', b)))\n"
        "except Exception as error: print(error)\n"
    )
    texts = set()
    for seed in ("0", "1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        texts.add(run.stdout)
    assert len(texts) == 1
    assert texts.pop().count("is not usable") == 5


@pytest.mark.parametrize("name", cases())
def test_parameters_are_listed_in_the_order_of_the_declaration(name: str) -> None:
    assert list(cases()[name].declared.physical_parameters) == list(cases()[name].values)


def test_units_follow_from_the_joint() -> None:
    units = {
        name: str(unit)
        for name, unit in cases()["geared_ballscrew_3m2s"].declared.physical_parameters.items()
    }
    assert units == {
        "Js": "kg*m^2",
        "Fvs": "N*m*s/rad",
        "Fsm": "N*m",
        "Kn": "N/m",
        "Fn": "N*s/m",
        "Mt": "kg",
        "Fvt": "N*s/m",
        "Kl": "N/m",
        "Ml": "kg",
    }
    bench = cases()["turning_bench"].declared
    assert {name: str(unit) for name, unit in bench.signal_units.items()} == {
        "i": "A",
        "dq1": "rad/s",
        "dq2": "rad/s",
    }
    assert str(bench.physical_parameters["J1"]) == "A*s^2/rad"


def test_every_subset_of_three_optional_sensors_and_no_more() -> None:
    body = Body("body", mass="M")
    sensors = (Position("q", body), Velocity("dq", body), Acceleration("a1", body), Acceleration("a2", body))
    axis = Axis("a", (body,), Drive("F", body), sensors)
    assert len(axis.sensor_sets) == 8
    assert all(chosen[0] == "q" for chosen in axis.sensor_sets)
    more = dataclasses.replace(axis, sensors=(*sensors, Acceleration("a3", body)))
    assert more.sensor_sets == (
        ("q",),
        ("q", "dq"),
        ("q", "a1"),
        ("q", "a2"),
        ("q", "a3"),
        ("q", "dq", "a1", "a2", "a3"),
    )


def test_sensors_are_measured_in_the_order_of_the_declaration() -> None:
    axis = load_axis("direct_2m1s")
    assert [sensor.signal for sensor in axis.measured(("ddq2", "q2"))] == ["q2", "ddq2"]
    assert [sensor.signal for sensor in axis.measured()] == ["q2"]
    for wrong in (("q7",), ()):
        with pytest.raises(SettingError, match="choose from q2, ddq1, ddq2"):
            axis.measured(wrong)


def test_an_effect_added_and_taken_away_leaves_the_axis_as_it_was() -> None:
    axis = load_axis("direct_2m1s")
    motor = axis.bodies[1]
    effect = OffsetForce(motor, "OF")
    longer = axis.with_effect(effect)
    assert list(longer.physical_parameters) == [*axis.physical_parameters, "OF"]
    assert longer.without(effect) == axis
    assert longer.signature != axis.signature
    assert longer.without(effect).signature == axis.signature


def test_an_axis_is_frozen_and_hashable() -> None:
    axis = load_axis("direct_2m1s")
    with pytest.raises(dataclasses.FrozenInstanceError):
        axis.name = "other"
    assert hash(axis) == hash(load_axis("direct_2m1s"))


def test_the_signature_sees_every_number_and_name() -> None:
    def signature(ratio: float = 0.5, mass: str = "M", held: bool = False) -> str:
        motor = Body("motor", inertia="J")
        table = Body("table", mass=mass, geared=Geared(to=motor, ratio=ratio))
        return Axis("a", (motor, table), Drive("T", motor, held=held), (Position("q", motor),)).signature

    assert len({signature(), signature(ratio=0.6), signature(mass="Mt"), signature(held=True)}) == 4
    assert signature() == signature()


def test_chains_have_the_declared_masses_and_springs() -> None:
    for masses in range(1, 6):
        for springs in (masses - 1, masses):
            for driven in range(1, masses + 1):
                axis = chain("a", masses, springs, driven=driven)
                assert len(axis.bodies) == masses
                assert sum(isinstance(element, Spring) for element in axis.elements) == springs
                assert sum(isinstance(element, CoulombFriction) for element in axis.elements) == 1
                assert axis.drive.at == axis.bodies[driven - 1]


def test_impossible_chains_report_all_that_is_wrong() -> None:
    with pytest.raises(DeclarationError) as refused:
        chain("a", 2, 5, driven=4, accelerometers=(0, 9))
    assert len(refused.value.faults) == 3
    with pytest.raises(DeclarationError, match="masses is 0"):
        chain("a", 0)


def test_the_package_imports_without_sympy_and_numpy() -> None:
    program = (
        "import sys, symid; print([m for m in ('sympy', 'numpy') if m in sys.modules], symid.__version__)"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == f"[] {symid.__version__}"
