"""An offset of the force may pass zero: its change within a log counts in relation to the friction beside it."""

import numpy as np
import pytest

from symid import Log, identify, load_generated


@pytest.mark.parametrize(("step", "status"), [(1.0, "ok"), (6.0, "poor_fit")])
def test_a_small_step_of_a_small_offset_is_no_other_machine(step: float, status: str) -> None:
    t, draw = np.arange(10_000) / 1000, np.random.default_rng(0)
    w, size = np.array([[5.0], [8.0]]), np.array([[0.05], [0.02]])
    q, v = np.sum(size * np.sin(w * t), axis=0), np.sum(size * w * np.cos(w * t), axis=0)
    F = 90 * np.sum(-size * w**2 * np.sin(w * t), axis=0) + 200 * v + 20 * np.sign(v) - 3 + step * (t > 6)
    F += 0.1 * draw.standard_normal(t.size)
    found = identify(load_generated("emps"), Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3))
    assert found.status == status, found.message
    assert status == "ok" or "parameters change within the logs" in found.message
