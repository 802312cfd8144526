"""The quick part of benchmarks/simulation.py: the same motion by symid and by solve_ivp on equations by hand."""

import pytest

from benchmarks import simulation


@pytest.mark.parametrize("case", simulation.CASES, ids=lambda case: case.axis)
def test_a_closed_loop_is_that_of_solve_ivp(case):
    run, loop = simulation.prepared(case, simulation.RATE)
    states = run().states
    found = simulation.errors(case, 1500, {"symid": states, "at rest": 0 * states})
    assert found["at rest"] > 1e-3
    assert found["symid"] < 1e-13
    assert loop.position.size == len(states)
