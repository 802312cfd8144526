"""Bands of a Bode diagram against responses of parameters that are drawn, and against deviations that are printed."""

from collections.abc import Callable

import numpy as np
import pytest
from hand_made import rigid_log
from matplotlib.collections import PolyCollection

import symid
from symid.arrays import ComplexArray, FloatArray
from symid.report.figures.identification_figure import plot_identification
from symid.simulation.plants.frequency_response import FrequencyResponse, identified_response, response_band

FREQUENCY = np.array([1.0, 8.0, 20.0, 28.0, 60.0])
DRAWS = 4000


def of_one_mass(p: FloatArray) -> ComplexArray:
    s = 2j * np.pi * FREQUENCY
    return 1 / (p[:, :1] * s + p[:, 1:2])


def of_two_masses(p: FloatArray) -> ComplexArray:
    """Velocity of the motor against the structure it slides on, per force between both."""
    s = 2j * np.pi * FREQUENCY
    ms, cs, ks, mm, cm = (p[:, i : i + 1] for i in range(5))
    base = ms * s + cs + ks / s
    # base v1 = cm v - F and mm s (v1 + v) + cm v = F
    return (1 + mm * s / base) / (mm * s + cm + mm * s * cm / base)


CASES: dict[str, tuple[str, dict[str, float], Callable[[FloatArray], ComplexArray]]] = {
    "rigid": ("rigid_1m", {"M": 100.0, "Fv": 900.0}, of_one_mass),
    "flexible": (
        "direct_2m1s",
        {"Ms": 400.0, "Fvs": 4000.0, "Ks": 1.2e7, "Mm": 360.0, "Fvm": 900.0},
        of_two_masses,
    ),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("size", [1e-4, 4e-3])
def test_bands_hold_95_percent_of_responses_of_drawn_parameters(name: str, size: float) -> None:
    """Even where deviations (up to 2 %) move a resonance by as much as it is wide (2 %)."""
    file, values, response = CASES[name]
    axis, signal = symid.load_axis(file), symid.load_axis(file).sensors[0].signal
    rng = np.random.default_rng(6)
    mean = np.array(list(values.values()))
    root = size * mean[:, None] * rng.standard_normal((mean.size, mean.size))
    covariance = root @ root.T
    whole = {**values, **{p: 1.0 for p in axis.physical_parameters if p not in values}}
    identified = identified_response(axis, whole, signal, FREQUENCY, 1)
    nothing = np.zeros(FREQUENCY.size)
    of = FrequencyResponse("", signal, "velocity", "", FREQUENCY, nothing + 0j, nothing, identified)
    np.testing.assert_allclose(identified, response(mean[None])[0], rtol=1e-9)
    every = np.zeros((len(whole), len(whole)))
    every[: mean.size, : mean.size] = covariance
    band = response_band(axis, whole, np.sqrt(np.diag(every)), every, of)
    drawn = response(rng.multivariate_normal(mean, covariance, DRAWS))
    phase = np.angle(drawn / identified)
    for value, low, high in ((np.abs(drawn), band.lowest, band.highest), (phase, band.latest, band.earliest)):
        slack = 1e-9 * np.abs(high)
        inside = np.mean((value >= low - slack) & (value <= high + slack), axis=0)
        assert np.all(np.abs(inside - 0.95) < 0.03), (name, inside)


def test_the_band_that_is_drawn_is_that_of_the_printed_deviation() -> None:
    """Far above Fv / M the response is 1 / (M s): its relative deviation is that of M."""
    log = rigid_log()
    found = symid.identify(symid.load_axis("rigid_1m"), log)
    drawn = plot_identification(found, axis=symid.load_axis("rigid_1m"), runs=[log])
    (magnitude,) = [axes for axes in drawn.axes if axes.get_ylabel().startswith("velocity / F")]
    (band,) = [one for one in magnitude.collections if isinstance(one, PolyCollection)]
    corners = band.get_paths()[0].vertices
    top = corners[corners[:, 0] == corners[:, 0].max()][:, 1]
    mass, deviation = found.parameters["M"], float(found.physical_deviations[0])
    assert np.log(top.max() / top.min()) / 2 == pytest.approx(1.96 * deviation / mass, rel=0.02)


def test_what_is_not_determined_makes_a_wide_band() -> None:
    axis = symid.load_axis("rigid_1m")
    values = {"M": 2.0, "Fv": 3.0, "Fs": 1.0}
    identified = identified_response(axis, values, "q", FREQUENCY, 1)
    nothing = np.zeros(FREQUENCY.size)
    of = FrequencyResponse("F", "q", "velocity", "", FREQUENCY, nothing + 0j, nothing, identified)
    band = response_band(axis, values, np.array([np.inf, 0.0, 1.0]), np.diag([np.inf, 0.0, 1.0]), of)
    assert np.all(band.highest / band.lowest > 100)
    friction = response_band(axis, values, np.array([0.0, 0.0, np.nan]), np.zeros((3, 3)), of)
    np.testing.assert_allclose(friction.highest, friction.lowest)


def test_bands_keep_peaks_between_few_places() -> None:
    axis = symid.load_axis("direct_2m1s")
    values = {**CASES["flexible"][1], "Fsm": 1.0}
    frequency = np.linspace(0.1, 600.0, 6000)
    identified = identified_response(axis, values, "q2", frequency, 1)
    nothing = np.zeros(frequency.size)
    of = FrequencyResponse("Fm", "q2", "velocity", "", frequency, nothing + 0j, nothing, identified)
    band = response_band(axis, values, np.zeros(6), np.zeros((6, 6)), of)
    assert band.frequency.size < 400
    size = np.abs(identified)
    peak = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]))[0]
    assert np.isclose(band.highest, size[peak]).any()
