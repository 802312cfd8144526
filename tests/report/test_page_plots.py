"""Plots of a page: the numbers behind them are those of hand-made machines."""

import numpy as np
import pytest
from bokeh.plotting import figure
from diagnosis_example import diagnosis_example
from hand_made import RATE, plain_force, rigid_log

from symid import Log, load_axis
from symid.diagnosis import diagnose
from symid.diagnosis.effects import DelayEffect
from symid.report.figures.binned_means import means_over
from symid.report.pages.interactive import error_maps, plots_of
from symid.report.pages.page_bode import bode_plots
from symid.simulation.plants.frequency_response import response_of

AXIS = load_axis("rigid_1m")
LATE = 4e-3


def plot(grid, place: int = 0) -> figure:
    """A plot of a grid, from above."""
    return grid.children[place][0]


def column(drawn: figure, name: str) -> np.ndarray:
    """A column that a plot draws."""
    sources = [renderer.data_source.data for renderer in drawn.renderers]
    return np.asarray(next(data for data in sources if name in data)[name], dtype=float)


@pytest.fixture(scope="module")
def delayed():
    """A machine whose force acts 4 ms late, diagnosed."""

    def later(t, q, v, a, path):
        return plain_force(path, t + LATE) - plain_force(path, t)

    return diagnose(AXIS, rigid_log(later, seconds=12.0), library=(DelayEffect(),))


def test_zero_parts_two_bins() -> None:
    x = np.random.default_rng(3).uniform(-1.0, 2.3, 5000)
    means = means_over(x, np.sign(x))
    np.testing.assert_array_equal(means.values, np.sign(means.places))
    np.testing.assert_array_equal(means.doubt, 0.0)


def test_the_friction_map_is_the_friction_that_is_missing() -> None:
    over_velocity, _ = error_maps(diagnosis_example("effect"))
    means = [r.data_source.data for r in plot(over_velocity).renderers if "mean" in r.data_source.data]
    before_forward, before_backward, after_forward, after_backward = (means[3 * k] for k in range(4))
    for side, before in ((1.0, before_forward), (-1.0, before_backward)):
        speed, force = side * before["x"], side * before["mean"]
        assert np.all(speed > 0)
        missing = 0.92 * 45 * np.exp(-((speed / 0.02) ** 2))  # as the machine of the example is made
        np.testing.assert_allclose(force[speed > 0.05], missing[speed > 0.05], atol=0.5)
        slowest = np.argmin(speed)
        assert force[slowest] == pytest.approx(missing[slowest], rel=0.2)
    after = np.concatenate([after_forward["mean"], after_backward["mean"]])
    assert np.max(np.abs(after)) < 0.2 * np.max(before_forward["mean"])


def test_the_bode_diagram_shows_the_mass_and_the_delay_that_was_found(delayed) -> None:
    assert [(e.effect, e.at) for e in delayed.effects] == [("delay", "actuator")]
    (name, grid), *others = bode_plots(delayed).items()
    assert (name, others) == ("response of q", [])
    f = column(plot(grid), "frequency")
    before = {p.name: p.reidentified for p in delayed.parameters}
    after = {p.name: p.explained for p in delayed.parameters}
    s = 2j * np.pi * f
    np.testing.assert_allclose(
        column(plot(grid), "magnitude_reidentified"), np.abs(1 / (before["M"] * s + before["Fv"])), rtol=1e-5
    )
    late = np.exp(-s * delayed.effects[0].parameters["T"].value) / (after["M"] * s + after["Fv"])
    shown = np.exp(1j * np.deg2rad(column(plot(grid, 1), "phase_explained")))
    np.testing.assert_allclose(shown, late / np.abs(late), atol=1e-5)
    band = (f > 8) & (f < 18)
    points = column(plot(grid, 1), "phase_measured")[band]
    turned = np.rad2deg(np.angle(np.exp(1j * np.deg2rad(points)) / late[band]))
    assert abs(np.nanmedian(turned)) < 3  # against 19 degrees that the delay makes at 13 Hz


def test_signals_recorded_late_are_moved_in_time() -> None:
    log, values = rigid_log(), {"M": 100.0, "Fv": 150.0, "Fs": 8.0}
    plain, moved = (response_of(AXIS, values, "q", [log], late) for late in (None, {"q": 3e-3, "F": 1e-3}))
    np.testing.assert_allclose(moved.measured / plain.measured, np.exp(2j * np.pi * plain.frequency * 2e-3))


def test_a_log_that_excites_nothing_has_no_response() -> None:
    draw = np.random.default_rng(2)
    force, position = 10 * draw.standard_normal((2, 20_000))
    still = Log("rest", 0.0, 1 / RATE, {"F": force, "q": 1e-6 * position})
    assert response_of(AXIS, {"M": 100.0, "Fv": 150.0, "Fs": 8.0}, "q", [still]).top_hz == 0
    assert response_of(AXIS, {"M": 100.0, "Fv": 150.0, "Fs": 8.0}, "q", [rigid_log(seconds=12.0)]).top_hz > 15


def test_a_page_holds_a_response_only_where_there_is_one(delayed) -> None:
    assert list(plots_of(delayed).responses) == ["response of q"]
    assert plots_of(diagnosis_example("effect")).responses == {}
