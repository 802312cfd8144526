"""Bode diagram of an identified axis beside what its logs show, and confidence ellipses of correlated parameters."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import scipy
from matplotlib.axes import Axes

from symid.arrays import FloatArray
from symid.report.figures.colours import Palette
from symid.simulation.frequency_response import COHERENT, FrequencyResponse, degrees_of
from symid.simulation.response_band import ResponseBand

CORRELATED = 0.5
"""Absolute correlation beyond which two parameters get an ellipse."""


def draw_bode(
    place: Any, response: FrequencyResponse, palette: Palette, band: ResponseBand | None = None
) -> None:
    """Magnitude, phase and coherence below each other, in a subfigure."""
    magnitude, phase, coherence = place.subplots(3, 1, sharex=True, height_ratios=(2.2, 1.2, 0.8))
    sure, f = response.is_coherent, response.frequency
    curves: tuple[tuple[Axes, Any], ...] = ((magnitude, np.abs), (phase, degrees_of))
    for axes, of in curves:
        doubtful = (~sure, 1.5, 0.4, f"coherence below {COHERENT}")
        for some, size, alpha, label in (doubtful, (sure, 3.4, 1.0, "measured (H1)")):
            look: Any = {"color": palette.measured, "markersize": size, "alpha": alpha, "label": label}
            axes.plot(f[some], of(response.measured)[some], "o", **look)
        axes.plot(f, of(response.identified), color=palette.model, linewidth=1.3, label="identified")
    if band is not None:
        look = {"color": palette.model, "alpha": 0.25, "linewidth": 0, "label": "95 % of the identified"}
        magnitude.fill_between(band.frequency, band.lowest, band.highest, **look)
        turned = np.interp(band.frequency, f, degrees_of(response.identified))
        late, early = turned + np.rad2deg(band.latest), turned + np.rad2deg(band.earliest)
        phase.fill_between(band.frequency, late, early, **look)
    label = f"{response.quantity} / {response.force} [{response.unit}]"
    magnitude.set(xscale="log", yscale="log", ylabel=label)
    magnitude.set_title(f"Frequency response {response.force} → {response.signal}", loc="left", pad=44)
    seen = np.abs(np.concatenate([response.identified, response.measured[sure]]))
    magnitude.set_ylim(float(seen.min() / 3), float(seen.max() * 3))
    handles, labels = magnitude.get_legend_handles_labels()
    where: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.99), "ncols": 2}
    where |= {"columnspacing": 1.0, "handlelength": 1.4}  # within a figure for a phone
    magnitude.legend(handles[::-1], labels[::-1], frameon=False, markerscale=1.5, **where)
    phase.set(ylabel="phase [°]", ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180))
    coherence.plot(f, response.coherence, color=palette.residual, linewidth=0.8, label="coherence")
    coherence.axhline(COHERENT, color=palette.ink, linewidth=0.7, linestyle="--")
    coherence.set(ylabel="coherence", ylim=(0, 1.03), xlabel="frequency [Hz]")


def correlated_pairs(covariance: FloatArray) -> list[tuple[int, int, float]]:
    """Pairs of parameters whose correlation exceeds `CORRELATED` in size, the strongest first.

    >>> correlated_pairs(np.array([[1.0, 0.9, 0.1], [0.9, 1.0, -0.6], [0.1, -0.6, 1.0]]))
    [(0, 1, 0.9), (1, 2, -0.6)]
    """
    deviations = np.sqrt(np.diag(covariance))
    pairs = [
        (i, j, float(covariance[i, j] / (deviations[i] * deviations[j])))
        for i, j in combinations(range(len(covariance)), 2)
        if deviations[i] > 0 and deviations[j] > 0
    ]
    return sorted((pair for pair in pairs if abs(pair[2]) > CORRELATED), key=lambda pair: -abs(pair[2]))


def draw_ellipse(
    axes: Axes,
    pair: tuple[int, int, float],
    values: FloatArray,
    covariance: FloatArray,
    units: Mapping[str, str],
    palette: Palette,
) -> None:
    """Regions that hold both parameters with a probability of 68 % and 95 %, and the deviations of each alone."""
    i, j, rho = pair
    names = list(units)
    part = covariance[np.ix_((i, j), (i, j))]
    # in percent of the value where it is not 0
    percent = [100.0 / abs(values[k]) if values[k] else 1.0 for k in (i, j)]
    deviations = np.array(percent) * np.sqrt(np.diag(part))
    spread, directions = np.linalg.eigh(part / np.sqrt(np.outer(np.diag(part), np.diag(part))))
    turn = np.linspace(0, 2 * np.pi, 181)
    for level, style in ((0.95, "-"), (0.68, "--")):
        radii = np.sqrt(scipy.special.chdtri(2, 1 - level) * np.maximum(spread, 0.0))
        outline = directions @ (radii[:, None] * np.array([np.cos(turn), np.sin(turn)]))
        x, y = deviations[:, None] * outline
        axes.fill(x, y, facecolor=palette.fill, edgecolor="none", alpha=0.6)
        axes.plot(x, y, color=palette.model, linewidth=1.3, linestyle=style, label=f"{level:.0%} together")
    x_alone, y_alone = deviations[:1], deviations[1:]
    axes.errorbar(0.0, 0.0, y_alone, x_alone, color=palette.ink, capsize=2, linewidth=0.9, label="each alone")
    axes.set_xlabel(_label(names[i], values[i], units[names[i]]))
    axes.set_ylabel(_label(names[j], values[j], units[names[j]]))
    axes.set_title(f"{names[i]}, {names[j]}: correlation {rho:+.2f}".replace("-", "−"), loc="left")
    axes.locator_params(nbins=5)


def _label(name: str, value: float, unit: str) -> str:
    return f"{name} [% of {abs(value):.4g} {unit}]" if value else f"{name} [{unit}]"
