"""Logs that each move one way, as of a friction test: forwards in one file, backwards in another."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, Position, ViscousFriction
from symid.diagnosis import diagnose

M, FV, FS, HANGS = 20.0, 60.0, 15.0, 6.0
PERIOD = 2e-3


def pass_of(way: float, rng: np.random.Generator) -> Log:
    """A pass at three speeds, by the formula of its force; a constant force hangs on the machine."""
    t = PERIOD * np.arange(2000)
    speeds = np.repeat([0.0, 0.1, 0.25, 0.16], 500)
    smooth = np.hanning(151)
    v = way * np.convolve(np.pad(speeds, 75, mode="edge"), smooth / smooth.sum(), mode="valid")
    a = np.gradient(v, PERIOD)
    F = M * a + FV * v + FS * np.sign(v) + HANGS + 0.1 * rng.standard_normal(t.size)
    q = (np.cumsum(v) - 0.5 * v) * PERIOD + 1e-6 * rng.standard_normal(t.size)
    keep = np.abs(v) > 1e-3
    return Log.from_arrays({"q": q[keep], "F": F[keep]}, sampling_period=PERIOD)


@pytest.mark.parametrize("is_given", [False, True])
def test_a_constant_force_shows_in_passes_of_one_way_each(is_given: bool) -> None:
    rng = np.random.default_rng(3)
    body = Body("slide", mass="M")
    laws = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"))
    axis = Axis("slide", (body, *laws), Drive("F", body), (Position("q", body),))
    there, back = pass_of(1.0, rng), pass_of(-1.0, rng)
    if is_given:
        found = diagnose(axis, there, validation=back, held=False)
        assert any("shows only in both" in text for text in found.assumptions)
    else:
        found = diagnose(axis, [there, back], held=False)
    assert (found.verdict, [e.effect for e in found.effects]) == ("effect", ["offset_force"])
    value = found.effects[0].parameters["F0"]
    assert abs(value.value - HANGS) < 3 * value.std < 0.5
