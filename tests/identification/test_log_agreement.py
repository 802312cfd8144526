"""Logs of a joint estimate are compared with each other by what each says alone."""

import re

import numpy as np
import pytest

from symid import Log, identify, load_generated
from symid.identification.deviations.log_agreement import LogEstimate, disagreement_between


def run(mass: float, seed: int) -> Log:
    """A mass on a guide that shakes at 1.4 and 2.1 Hz; the noise differs from log to log."""
    t, draw = np.arange(6000) / 1000, np.random.default_rng(seed)
    w, size = np.array([[9.0], [13.0]]), np.array([[0.01], [0.004]])
    q, v = np.sum(size * np.sin(w * t), axis=0), np.sum(size * w * np.cos(w * t), axis=0)
    F = mass * np.sum(-size * w**2 * np.sin(w * t), axis=0) + 4 * v + 0.5 * np.sign(v)
    noisy = {"q": q + 1e-8 * draw.standard_normal(t.size), "F": F + 0.01 * draw.standard_normal(t.size)}
    return Log.from_arrays(noisy, sampling_period=1e-3, source=f"log {seed}")


@pytest.mark.parametrize(("masses", "status"), [((5.0, 5.0, 5.0), "ok"), ((5.0, 5.0, 5.4), "poor_fit")])
def test_the_log_with_another_mass_is_named(masses: tuple[float, ...], status: str) -> None:
    found = identify(load_generated("rigid_1m"), [run(mass, k) for k, mass in enumerate(masses)])
    assert found.status == status
    own, others = (
        re.findall(r"M is ([\d.]+) in log 2, ([\d.]+) in the other", found.message)[0]
        if found.message
        else masses[::2]
    )
    assert (float(own), float(others)) == pytest.approx((masses[2], masses[0]), rel=0.01)


def test_a_log_that_determines_little_does_not_count() -> None:
    vague = LogEstimate("vague", np.array([50.0, np.nan]), np.array([40.0, np.nan]))
    sure = [LogEstimate(name, np.array([5.0, 2.0]), np.array([0.01, 0.1])) for name in "ab"]
    assert disagreement_between(["M", "K"], [vague, *sure]) == ""
    assert disagreement_between(["M", "K"], [sure[0], vague]) == ""


def test_a_log_without_rows_is_named_and_spoils_nothing() -> None:
    t = np.arange(2000) / 1000
    moving = {"q": np.sin(9 * t), "F": -405 * np.sin(9 * t) + 9 * np.cos(9 * t) + 2 * np.sign(np.cos(9 * t))}
    noise = 1e-3 * np.random.default_rng(3).standard_normal((2, t.size))
    resting = {"q": 1e-9 * noise[0], "F": noise[1]}
    logs = [Log.from_arrays(one, sampling_period=1e-3) for one in (moving, resting)]
    found = identify(load_generated("rigid_1m"), logs)
    assert found.status == "too_few_rows"
    assert np.isfinite(found.physical_deviations).all()
