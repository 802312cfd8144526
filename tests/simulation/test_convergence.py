"""Laws of a user in a simulation, and the parts of a step against other solvers."""

import numpy as np
import pytest
from driven import driven
from scipy.linalg import expm

from symid import Axis, Between, Body, Drive, Law, Position, Spring, Term, ViscousFriction, load_axis
from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation import OpenLoop, Trajectory, plant_of, simulate
from symid.simulation.compiled_loop.products import recursion
from symid.simulation.loops.mode import Flow

PERIOD = 1 / 4000


FLEXIBLE = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 80.0}
FLEXIBLE |= {"Kl": 1e6, "Fl": 200.0, "Ml": 40.0}


class Cube(Law):
    """A spring that pushes away with the cube of the displacement."""

    def terms(self) -> tuple[Term, ...]:
        return (Term("k3", "q**3", signed=True),)


SLIDE = Body("slide", mass="M")


@pytest.mark.parametrize(
    ("law", "values"),
    [(Cube(SLIDE), {"M": 1.0, "k3": -1e9}), (ViscousFriction(SLIDE, "Fv"), {"M": 1.0, "Fv": -1e4})],
    ids=["law", "linear"],
)
def test_an_axis_that_runs_away_without_a_controller_is_named(law: Law, values: dict[str, float]) -> None:
    axis = Axis("away", (SLIDE, law), Drive("F", SLIDE), (Position("q", SLIDE),))
    with pytest.raises(SettingError, match=r"runs away at t = 0\.0"):
        driven(axis, values, np.full(400, 10.0), PERIOD)


class Stribeck(Law):
    """Friction that falls from Fs + dF at rest to Fs within 2 mm/s."""

    def terms(self) -> tuple[Term, ...]:
        return (Term("Fs", "sign(v)"), Term("dF", "sign(v)*exp(-(v/0.002)**2)"))


def test_a_falling_friction_converges_with_the_second_order() -> None:
    body = Body("slide", mass="M")
    elements = (body, ViscousFriction(body, "Fv"), Stribeck(body))
    axis = Axis("stribeck", elements, Drive("F", body), (Position("q", body),))
    values = {"M": 100.0, "Fv": 80.0, "Fs": 40.0, "dF": 60.0}
    rough = Trajectory(*(np.zeros(400) for _ in range(3)), PERIOD, "rest")
    force = OpenLoop(np.full(400, 110.0))
    runs = [simulate(axis, values, rough, force, steps=n).states[-1] for n in (1, 2, 4, 64)]
    errors = [np.abs(run - runs[-1]).max() for run in runs[:-1]]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.2)
    state, step = np.zeros(2), PERIOD / 400

    def change(z: FloatArray) -> FloatArray:
        friction = 40.0 + 60.0 * np.exp(-((z[1] / 0.002) ** 2))
        return np.array([z[1], (110.0 - 80.0 * z[1] - friction) / 100.0])

    for _ in range(399 * 400):
        state = state + step * change(state + step / 2 * change(state))
    assert runs[-1] == pytest.approx(state, rel=1e-6)


@pytest.mark.parametrize("size", [1, 4, 7])
@pytest.mark.parametrize("n", [0, 1, 200])
def test_a_recursion_is_what_it_says(size: int, n: int) -> None:
    random = np.random.default_rng(size)
    matrix = 0.98 * np.linalg.qr(random.standard_normal((size, size)))[0]
    start, inputs = random.standard_normal(size), random.standard_normal((n, size))
    states = [start]
    for row in inputs:
        states.append(matrix @ states[-1] + row)
    assert recursion(matrix, start, inputs) == pytest.approx(np.array(states), abs=1e-12)


@pytest.mark.parametrize("duration", [1e-7, 1e-4, 0.01, 1.0])
def test_the_flow_is_the_matrix_exponential(duration: float) -> None:
    plant = plant_of(load_axis("direct_3m2s"), FLEXIBLE)
    n = len(plant.bodies)
    inverse = np.linalg.inv(plant.mass)
    generator = np.zeros((3 * n, 3 * n))
    generator[:n, n : 2 * n] = np.eye(n)
    generator[n : 2 * n] = np.hstack([-inverse @ plant.stiffness, -inverse @ plant.damping, inverse])
    exact = expm(generator * duration)
    transition, gain = Flow(plant, ()).transition(duration)
    found = np.hstack([transition, gain])
    for rows in (slice(0, n), slice(n, 2 * n)):
        for columns in (slice(0, n), slice(n, 2 * n), slice(2 * n, 3 * n)):
            true = exact[rows, columns]
            assert np.abs(found[rows, columns] - true).max() < 2e-12 * np.abs(true).max()


@pytest.mark.parametrize("damping", [1e3, 1e10, 1e13, 1e300])
def test_motion_too_fast_for_numbers_is_refused_and_slower_motion_is_right(damping: float) -> None:
    """Two bodies on a damper move as one, exp(-F t/m) by hand; beyond 1e11 N*s/m a simulation did not end."""
    a, b = Body("a", mass="A"), Body("b", mass="B")
    shaft = Spring("shaft", Between(first=a, second=b), stiffness="K", damping="D")
    axis = Axis("tied", (a, b, ViscousFriction(a, "F"), shaft), Drive("T", a), (Position("q", a),))
    flow = Flow(plant_of(axis, {"A": 1.0, "B": 1e-3, "F": 1.0, "K": 1e3, "D": damping}), ())
    if damping > 1e11:
        with pytest.raises(SettingError, match=r"too fast to be simulated over steps of 1\.0e-02 s"):
            flow.transition(0.01)
    else:
        of_state, _ = flow.transition(0.01)
        assert (of_state @ [0.0, 0.0, 1.0, 1.0])[2] == pytest.approx(np.exp(-0.01 / 1.001), rel=1e-4)
