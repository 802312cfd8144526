"""The signature of each effect: what the re-identified model leaves of a log in which the effect is hidden.

The machines are those of `benchmarks.blind`, a simulator that shares no code with symid; the effect is so strong that
the gap is about fifty times the noise. The plain axis is fitted to the log as in the diagnosis, and its force error is
drawn over the quantity that shows the effect: velocity, position, time, frequency and so on. Motion forward and
backward have different colours, lines are means in bins. For a spring the error is that of its force, from the motion
of both ends. For a further reading it is the error of the reading, with the true values of the machine, since damping
of the spring would absorb most of it.

Usage: python -m benchmarks.effect_signatures [EFFECT ...] writes docs/effects/EFFECT.png
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.effect_residuals import Residual, residual_of, signature_of
from symid.diagnosis import LIBRARY
from symid.diagnosis.findings.curves import spectrum_of
from symid.report.figures.colours import LIGHT, MEASURED, MODEL, NOISE

FOLDER = Path(__file__).parents[1] / "docs" / "effects"
_SHOWN = 5000
_BINS, _LEAST_IN_BIN = 60, 2
_LEAST_SPEED = 2e-3


LABELS = {
    "time": "time [s]",
    "velocity": "velocity [m/s]",
    "position": "position [m]",
    "angle": "angle [rad]",
    "drive force": "drive force [N]",
    "acceleration": "acceleration [m/s²]",
    "change of force": "change of force [N/s]",
    "spring": "deflection of the spring [µm]",
}
_SCALES = {"spring": 1e6}


def draw_over(axes: Axes, found: Residual, name: str, inside: tuple[float, float] | None = None) -> None:
    """Force error over a quantity, by direction of motion, with means of each direction in bins."""
    x = _SCALES.get(name, 1.0) * found.over[name]
    moving = found.used & (np.abs(found.over["velocity"]) > _LEAST_SPEED)
    low, high = inside or tuple(np.quantile(x[moving], [0.0003, 0.9997]))
    kept = moving & (x >= low) & (x <= high)
    step = max(1, int(kept.sum()) // _SHOWN)
    for way, colour, mark, label in (
        (found.forward, MEASURED, "o", "forward"),
        (~found.forward, MODEL, "^", "backward"),
    ):
        own = np.flatnonzero(kept & way)
        axes.plot(x[own[::step]], found.error[own[::step]], mark, color=colour, ms=1.4, mew=0, alpha=0.35)
        axes.plot([], [], mark, color=colour, ms=4, label=label)
        if name not in ("time", "acceleration"):
            axes.plot(*_means(x[own], found.error[own], (low, high)), color=colour, linewidth=1.6)
    axes.set_xlim(low, high)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(LABELS[name])


def _means(x: np.ndarray, y: np.ndarray, between: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Means in bins of equal width; nan, which breaks a line, where a bin holds next to nothing."""
    edges = np.linspace(*between, _BINS + 1)
    count = np.histogram(x, edges)[0]
    sums = np.histogram(x, edges, weights=y)[0]
    means = np.divide(sums, count, out=np.full(_BINS, np.nan), where=count >= _LEAST_IN_BIN)
    return (edges[1:] + edges[:-1]) / 2, means


def draw_part(axes: Axes, found: Residual, name: str, share: float) -> None:
    """As `draw_over`, for a part in the middle of the stroke or of the time."""
    moving = found.used & (np.abs(found.over["velocity"]) > _LEAST_SPEED)
    middle, whole = np.median(found.over[name][moving]), np.ptp(found.over[name][moving])
    draw_over(axes, found, name, (middle - share * whole / 2, middle + share * whole / 2))


def draw_since_reversal(axes: Axes, found: Residual) -> None:
    """Force error over the way since the last reversal; the windows around standstill are shown too."""
    v, q = found.over["velocity"], found.over["position"]
    turn = np.flatnonzero(np.diff(np.sign(v)) != 0)
    begin = turn[np.searchsorted(turn, np.arange(v.size), side="right") - 1]
    way = np.log10(np.maximum(1e6 * np.abs(q - q[begin]), 0.1))
    for forward, colour, mark, label in ((True, MEASURED, "o", "forward"), (False, MODEL, "^", "backward")):
        kept = (found.forward == forward) & (way > 0) & (way < 4.5) & (np.arange(v.size) > turn[0])
        axes.plot(way[kept], found.error[kept], mark, color=colour, ms=1.8, mew=0, alpha=0.5)
        axes.plot([], [], mark, color=colour, ms=4, label=label)
        axes.plot(*_means(way[kept], found.error[kept], (0.0, 4.5)), color=colour, linewidth=1.6)
    axes.set_xticks(range(5), ["1", "10", "100", "1000", "10 000"])
    axes.set_xlabel("way since the last reversal [µm]")


def draw_spectrum(axes: Axes, found: Residual) -> None:
    """Density of the force error beside that of the noise."""
    spectrum = spectrum_of(found.comparison)
    axes.loglog(spectrum.frequency, spectrum.reidentified, color="black", linewidth=1.0, label="force error")
    axes.loglog(spectrum.frequency, spectrum.noise, "--", color=NOISE, linewidth=1.0, label="noise")
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("N/√Hz")


def draw_panel(axes: Axes, found: Residual, panel: str) -> None:
    axes.set_ylabel(found.label)
    if panel == "frequency":
        draw_spectrum(axes, found)
    elif panel == "since reversal":
        draw_since_reversal(axes, found)
    elif panel == "low speed":
        draw_over(axes, found, "velocity", (-0.06, 0.06))
    elif panel == "part of the stroke":
        draw_part(axes, found, "position", 0.2)
    elif panel == "part of the time":
        draw_part(axes, found, "time", 0.06)
    else:
        draw_over(axes, found, panel)


def picture(effect: str, file: Path) -> None:
    found = residual_of(effect)
    panels = signature_of(effect).panels
    with mpl.rc_context({**LIGHT.style, "svg.hashsalt": "symid"}):
        figure = Figure(figsize=(8.0, 2.6), layout="constrained")
        for axes, panel in zip(figure.subplots(1, len(panels)), panels, strict=True):
            draw_panel(axes, found, panel)
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=8)
        figure.savefig(file, dpi=90, metadata={"Software": None})


def main() -> None:
    for effect in sys.argv[1:] or dict.fromkeys(known.name for known in LIBRARY):
        picture(effect, FOLDER / f"{effect}.png")
        print(f"{effect}.png")


if __name__ == "__main__":
    main()
