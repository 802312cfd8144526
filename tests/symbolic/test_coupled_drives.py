"""Bodies that several others move: a rigid beam on two carriages, and two motors with crossed belts, by hand."""

import numpy as np
import pytest

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Spring,
    ViscousFriction,
    derive,
)
from symid.codegen.generated_models import compiled
from symid.errors import DeclarationError
from symid.report.figures.schematic import draw_schematic
from symid.simulation import plant_of

SPAN, RADIUS = 1.2, 0.01


def gantry() -> tuple[Axis, dict[str, float]]:
    """Equal carriages under a rigid beam that turns against a stiffness of its guides."""
    left, right = Body("left", mass="M"), Body("right", mass="M")
    beam = Body("beam", mass="Mb", geared=(Geared(to=left, ratio=0.5), Geared(to=right, ratio=0.5)))
    yaw = Body(
        "yaw", inertia="J", geared=(Geared(to=left, ratio=-1 / SPAN), Geared(to=right, ratio=1 / SPAN))
    )
    rails = [law(body, name + body.name[0]) for body in (left, right) for law, name in LAWS]
    flexure = Spring("flexure", yaw, stiffness="Ky", damping="Cy")
    sensors = (Position("q1", left), Position("q2", right))
    axis = Axis(
        "gantry", (left, right, beam, yaw, *rails, flexure), (Drive("F1", left), Drive("F2", right)), sensors
    )
    values = {"M": 30.0, "Mb": 80.0, "J": 12.0, "Ky": 4e4, "Cy": 60.0}
    return axis, values | {"Fvl": 90.0, "Fsl": 11.0, "Fvr": 120.0, "Fsr": 14.0}


LAWS = ((ViscousFriction, "Fv"), (CoulombFriction, "Fs"))


def by_hand(p: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C and K of the gantry in its two carriages."""
    mean, turn = np.full((2, 2), 0.25), np.array([[1.0, -1.0], [-1.0, 1.0]]) / SPAN**2
    mass = p["M"] * np.eye(2) + p["Mb"] * mean + p["J"] * turn
    return mass, np.diag([p["Fvl"], p["Fvr"]]) + p["Cy"] * turn, p["Ky"] * turn


def test_the_gantry_with_a_rigid_beam_is_that_by_hand() -> None:
    axis, values = gantry()
    matrices = by_hand(values)
    plant = plant_of(axis, values)
    for found, expected in zip((plant.mass, plant.damping, plant.stiffness), matrices, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-9)
    q, v, a = np.random.default_rng(2).normal(size=(3, 2, 50))
    M, C, K = matrices
    F = M @ a + C @ v + K @ q + np.array([[values["Fsl"]], [values["Fsr"]]]) * np.sign(v)
    model = compiled(derive(axis))
    signals = {"F1": F[0], "F2": F[1]}
    signals |= {f"q{i + 1}{end}": x[i] for end, x in (("", q), ("_d1", v), ("_d2", a)) for i in (0, 1)}
    W, y = model.sample(signals)
    np.testing.assert_allclose(
        W @ model.minimal_parameters(*(values[n] for n in axis.physical_parameters)), y
    )
    # m11 = m22 and m12 are two numbers for M, Mb and J: the carriages must be weighed
    free = derive(axis).parameter_map.identifiability
    assert {name for name, kind in free.items() if kind == "none"} == {"M", "Mb", "J"}
    weighed = derive(axis.with_known({"M": 30.0})).parameter_map.identifiability
    assert set(weighed.values()) == {"unique"}


def test_two_motors_with_crossed_belts_move_two_slides() -> None:
    a, b = Body("a", inertia=2e-5), Body("b", inertia=2e-5)
    half = RADIUS / 2
    x = Body("x", mass="Mx", geared=(Geared(to=a, ratio=half), Geared(to=b, ratio=half)))
    y = Body("y", mass="My", geared=(Geared(to=a, ratio=half), Geared(to=b, ratio=-half)))
    axis = Axis(
        "crossed",
        (a, b, x, y, ViscousFriction(x, "Fx"), CoulombFriction(y, "Fy")),
        (Drive("Ta", a), Drive("Tb", b)),
        (Position("qa", a), Position("qb", b)),
    )
    draw = np.random.default_rng(4).normal(size=(4, 30))
    va, vb, wa, wb = draw
    force_x = 0.7 * half * (wa + wb) + 3.0 * half * (va + vb)  # Mx, Fx
    force_y = 0.4 * half * (wa - wb) + 2.0 * np.sign(va - vb)  # My, Fy
    torques = {"Ta": 2e-5 * wa + half * (force_x + force_y), "Tb": 2e-5 * wb + half * (force_x - force_y)}
    model = compiled(derive(axis))
    signals = torques | {"qa_d1": va, "qb_d1": vb, "qa_d2": wa, "qb_d2": wb, "qa": va, "qb": vb}
    W, output = model.sample({name: signals[name] for name in model.signals})
    true = {"Mx": 0.7, "My": 0.4, "Fx": 3.0, "Fy": 2.0}
    X = model.minimal_parameters(*(true[name] for name in axis.physical_parameters))
    np.testing.assert_allclose(W @ X, output, atol=1e-15)
    solved, *_ = np.linalg.lstsq(W.reshape(-1, X.size), output.ravel(), rcond=None)
    assert model.physical_parameters(*solved) == pytest.approx([true[n] for n in axis.physical_parameters])


def test_faults_of_several_gears_are_reported() -> None:
    motor = Body("motor", mass="M")
    for geared, words in (
        ((), "must be Geared"),
        ((Geared(to=motor, ratio=1.0), motor), "must be Geared"),
        ((Geared(to=motor, ratio=1.0), Geared(to=motor, ratio=2.0)), "more than once: add up the ratios"),
        ((Geared(to=motor, ratio=0.0),), "other than 0"),
    ):
        beam = Body("beam", mass="Mb", geared=geared)
        with pytest.raises(DeclarationError, match=words):
            Axis("faulty", (motor, beam), Drive("F", motor), (Position("q", motor),))


def test_each_gear_is_drawn() -> None:
    axis, _ = gantry()
    names = {line.get_gid() for line in draw_schematic(axis).axes[0].get_children()} - {None}
    assert {"drive F1", "drive F2"} <= {name for name in names if name.startswith("drive")}
    assert {f"gear of {body} to {to}" for body in ("beam", "yaw") for to in ("left", "right")} <= names


RACK = {"J1": 4e-3, "F1": 0.05, "J2": 6e-3, "F2": 0.08, "M": 300.0, "Fv": 900.0}
RACK |= {"K1": 3e7, "C1": 4e3, "K2": 5e7, "C2": 6e3}


def tandem_rack() -> Axis:
    """Two motors whose pinions move one table, each through a spring."""
    one, two, table = Body("one", inertia="J1"), Body("two", inertia="J2"), Body("table", mass="M")
    meshes = [
        Spring(f"mesh{i}", Between(first=pinion, second=table, ratio=0.023), f"K{i}", f"C{i}")
        for i, pinion in ((1, one), (2, two))
    ]
    rails = (ViscousFriction(one, "F1"), two, ViscousFriction(two, "F2"), table, ViscousFriction(table, "Fv"))
    sensors = (Position("q1", one), Position("q2", two), Position("x", table))
    return Axis("tandem", (one, *rails, *meshes), (Drive("T1", one), Drive("T2", two)), sensors)


@pytest.mark.parametrize("measured", [("q1", "q2"), ("q1", "x"), ("q1",), ("q1", "q2", "x")], ids="_".join)
def test_a_tandem_rack_is_that_by_hand_from_any_encoders(measured: tuple[str, ...]) -> None:
    r, p = 0.023, RACK
    s = 2j * np.pi * np.array([2.0, 11.0, 47.0, 90.0])
    torques = np.random.default_rng(6).normal(size=(2, 4))
    mesh = [p[f"K{i}"] + p[f"C{i}"] * s for i in (1, 2)]
    zero = np.zeros_like(s)
    dynamic = np.array(
        [
            [p["J1"] * s**2 + p["F1"] * s + r**2 * mesh[0], zero, -r * mesh[0]],
            [zero, p["J2"] * s**2 + p["F2"] * s + r**2 * mesh[1], -r * mesh[1]],
            [-r * mesh[0], -r * mesh[1], p["M"] * s**2 + p["Fv"] * s + mesh[0] + mesh[1]],
        ]
    )
    loads = np.stack([*torques, zero])
    motion = np.linalg.solve(np.moveaxis(dynamic, 2, 0), loads.T[..., None])[..., 0].T
    waves = np.exp(np.outer(s, np.linspace(0.0, 0.5, 60)))
    amplitudes = dict(zip(("T1", "T2", "q1", "q2", "x"), (*torques, *motion), strict=True))
    model = compiled(derive(tandem_rack(), measured))
    signals = {}
    for name in model.signals:
        signal, order = (*name.rsplit("_d", 1), "0")[:2]
        signals[name] = np.real((amplitudes[signal] * s ** int(order)) @ waves)
    W, y = model.sample(signals)
    X = model.minimal_parameters(*(p[name] for name in model.physical_units))
    for row, predicted, output in zip(W, W @ X, y, strict=True):
        np.testing.assert_allclose(predicted, output, atol=1e-8 * np.abs(row * X).max())
    assert len(y) == len(measured)
