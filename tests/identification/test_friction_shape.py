"""Friction that changes with the speed, where the model has Coulomb friction, and readings that jump for a sample."""

import numpy as np
import pytest

from symid import Axis, Log, identify, load_axis, load_generated
from symid.axis import CoulombFriction, ViscousFriction


def run(stribeck: float = 0.0, spikes: tuple[int, ...] = (), coulomb: float = 6.0) -> Log:
    """A mass of 5 kg that moves with two sines, 4 N s/m and 6 N of friction, more of it below 1 m/s."""
    t, rng = np.arange(8000) / 1000, np.random.default_rng(0)
    w, size = np.array([[3.0], [17.0]]), np.array([[1.0], [0.1]])
    q, v = np.sum(size * np.sin(w * t), axis=0), np.sum(size * w * np.cos(w * t), axis=0)
    F = 5 * np.sum(-size * w**2 * np.sin(w * t), axis=0) + 4 * v
    F += (coulomb + stribeck * np.exp(-np.abs(v))) * np.sign(v) + 0.02 * rng.standard_normal(t.size)
    q = q + 1e-7 * rng.standard_normal(t.size)
    q[list(spikes)] += 0.3
    return Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)


@pytest.mark.parametrize("share", [0.0, 0.3, -0.3])
def test_friction_of_another_course_over_the_speed_is_named(share: float) -> None:
    found = identify(load_generated("rigid_1m"), run(stribeck=6 * share))
    assert ("more of it at low speed" in found.message) == (share > 0)
    assert ("less of it at low speed" in found.message) == (share < 0)
    assert (found.status == "ok") == (share == 0)


def lacking(law: type) -> Axis:
    """The rigid axis without one of its laws."""
    axis = load_axis("rigid_1m")
    return axis.without(*(one for one in axis.laws if isinstance(one, law)))


@pytest.mark.parametrize("coulomb", [0.0, 3.0, 40.0])
def test_a_model_without_coulomb_friction_is_ok_only_where_there_is_none(coulomb: float) -> None:
    found = identify(lacking(CoulombFriction), run(coulomb=coulomb))
    assert (found.status == "ok") == (coulomb == 0.0)
    assert ("the model lacks Coulomb friction, which explains" in found.message) == (coulomb > 0.0)


@pytest.mark.parametrize("coulomb", [0.1, 6.0, 40.0])
def test_missing_viscous_friction_is_named_before_the_delay_that_it_looks_like(coulomb: float) -> None:
    found = identify(lacking(ViscousFriction), run(coulomb=coulomb))
    assert found.status == "poor_fit"
    assert "the model lacks viscous friction, which explains" in found.message


@pytest.mark.parametrize("coulomb", [0.03, 0.3])
def test_intervals_hold_viscous_friction_where_little_coulomb_friction_is_missing(coulomb: float) -> None:
    found = identify(lacking(CoulombFriction), run(coulomb=coulomb))
    error, deviation = found.physical_parameters["Fv"] - 4.0, found.physical_deviations[1]
    assert found.status == "ok"
    assert 0.2 * deviation < error < 2 * deviation


def test_a_reading_that_jumps_for_a_sample_is_named() -> None:
    found = identify(load_generated("rigid_1m"), run(spikes=(2000, 5000)))
    assert "q jumps by 0.301 and back within a sample at t = 2 s" in found.message
    assert found.status != "ok"
