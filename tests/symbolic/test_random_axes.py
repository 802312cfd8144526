"""A quick slice of benchmarks/random_axes.py: derived equations of random axes beside an ODE written by hand."""

import numpy as np
from hypothesis import HealthCheck, given, settings, strategies as st

from benchmarks import random_axes


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 5))
def test_equations_are_those_of_the_ode(seed: int, n: int) -> None:
    verdict, printed = random_axes.outcome(seed, n)
    assert verdict == "agrees", printed


def test_an_ode_with_another_stiffness_would_be_seen(monkeypatch) -> None:
    drawn = random_axes.machine

    def other(n: int, rng: np.random.Generator) -> random_axes.Machine:
        found = drawn(n, rng)
        found.stiffness[0] *= 1.001
        return found

    monkeypatch.setattr(random_axes, "machine", other)
    assert random_axes.outcome(1, 3)[0] == "differs"
