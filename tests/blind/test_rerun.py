"""The re-run of benchmarks/blind: an axis that is written as it is moves as the independent simulator has it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import welch

from benchmarks.blind import draw, laws, rerun
from symid import Backlash, GapDamping, OffsetForce, Spring, load_axis


@pytest.fixture(scope="module")
def setting() -> draw.Setting:
    found = draw.draw_setting("rigid_1m", ("q",), np.random.default_rng(5))
    return replace(found, noisy_controller=False)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_the_true_axis_moves_as_the_independent_simulator_has_it(setting: draw.Setting) -> None:
    """A constant force of 20 N, which `OffsetForce` counts against the positive direction."""
    drawn = laws.draw("offset_force", "motor", np.random.default_rng(1))
    force = replace(drawn, numbers={"force": 20.0, "side": 1.0})
    position = draw.simulate(setting, (force,), "validation", disturbed=True).readings["q"]
    axis = load_axis("rigid_1m")
    true = axis.with_effect(OffsetForce(axis.bodies[0], "OF"))
    found = rerun.simulated(true, {**setting.true, "OF": -20.0}, setting)
    without = rerun.simulated(axis, setting.true, setting)
    assert rms(found - position) < 2e-8  # below the noise of any encoder drawn
    assert rms(without - position) > 100 * rms(found - position)


def test_values_estimated_from_a_noisier_force_leave_the_motion_further_off(setting: draw.Setting) -> None:
    noisier = replace(setting, noise=setting.noise | {"F": 3 * setting.noise["F"]})
    quiet, loud = rerun.least_of_values(setting), rerun.least_of_values(noisier)
    assert loud == pytest.approx(3 * quiet)
    assert quiet < setting.noise["position"]


def test_the_density_is_that_of_the_noise_in_a_worldly_record(setting: draw.Setting) -> None:
    worldly = draw.wandering(setting, np.random.default_rng(3))
    force = np.full(1 << 17, 100.0)
    noise = draw.measured(worldly, {"F": force}, "validation")["F"] - force
    frequency, found = welch(noise, nperseg=4096, return_onesided=False, detrend=False)
    stated = draw.force_density(worldly, frequency)
    for low, high in ((3e-4, 3e-3), (3e-3, 0.03), (0.1, 0.5)):
        inside = (frequency > low) & (frequency < high)
        assert np.mean(found[inside]) == pytest.approx(np.mean(stated[inside]), rel=0.15)


def test_damping_that_ends_in_the_gap_moves_as_the_independent_simulator_has_it() -> None:
    """The damping of the other simulator's spring ends where the play begins."""
    setting = replace(
        draw.draw_setting("ballscrew_2m1s", ("qm",), np.random.default_rng(4)), noisy_controller=False
    )
    drawn = replace(laws.draw("backlash", "transmission", np.random.default_rng(1)), numbers={"gap": 5e-5})
    position = draw.simulate(setting, (drawn,), "validation", disturbed=True).readings["qm"]
    axis = load_axis("ballscrew_2m1s")
    (spring,) = (element for element in axis.elements if isinstance(element, Spring))
    play, free = Backlash(spring.at, "Kb", gap=5e-5), GapDamping(spring.at, "Cb", gap=5e-5)
    values = {**setting.true, "Kb": setting.true["Kt"], "Cb": setting.true["Ft"]}
    damped, undamped = (
        rms(rerun.simulated(axis.with_effect(*laws), values, setting) - position)
        for laws in ((play,), (play, free))
    )
    assert undamped < 2e-8 < 1e-7 < damped


def test_the_table_counts_cases_by_kind() -> None:
    label = {"axis": "rigid_1m", "effects": [{"effect": "delay", "at": "actuator"}]}
    cases = [rerun.Rerun("case", label, 1e-7, 1.4e-7, off, "", 0.05) for off in (1.1e-7, 1.3e-7, 0.9e-7)]
    rows = rerun.table(cases).splitlines()
    assert rows[1].split() == ["delay", "2/3", "3/3", "1.10", "1.30"]
    assert rows[2].split() == ["all", "2/3", "3/3", "1.10", "1.30"]
    assert rows[-1].endswith("median 20.0, least 20.0")
