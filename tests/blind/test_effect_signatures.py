"""Pictures of the catalogue: one for each effect, and what they show is what was hidden."""

import numpy as np
import pytest

from benchmarks import effect_residuals
from benchmarks.blind import draw
from benchmarks.effect_residuals import LATE, SIGNATURES, residual_of
from benchmarks.effect_signatures import picture
from symid.diagnosis import LIBRARY


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four seconds of moves; the motions of the blind cases, which they replace, are shorter still."""
    monkeypatch.setattr(effect_residuals, "MOVES", ((0.4, 0.2), (0.2, 0.2), (0.1, 0.1)))
    monkeypatch.setattr(draw, "SECONDS", {"identification": 1.0, "validation": 1.0})


def test_signatures_are_those_of_the_library() -> None:
    assert set(SIGNATURES) <= {effect.name for effect in LIBRARY}


def test_a_constant_force_is_left_as_a_constant(tmp_path) -> None:
    found = residual_of("offset_force")
    moving = found.used & (np.abs(found.over["velocity"]) > 0.01)
    forward, backward = (found.error[moving & way].mean() for way in (found.forward, ~found.forward))
    assert abs(forward) > 10.0
    assert abs(forward - backward) < 0.02 * abs(forward)
    picture("offset_force", tmp_path / "offset.png")
    assert (tmp_path / "offset.png").read_bytes().startswith(b"\x89PNG")


def test_a_late_reading_follows_the_speed() -> None:
    found = residual_of("sensor_delay")
    speed = found.over["velocity"][found.used]
    slope = np.polyfit(speed, found.error[found.used], 1)[0]
    assert abs(slope / (-1e6 * LATE) - 1) < 0.02
