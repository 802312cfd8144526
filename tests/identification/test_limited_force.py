"""A force that is cut off, most of it faster than the cutoff, or larger in one direction."""

import numpy as np
import pytest

from benchmarks.promise.machines import draw_case
from symid import Log, identify, load_generated


@pytest.mark.parametrize(
    ("limit", "words"),
    [(0.4, "without those parts the parameters differ"), (0.6, "its largest values explain")],
)
def test_a_force_that_is_cut_off_faster_than_the_cutoff_is_named(limit: float, words: str) -> None:
    generator = np.random.default_rng([112303, 46, 1])
    case = draw_case(generator)
    force = case.signals[case.force]
    level = limit * np.max(np.abs(force))
    for cut, is_named in ((force, False), (np.clip(force, -level, level), True)):
        noisy = cut + 0.01 * level * generator.standard_normal(force.size) * is_named
        log = Log.from_arrays({**case.signals, case.force: noisy}, sampling_period=1 / case.rate)
        found = identify(load_generated(case.axis, case.measured), log)
        assert (words in found.message, found.status == "ok") == (is_named, not is_named), found.message


@pytest.mark.parametrize("of", ["force", "motion"])
@pytest.mark.parametrize("gain", [0.8, 1.0, 1.2])
def test_a_gain_that_differs_by_direction_is_named(of: str, gain: float) -> None:
    """A constant force that the model lacks is none: it moves no parameter."""
    t = np.arange(8000) / 1000
    q, v, a = (
        f(t)
        for f in (
            lambda t: np.sin(3 * t) + 0.1 * np.sin(17 * t),
            lambda t: 3 * np.cos(3 * t) + 1.7 * np.cos(17 * t),
            lambda t: -9 * np.sin(3 * t) - 28.9 * np.sin(17 * t),
        )
    )
    F = 5 * a + 4 * v + 6 * np.sign(v)
    recorded = np.where((F if of == "force" else v) > 0, gain * F, F) + 3.0
    recorded = recorded + 0.05 * np.random.default_rng(0).standard_normal(t.size)
    found = identify(
        load_generated("rigid_1m"), Log.from_arrays({"q": q, "F": recorded}, sampling_period=1e-3)
    )
    assert found.status == ("ok" if gain == 1.0 else "recording"), found.message
    assert ("differs by direction" in found.message) == (gain != 1.0)
