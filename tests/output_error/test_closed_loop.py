"""Output error of the simulated closed loop: a drive at 8 kHz, a log at 250 Hz."""

import numpy as np
import pytest

from benchmarks import closed_loop as benchmark
from symid import load_axis, load_generated
from symid.errors import SettingError
from symid.output_error import identify_output_error
from symid.simulation import ClosedLoop, from_log, plant_of, simulate, trapezoids, tuned_cascade

RIGID = {"M": 40.0, "Fv": 30.0, "Fs": 12.0}


def rigid_log(seed: int = 0):
    axis = load_axis("rigid_1m")
    path = trapezoids([0.1], [0.2], acceleration=4.0, jerk=200.0, dwell=0.05, sampling_period=1 / 4000)
    controller = tuned_cascade(plant_of(axis, RIGID), "q")
    noisy = axis.with_signal("q", noise=2e-7).with_signal("F", noise=0.5)
    log = simulate(noisy, RIGID, path, controller, frequency_hz=250.0, seed=seed).log
    return axis, ClosedLoop(axis, controller, 4000.0), log


def test_the_papers_axis_at_250_hz_where_table_10_has_24_and_92_percent() -> None:
    nominal = {name: 1.1 * value for name, value in benchmark.PAPER.items()}
    found = benchmark.found((1.0, 20e-9), exact=True, speeds=(0.3,), nominal=nominal)
    assert found.status == "ok"
    deviations = np.sqrt(np.diag(found.physical_covariance(corrected=True)))
    for i, name in enumerate(found.physical_parameters):
        error = found.physical_parameters[name] - benchmark.PAPER[name]
        assert abs(error) < 4 * deviations[i]
    for name in ("Ms", "Ks"):
        assert found.physical_parameters[name] == pytest.approx(benchmark.PAPER[name], rel=0.02)


def test_an_unknown_start_friction_and_another_log() -> None:
    axis, loop, log = rigid_log()
    found = identify_output_error(axis, load_generated("rigid_1m"), log, loop=loop)
    assert found.status == "ok"
    assert found.comparison.force == "simulated"
    for name, value in RIGID.items():
        assert found.physical_parameters[name] == pytest.approx(value, rel=0.02)
    again = found.predict(rigid_log(seed=5)[2])
    assert again.residuals[0].rms < 1e-6
    assert np.isfinite(again.innovations).all()


def test_a_log_without_reference_is_reported() -> None:
    axis, loop, log = rigid_log()
    bare = type(log)(log.source, log.start, log.sampling_period, {"q": log["q"], "F": log["F"]})
    with pytest.raises(SettingError, match="no column reference"):
        identify_output_error(axis, load_generated("rigid_1m"), bare, loop=loop)


def test_the_loop_follows_a_logged_reference_as_well_as_a_given_one() -> None:
    axis, loop, log = rigid_log()
    given = ClosedLoop(axis, loop.controller, 250.0, from_log(log))
    spline = ClosedLoop(axis, loop.controller, 250.0)
    apart = given.run(RIGID, log)["q"] - spline.run(RIGID, log)["q"]
    assert np.abs(apart).max() < 1e-3 * np.ptp(log["q"])
