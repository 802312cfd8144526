"""Figures of an identification: what they show is checked against the record and against transfer functions."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from hand_made import RATE, RIGID, rigid_log
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from symid import Log, load_axis
from symid.codegen.generated_models import load_generated
from symid.identification import Identification, identify_by_least_squares, predict
from symid.report.figures.colours import DARK, LIGHT
from symid.report.figures.identification_curves import (
    CorrelatedPair,
    ShownParameters,
    correlated_pairs,
    draw_ellipse,
)
from symid.report.figures.identification_figure import plot_identification
from symid.simulation.plants.frequency_response import response_of

AXIS = load_axis("rigid_1m")


@cache
def identified() -> tuple[Identification, Log]:
    """A log with a residual that is known: 3 N sign(v) less than Coulomb friction below 0.05 m/s."""
    log = rigid_log(lambda t, q, v, a, path: 6.0 * np.sign(v) * np.exp(-((v / 0.05) ** 2)))
    return identify_by_least_squares(load_generated("rigid_1m", ("q",)), [log]), log


@cache
def figure() -> Figure:
    """With its axis and log."""
    found, log = identified()
    return plot_identification(found, axis=AXIS, runs=[log])


def axes_with(label: str) -> Axes:
    """The plot with a label below it."""
    (found,) = [axes for axes in figure().axes if axes.get_xlabel() == label]
    return found


def line(axes: Axes, label: str) -> Line2D:
    """A curve by its label."""
    (found,) = [one for one in axes.lines if one.get_label() == label]
    return found


def test_every_plot_has_labels_with_units() -> None:
    shown = {(axes.get_xlabel(), axes.get_ylabel()) for axes in figure().axes if axes.axison}
    for pair in (
        ("measured F [N]", "predicted [N]"),
        ("time [s]", "residual [N]"),
        ("velocity of q [m/s]", "residual [N]"),
        ("position q [m]", "residual [N]"),
        ("frequency [Hz]", "F [N/√Hz]"),
        ("frequency [Hz]", "coherence"),
        ("", "velocity / F [m/s per N]"),
        ("", "phase [°]"),
    ):
        assert pair in shown


def test_measured_less_predicted_is_the_residual_shown() -> None:
    found, _ = identified()
    top = figure().axes[0]
    below = axes_with("time [s]")
    measured, predicted = (line(top, name).get_ydata() for name in ("measured", "predicted"))
    np.testing.assert_allclose(line(below, "residual").get_ydata(), np.subtract(measured, predicted))
    rms = np.sqrt(np.nanmean(np.square(line(below, "residual").get_ydata())))
    assert rms == pytest.approx(found.residuals[0].rms, rel=1e-9)


def test_the_friction_map_shows_the_friction_that_the_model_lacks() -> None:
    axes = axes_with("velocity of q [m/s]")
    (means,) = [c for c in axes.containers if c.get_label() == "mean"]
    speed, mean = means.lines[0].get_data()
    resisting = mean * np.sign(speed)
    slow, fast = resisting[np.abs(speed) < 0.04], resisting[np.abs(speed) > 0.08]
    assert np.min(slow) > 1.0
    assert np.mean(slow) > np.mean(fast) + 1.5


def test_the_bode_diagram_is_that_of_the_mass_and_its_friction() -> None:
    found, _ = identified()
    (magnitude,) = [axes for axes in figure().axes if axes.get_ylabel().startswith("velocity / F")]
    curve = line(magnitude, "identified")
    values = found.physical_parameters
    s = 2j * np.pi * np.asarray(curve.get_xdata())
    np.testing.assert_allclose(curve.get_ydata(), np.abs(1 / (values["M"] * s + values["Fv"])), rtol=1e-9)
    assert (magnitude.get_xscale(), magnitude.get_yscale()) == ("log", "log")


def test_the_measured_response_is_the_true_one_where_it_is_coherent() -> None:
    draw, n = np.random.default_rng(8), 40_000
    force = 50 * draw.standard_normal(n)
    position, speed = np.zeros(n + 1), np.zeros(n + 1)
    M, Fv = RIGID["M"], 4000.0
    decay = np.exp(-Fv / M / RATE)
    for k in range(n):  # exact for a force that is held
        speed[k + 1] = decay * speed[k] + (1 - decay) / Fv * force[k]
        position[k + 1] = position[k] + force[k] / Fv / RATE - (speed[k + 1] - speed[k]) * M / Fv
    log = Log("by hand", 0.0, 1 / RATE, {"F": force, "q": position[:-1]})
    found = response_of(AXIS, {"M": M, "Fv": Fv, "Fs": 0.0}, "q", [log])
    band = (found.frequency > 2) & (found.frequency < 100)
    assert np.min(found.coherence[band]) > 0.9
    ratio = found.measured[band] / found.identified[band] / np.exp(-1j * np.pi * found.frequency[band] / RATE)
    assert abs(np.mean(ratio) - 1) < 0.02
    assert np.std(ratio) < 0.1


def test_an_ellipse_holds_the_probability_that_it_says() -> None:
    covariance = np.array([[4.0, -2.4], [-2.4, 2.25]])
    axes = Figure().subplots()
    parameters = ShownParameters(
        {"a": "N", "b": "kg"}, np.array([100.0, 50.0]), covariance, np.sqrt(np.diag(covariance))
    )
    draw_ellipse(axes, CorrelatedPair(0, 1, -0.8), parameters, LIGHT)
    points = np.random.default_rng(4).multivariate_normal([0, 0], covariance, 100_000)
    for curve, wanted in zip(axes.lines[:2], (0.95, 0.68), strict=True):
        outline = np.array(curve.get_data()) / [[1.0], [2.0]]  # percent of 100 and of 50
        inverse = np.linalg.inv(covariance)
        radius = np.einsum("ik,ij,jk->k", outline, inverse, outline)
        assert np.ptp(radius) < 1e-9 * radius[0]
        inside = np.einsum("ki,ij,kj->k", points, inverse, points) < radius[0]
        assert np.mean(inside) == pytest.approx(wanted, abs=0.005)
    assert axes.get_title(loc="left") == "a, b: correlation −0.80"
    assert axes.get_xlabel() == "a [% of 100 N]"


def test_only_correlated_parameters_get_an_ellipse() -> None:
    found, _ = identified()
    slopes = found.physical[0].sensitivity
    expected = correlated_pairs(slopes @ found.covariance @ slopes.T)
    drawn = [axes for axes in figure().axes if "correlation" in axes.get_title(loc="left")]
    assert [(i, j) for i, j, _ in expected] == [(1, 2)]
    assert [axes.get_title(loc="left").split(":")[0] for axes in drawn] == ["Fv, Fs"]


def test_a_validation_gets_a_panel_with_its_own_motion() -> None:
    found, log = identified()
    other = rigid_log(seed=5)
    drawn = plot_identification(found, predict(found, other), axis=AXIS, runs=[log, other], palette=DARK)
    labels = [axes.get_xlabel() for axes in drawn.axes]
    assert labels.count("velocity of q [m/s]") == 2
    maps = [axes for axes in drawn.axes if axes.get_xlabel() == "position q [m]"]
    spans = [np.ptp(axes.lines[0].get_xdata()) for axes in maps]
    assert spans[0] == pytest.approx(np.ptp(log["q"]), rel=0.1)
    assert spans[1] == pytest.approx(np.ptp(other["q"]), rel=0.1)


def test_curves_are_distinguished_without_colour() -> None:
    top = figure().axes[0]
    wide, thin = line(top, "measured"), line(top, "predicted")
    assert wide.get_linewidth() > 2 * thin.get_linewidth()
    (spectrum,) = [axes for axes in figure().axes if axes.get_ylabel() == "F [N/√Hz]"]
    assert line(spectrum, "measured").get_linestyle() != line(spectrum, "residual").get_linestyle()


def test_the_command_draws_on_a_dark_background(folder: Path) -> None:
    from symid.cli.simulate_command import write_log

    write_log(identified()[1], Path("run.csv"))
    assert run("identify", "rigid_1m", "run.csv", "--plot", "run.svg", "--dark") == 0
    assert DARK.paper.lower() in Path("run.svg").read_text().lower()
