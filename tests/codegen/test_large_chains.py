"""Long chains: six masses with five springs and eight with seven, against their transfer function."""

import numpy as np
import pytest
from axes.chains import chain_plant, chain_values
from axes.plant import Values

from symid import chain
from symid.codegen.generated_models import compiled
from symid.symbolic import derive


@pytest.mark.parametrize(("masses", "parameters"), [(6, 22), (8, 30)])
def test_a_long_chain_derives_compiles_and_meets_its_transfer_function(masses: int, parameters: int) -> None:
    axis = chain("long", masses, coulomb=False)
    derived = derive(axis)
    model = compiled(derived)
    assert len(model.minimal_units) == parameters == 4 * masses - 2
    assert model.highest_derivatives == {"F": 2 * masses - 2, "q2": 2 * masses}
    values = chain_values(masses, masses - 1, 2, coulomb_level=None)
    X = model.minimal_parameters(**values)
    machine = chain_plant(Values(values), masses, masses - 1, 2)
    draw = np.random.default_rng(masses)
    for s in draw.normal(size=8) + 1j * draw.normal(size=8):
        response = np.linalg.solve(machine.M * s**2 + machine.C * s + machine.K, machine.B.astype(complex))
        compliance = machine.B @ response
        signals = {f"F_d{k}" if k else "F": s**k for k in range(2 * masses - 1)}
        signals |= {f"q2_d{k}" if k else "q2": s**k * compliance for k in range(2 * masses + 1)}
        for part in (np.real, np.imag):
            W, y = model.sample({name: np.array([part(signals[name])]) for name in model.signals})
            assert y[0, 0] - W[0, 0] @ X == pytest.approx(0.0, abs=1e-12 * (np.abs(W[0, 0]) @ np.abs(X)))
