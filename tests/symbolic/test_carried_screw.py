"""A screw on a column that bends: the nut moves along the screw, and its thrust acts on the column."""

import numpy as np
import pytest

from symid import Axis, Between, Body, Drive, Position, Spring, derive
from symid.codegen.generated_models import compiled
from symid.simulation import plant_of
from symid.simulation.plants.plant import direction_of

RATIO = 0.05
COLUMN = Body("column", mass="Mc")
SCREW, TABLE = Body("screw", inertia="J", on=COLUMN), Body("table", mass="M", on=COLUMN)
TRUE = {"Mc": 40.0, "Kc": 9e4, "Dc": 60.0, "J": 0.02, "M": 12.0, "K": 5e4}


def axis_of(nut: Between) -> Axis:
    springs = (Spring("base", COLUMN, stiffness="Kc", damping="Dc"), Spring("nut", nut, stiffness="K"))
    sensors = (Position("q", SCREW), Position("p", TABLE), Position("x", COLUMN))
    return Axis("carried", (COLUMN, SCREW, TABLE, *springs), Drive("T", SCREW), sensors)


def displacements(s: complex) -> np.ndarray:
    """Angle of the screw, table on the column and column for a torque of 1, by the balances written by hand."""
    v = TRUE
    # thrust on the table K (r q - p), the opposite on the column
    screw = [v["J"] * s**2 + v["K"] * RATIO**2, -v["K"] * RATIO, 0.0]
    table = [-v["K"] * RATIO, v["M"] * s**2 + v["K"], v["M"] * s**2]
    column = [v["K"] * RATIO, -v["K"], v["Mc"] * s**2 + v["Dc"] * s + v["Kc"]]
    return np.linalg.solve(np.array([screw, table, column]), [1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    "nut",
    [
        Between(first=SCREW, second=TABLE, ratio=RATIO),
        Between(first=TABLE, second=SCREW, ratio=1 / RATIO),
    ],
)
def test_the_column_feels_the_thrust(nut: Between) -> None:
    true = TRUE if nut.second is TABLE else {**TRUE, "K": TRUE["K"] * RATIO**2}
    model = compiled(derive(axis_of(nut), ("q",)))
    plant = plant_of(axis_of(nut), true)
    X = model.minimal_parameters(*(true[name] for name in model.physical_units))
    for s in (20j, 60j, 300j):
        q, p, x = displacements(s)
        signals = {"q": q, "T": 1.0}
        orders = {name: name.partition("_d") for name in model.signals}
        W, y = model.sample(
            {n: np.array([(s ** int(k or 0) * signals[b]).real]) for n, (b, _, k) in orders.items()}
        )
        assert y[0, 0] == pytest.approx(float(W[0, 0] @ X), rel=1e-6, abs=1e-9 * np.abs(W[0, 0] * X).max())
        bodies = [body.name for body in axis_of(nut).free_bodies]
        moved = np.linalg.solve(plant.mass * s**2 + plant.damping * s + plant.stiffness, plant.drive)
        expected = {"column": x, "screw": q, "table": p + x}
        np.testing.assert_allclose(moved, [expected[name] for name in bodies], rtol=1e-9)
        deflection = p - RATIO * q if nut.second is TABLE else q - p / RATIO
        assert direction_of(nut, bodies) @ moved == pytest.approx(deflection, rel=1e-6)
