"""Confidence ellipses of correlated parameters."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy
from matplotlib.axes import Axes

from symid.arrays import FloatArray
from symid.report.figures.colours import Palette

CORRELATED = 0.5
"""Absolute correlation beyond which two parameters get an ellipse."""


class ShownParameters(NamedTuple):
    """Parameters of a result as its figures and pages show them."""

    units: Mapping[str, str]  # by name
    values: FloatArray
    covariance: FloatArray


class CorrelatedPair(NamedTuple):
    """Indices of two parameters, and their correlation."""

    first: int
    second: int
    correlation: float


def correlated_pairs(covariance: FloatArray) -> list[CorrelatedPair]:
    """Pairs of parameters whose correlation exceeds `CORRELATED` in size, the strongest first.

    >>> correlated_pairs(np.array([[1.0, 0.9, 0.1], [0.9, 1.0, -0.6], [0.1, -0.6, 1.0]]))[1]
    CorrelatedPair(first=1, second=2, correlation=-0.6)
    """
    deviations = np.sqrt(np.diag(covariance))
    pairs = [
        CorrelatedPair(i, j, float(covariance[i, j] / (deviations[i] * deviations[j])))
        for i, j in combinations(range(len(covariance)), 2)
        if deviations[i] > 0 and deviations[j] > 0
    ]
    found = (pair for pair in pairs if abs(pair.correlation) > CORRELATED)
    return sorted(found, key=lambda pair: -abs(pair.correlation))


def draw_ellipse(axes: Axes, pair: CorrelatedPair, of: ShownParameters, palette: Palette) -> None:
    """Regions that hold both parameters with a probability of 68 % and 95 %, and the deviations of each alone."""
    i, j, rho = pair
    names = list(of.units)
    part = of.covariance[np.ix_((i, j), (i, j))]
    # in percent of the value where it is not 0
    percent = [100.0 / abs(of.values[k]) if of.values[k] else 1.0 for k in (i, j)]
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
    axes.set_xlabel(_label(names[i], of.values[i], of.units[names[i]]))
    axes.set_ylabel(_label(names[j], of.values[j], of.units[names[j]]))
    axes.set_title(f"{names[i]}, {names[j]}: correlation {rho:+.2f}".replace("-", "−"), loc="left")
    axes.locator_params(nbins=5)


def _label(name: str, value: float, unit: str) -> str:
    return f"{name} [% of {abs(value):.4g} {unit}]" if value else f"{name} [{unit}]"
