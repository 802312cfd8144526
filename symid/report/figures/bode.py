"""Bode diagram of an identified axis beside what its logs show."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from symid.report.figures.colours import Palette
from symid.simulation.frequency_response import COHERENT, FrequencyResponse, degrees_of
from symid.simulation.response_band import ResponseBand


def draw_bode(place: Any, response: FrequencyResponse, palette: Palette, band: ResponseBand) -> None:
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
