"""Output error and instruments with two drives, on logs of hand-written matrices and controllers."""

from functools import cache

import numpy as np
import pytest
from axes.gantry import AXIS as GANTRY, NOISE as GANTRY_NOISE, TRUE as GANTRY_TRUE, log as gantry_log
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from symid import Axis, Between, Body, Drive, Log, Position, Preparation, Spring, ViscousFriction
from symid.codegen import model_of
from symid.errors import SettingError
from symid.instrumental import identify_by_instruments
from symid.output_error import identify_output_error
from symid.output_error.sampled_plant import sampled_plant
from symid.simulation import Cascade, ClosedLoop, Trajectory, plant_of

LEFT, RIGHT = Body("left", mass="M1"), Body("right", mass="M2")
PAIR = Axis(
    "pair",
    (
        LEFT,
        ViscousFriction(LEFT, "Fv1"),
        RIGHT,
        ViscousFriction(RIGHT, "Fv2"),
        Spring("belt", Between(first=LEFT, second=RIGHT), stiffness="K", damping="C"),
    ),
    (Drive("F1", LEFT, held=True), Drive("F2", RIGHT, held=True)),
    (Position("q1", LEFT), Position("q2", RIGHT)),
)
TRUE = {"M1": 30.0, "Fv1": 150.0, "M2": 50.0, "Fv2": 260.0, "K": 1e6, "C": 600.0}
PERIOD, N = 1 / 500, 1500
FORCE_NOISE, READING_NOISE = (2.0, 4.0), (3e-7, 2e-7)
GAINS = (Cascade("q1", 15.0, 2500.0, 8.0), Cascade("q2", 20.0, 3500.0, 5.0))


def generator() -> tuple[np.ndarray, np.ndarray]:
    """Continuous matrices in displacements and velocities of left and right, and effects of both forces."""
    p = TRUE
    M = np.diag([p["M1"], p["M2"]])
    K = p["K"] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    C = p["C"] * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([p["Fv1"], p["Fv2"]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    return A, np.vstack([np.zeros((2, 2)), np.linalg.inv(M)])


@cache
def paths() -> tuple[Trajectory, Trajectory]:
    """A common stroke and a little against each other."""
    t = np.arange(N) * PERIOD
    lines = 2 * np.pi * np.array([[0.7, 1.9, 4.3, 9.0, 17.0], [0.7, 2.3, 5.1, 11.0, 23.0]])
    sizes = np.array([[0.05, 0.02, 4e-3, 9e-4, 3e-4], [0.05, 0.015, 3e-3, 7e-4, 2e-4]])
    waves = [size[:, None] * (1 - np.cos(w[:, None] * t)) for w, size in zip(lines, sizes, strict=True)]
    speeds = [(size * w)[:, None] * np.sin(w[:, None] * t) for w, size in zip(lines, sizes, strict=True)]
    rates = [(size * w**2)[:, None] * np.cos(w[:, None] * t) for w, size in zip(lines, sizes, strict=True)]
    parts = zip(waves, speeds, rates, strict=True)
    first, second = (Trajectory(*(x.sum(axis=0) for x in one), PERIOD, "by hand") for one in parts)
    return first, second


@cache
def closed_loop_log() -> Log:
    """A log of both cascades, their forces held; noise of the encoders goes round the loop."""
    A, B = generator()
    whole = expm(np.block([[A, B], [np.zeros((2, 6))]]) * PERIOD)
    rng = np.random.default_rng(7)
    x, last, sums, rows = np.zeros(4), np.zeros(2), np.zeros(2), []
    for k in range(N):
        read = x[:2] + READING_NOISE * rng.standard_normal(2)
        forces = np.zeros(2)
        for i, (gains, path) in enumerate(zip(GAINS, paths(), strict=True)):
            speed = (read[i] - last[i]) / PERIOD if k else 0.0
            error = path.velocity[k] + gains.position_gain * (path.position[k] - read[i]) - speed
            sums[i] += gains.integral_gain * PERIOD * error
            forces[i] = gains.velocity_gain * (error + sums[i])
        rows.append([*read, *(forces + FORCE_NOISE * rng.standard_normal(2))])
        last = read
        x = whole[:4, :4] @ x + whole[:4, 4:] @ forces
    signals = dict(zip(("q1", "q2", "F1", "F2"), np.transpose(rows), strict=True))
    first, second = paths()
    return Log(
        "by hand", 0.0, PERIOD, {**signals, "reference": first.position, "reference_F2": second.position}
    )


def test_one_interval_under_two_forces_is_that_of_an_integration() -> None:
    A, B = generator()
    found = sampled_plant(plant_of(PAIR, TRUE), ["q1", "q2"], PERIOD, parts=3)
    forces = np.random.default_rng(1).normal(size=(3, 2)) * 100
    start = x = np.array([1e-3, -2e-3, 0.1, 0.05])
    for part in forces:
        run = solve_ivp(lambda _, x, f=part: A @ x + B @ f, (0.0, PERIOD / 3), x, rtol=1e-12, atol=1e-15)
        x = run.y[:, -1]
    reached = found.transition @ start + np.einsum("inm,im->n", found.effects[:, :, :2], forces)
    np.testing.assert_allclose(reached, x, rtol=1e-9, atol=1e-13)


def test_innovations_determine_the_axis_and_the_noise_of_each_force() -> None:
    log, near = closed_loop_log(), {name: 1.15 * value for name, value in TRUE.items()}
    found = identify_output_error(PAIR, ("q1", "q2"), log, nominal=near)
    assert found.status == "ok", found.message
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < 5 * deviation, name
        assert deviation < 0.1 * TRUE[name], name
    expected = dict(zip(("F1", "F2", "q1", "q2"), (*FORCE_NOISE, *READING_NOISE), strict=True))
    assert found.noise == pytest.approx(expected, rel=0.2)
    assert "F1 and F2 are held from each sample to the next" in found.notes
    validation = found.predict(log)
    assert validation.innovations.std(axis=0) == pytest.approx(found.predictions[0].innovations.std(axis=0))


def test_a_gantry_with_friction_is_found_in_a_log_of_smooth_forces() -> None:
    near = {name: 1.15 * value for name, value in GANTRY_TRUE.items()}
    found = identify_output_error(
        GANTRY, ("q1", "q2"), gantry_log(1.0), preparation=Preparation(held=False), nominal=near
    )
    assert found.status == "ok", found.message
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - GANTRY_TRUE[name]) < max(5 * deviation, 1e-3 * GANTRY_TRUE[name]), name
        assert deviation < 0.01 * GANTRY_TRUE[name], name
    assert found.noise["F1"] == pytest.approx(GANTRY_NOISE["F1"], rel=0.2)


def test_the_simulated_loop_of_two_controllers_determines_the_axis() -> None:
    near = {name: 1.15 * value for name, value in TRUE.items()}
    loop = ClosedLoop(PAIR, GAINS, 500.0, paths())
    found = identify_output_error(PAIR, ("q1", "q2"), closed_loop_log(), loop=loop, nominal=near)
    assert found.status == "ok", found.message
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < 5 * deviation, name
        assert deviation < 0.1 * TRUE[name], name
    assert list(found.noise) == ["q1", "q2", "F1", "F2"]


@pytest.mark.parametrize("controller", [GAINS, None], ids=["given", "read"])
def test_instruments_of_two_controllers_determine_the_axis(controller: tuple[Cascade, ...] | None) -> None:
    model, log = model_of(PAIR, ("q1", "q2")), closed_loop_log()
    found = identify_by_instruments(
        model, log, ClosedLoop(PAIR, controller, 500.0), preparation=Preparation(held=True)
    )
    assert found.status == "ok", found.message
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < 5 * deviation, name
    printed = "the given controller" if controller else "a cascade read from the log"
    assert any(printed in note for note in found.notes)


def test_what_the_methods_need_of_two_drives_is_reported() -> None:
    log = closed_loop_log()
    with pytest.raises(SettingError, match=r"late by different times \(F1 0.001 s, F2 0 s\)"):
        identify_output_error(PAIR, ("q1", "q2"), log, preparation=Preparation(late={"F1": 1e-3}))
    alone = Log("by hand", 0.0, PERIOD, {name: log[name] for name in ("q1", "q2", "F1", "F2")})
    with pytest.raises(SettingError, match="has no column reference"):
        identify_by_instruments(model_of(PAIR, ("q1", "q2")), alone, ClosedLoop(PAIR, GAINS, 500.0))
