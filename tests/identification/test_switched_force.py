"""A force that a relay or a binary sequence switches is neither cut off nor rounded."""

import numpy as np
import pytest

from symid import Axis, Drive, Position, ViscousFriction, identify
from symid.axis import Body
from symid.data.quality.stuck import inspect_spans, is_switched
from symid.identification import Preparation
from symid.identification.faults.recording import channel_fault
from symid.identification.faults.smoothing import interpolated_from

TRUE = {"M": 6.0, "Fv": 12.0, "Fs": 2.0}
LEVEL, STEP = 13.0, 1e-4


def relay_run(every: int, resolution: float, seconds: float) -> dict[str, np.ndarray]:
    """A slide between two positions under a relay, read at every n-th step in steps of a scale; its force is held."""
    q, v, F = 0.0, 0.0, LEVEL
    rows = []
    for k in range(round(seconds / STEP)):
        if k % every == 0:
            F = -LEVEL if q + 0.05 * v > 0.02 else LEVEL if q + 0.05 * v < -0.02 else F
            rows.append((k * STEP, q, F))
        v += STEP * (F - TRUE["Fv"] * v - TRUE["Fs"] * np.sign(v)) / TRUE["M"]
        q += STEP * v
    t, position, force = np.array(rows).T
    return {"t": t, "q": resolution * np.round(position / resolution), "F": force}


@pytest.mark.parametrize(
    "run",
    [
        relay_run(20, 1e-5, 6.0),
        relay_run(100, 1e-4, 4.0),  # at the cutoff that its noise suggests, reversals leave 10 rows
    ],
    ids=["fine", "coarse and short"],
)
def test_a_relay_is_no_limit_and_no_coarse_record(run: dict[str, np.ndarray]) -> None:
    found = identify("rigid_1m", run, preparation=Preparation(held=True))
    assert found.status == "ok", found.message
    for name, value in TRUE.items():
        assert found.physical_parameters[name] == pytest.approx(value, rel=0.1)


def spindle_run(*steps: tuple[float, float]) -> dict[str, np.ndarray]:
    """A rotor that turns one way under steps of its torque, (time, level) each, with noise; step responses by hand."""
    t = np.arange(8000) / 1000
    w, F = np.zeros(t.size), np.zeros(t.size)
    for begin, torque in steps:
        after = t >= begin
        start = float(np.interp(begin, t, w))
        final = (torque - TRUE["Fs"]) / TRUE["Fv"]
        response = final + (start - final) * np.exp(-TRUE["Fv"] / TRUE["M"] * (t[after] - begin))
        w[after] = np.maximum(response, 0.0)  # friction holds it at rest
        F[after] = torque
    q = np.cumsum(w) * 1e-3 - 0.5e-3 * w  # trapezoids
    return {
        "t": t,
        "q": 1e-6 * np.round(q / 1e-6),
        "F": F + 0.06 * np.random.default_rng(1).standard_normal(t.size),
    }


def test_a_spindle_that_starts_and_brakes_at_its_torque_limit_is_not_clipped() -> None:
    found = identify(
        "rigid_1m", spindle_run((0.5, LEVEL), (4.0, -LEVEL), (4.2, 0.0)), preparation=Preparation(held=True)
    )
    assert found.status == "ok", found.message
    for name, value in TRUE.items():
        assert found.physical_parameters[name] == pytest.approx(value, rel=0.01)


@pytest.mark.parametrize(("brake", "is_hidden"), [((), True), (((5.0, 4.0),), False)])
def test_friction_that_a_constant_force_hides_is_noted(
    brake: tuple[tuple[float, float], ...], is_hidden: bool
) -> None:
    slide = Body("slide", mass="M")
    axis = Axis("slide", (slide, ViscousFriction(slide, "Fv")), Drive("F", slide), (Position("q", slide),))
    found = identify(axis, spindle_run((0.5, LEVEL), *brake))
    assert any("Coulomb friction, which the model does not have" in note for note in found.notes) is is_hidden
    if is_hidden:
        hidden = LEVEL / (LEVEL - TRUE["Fs"])
        assert found.physical_parameters["M"] == pytest.approx(TRUE["M"] * hidden, rel=0.01)


@pytest.mark.parametrize(
    ("force", "switched"),
    [
        ([4.0, 4.0, -4.0, -4.0, 4.0], True),
        ([0.0, 4.0, -4.0, 4.0, -4.0], True),
        ([0.0, 5.0, 0.0, 5.0, 5.0], True),
        ([0.0, 1.0, 0.0, -1.0, 0.0], False),  # a small force, rounded
        ([4.0, 3.0, 1.0, -2.0, -4.0], False),
    ],
)
def test_what_is_switched(force: list[float], switched: bool) -> None:
    assert is_switched(np.tile(force, 300)) is switched


def test_a_few_steps_are_no_rounding() -> None:
    levels = np.repeat([0.0, 2.0, 4.0, 6.0, 0.0], 150)
    assert is_switched(levels)
    assert not is_switched(levels + np.tile([0.0, 2.0], 375))  # a rounded force changes often


def test_the_slope_of_a_short_log_of_counts_is_not_limited() -> None:
    t = np.arange(492) / 500
    chirp = 195 * np.sin(2 * np.pi * (4.8 * t + 0.7 * t**2))
    assert channel_fault(np.round(chirp), "v") == ""
    slow = np.cumsum(np.clip(np.diff(chirp, prepend=0.0), -12.3, 12.3))
    assert "slope is limited" in channel_fault(slow, "v")


def test_a_binary_sequence_is_neither_interpolated_nor_clipped() -> None:
    rng = np.random.default_rng(2)
    levels = 1.8 + 1.2 * np.repeat(rng.integers(0, 2, 60), 8)  # a clock of 8 samples, both voltages positive
    w = np.zeros(levels.size)
    for k in range(1, w.size):
        w[k] = w[k - 1] + 0.3 * (levels[k - 1] / 0.4 - w[k - 1])
    q = 0.02 * np.cumsum(np.round(w / 0.05) * 0.05)
    t = 0.02 * np.arange(q.size)
    assert not inspect_spans(t, {"q": q, "F": levels}, {"q"})
    assert interpolated_from(levels) == 0
    ramps = np.interp(np.arange(4 * q.size) / 4, np.arange(q.size), rng.standard_normal(q.size))
    # then at rest
    assert interpolated_from(np.concatenate([ramps, np.full(ramps.size // 2, ramps[-1])])) == 4


def test_a_drive_that_swings_a_pendulum_up_is_no_overflow() -> None:
    t = np.arange(4000) / 1000
    force = np.clip(30 * np.sin(2 * np.pi * 0.7 * t), -1.0, 1.0)
    switched = np.sign(force) + 0.01 * np.round(3 * np.sin(40 * t) * (np.abs(force) < 1))
    assert channel_fault(switched, "F") == ""
    counts = (np.round(300 * np.sin(2 * np.pi * 0.7 * t)) + 128) % 256 - 128
    assert "its number overflows" in channel_fault(counts, "F")
