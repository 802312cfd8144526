"""The signature of each effect: what the re-identified model leaves of a log in which the effect is hidden.

The machines are those of `benchmarks.blind`, a simulator that shares nothing with symid; the effect is made so strong that the
gap is some fifty times the noise. The plain axis is fitted to the log as the diagnosis does, and its force error is drawn over
that which shows the effect: velocity, position, time, frequency and so on. Motion forward and backward have colours of
their own; black is the mean of both, or the spectrum.

Usage: python -m benchmarks.effect_signatures [EFFECT ...] writes docs/effects/EFFECT.png
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import symid
from symid import Axis, Log
from symid.diagnosis.comparison import Comparison, compared
from symid.diagnosis.diagnose import ITERATIONS, data_of
from symid.diagnosis.fit import first_state, fitted, refitted
from symid.report.colours import MEASURED, MODEL, NOISE
from symid.report.plots import PLOT_STYLE

from .blind import draw, gap, laws

FOLDER = Path(__file__).parents[1] / "docs" / "effects"
SEED, RATIO = 7, 50.0
_SHOWN = 5000
_LEAST_SPEED = 2e-3


@dataclass(frozen=True)
class Signature:
    """Where an effect is hidden, and over what the force error is drawn.

    `lacking` is a law that the model does without: the effect is then what the machine has anyway.
    """

    axis: str
    at: str
    panels: tuple[str, ...]
    sensors: tuple[str, ...] = ("q",)
    lacking: str | None = None
    ratio: float = RATIO


_SCREW = ("qm", "ql")
SIGNATURES = {
    "viscous_friction": Signature("rigid_1m", "motor", ("velocity", "time"), lacking="ViscousFriction"),
    "coulomb_friction": Signature("rigid_1m", "motor", ("velocity", "time"), lacking="CoulombFriction"),
    "stribeck_friction": Signature("rigid_1m", "motor", ("velocity", "low speed")),
    "asymmetric_friction": Signature("rigid_1m", "motor", ("velocity", "position")),
    "presliding_friction": Signature("rigid_1m", "motor", ("since reversal", "velocity")),
    "load_dependent_friction": Signature("rigid_1m", "motor", ("drive force", "velocity")),
    "position_dependent_friction": Signature("rigid_1m", "motor", ("position", "velocity")),
    "friction_drift": Signature("rigid_1m", "motor", ("time", "velocity")),
    "quadratic_drag": Signature("rigid_1m", "motor", ("velocity", "position")),
    "offset_force": Signature("rigid_1m", "motor", ("velocity", "position")),
    "position_stiffness": Signature("rigid_1m", "motor", ("position", "velocity")),
    "cogging": Signature("rigid_1m", "motor", ("part of the stroke", "position")),
    "periodic_disturbance": Signature("rigid_1m", "motor", ("frequency", "part of the time")),
    "payload_change": Signature("rigid_1m", "motor", ("time", "acceleration")),
    "backlash": Signature("ballscrew_2m1s", "transmission", ("spring", "frequency"), _SCREW),
    "stiffness_nonlinearity": Signature("ballscrew_2m1s", "transmission", ("spring", "frequency"), _SCREW),
    "flexible_mode": Signature("rigid_1m", "motor", ("frequency", "acceleration")),
    "delay": Signature("rigid_1m", "actuator", ("change of force", "frequency")),
    "actuator_lag": Signature("rigid_1m", "actuator", ("change of force", "frequency")),
    "saturation": Signature("rigid_1m", "actuator", ("drive force", "time")),
    "gain_nonlinearity": Signature("rigid_1m", "actuator", ("drive force", "acceleration")),
    "encoder_ripple": Signature("rigid_1m", "q", ("velocity", "part of the stroke")),
}


@dataclass(frozen=True, eq=False)
class Residual:
    """The force error of the re-identified plain axis, and what it may be drawn over, all of shape (n,)."""

    error: np.ndarray
    over: dict[str, np.ndarray]
    used: np.ndarray
    comparison: Comparison

    @property
    def forward(self) -> np.ndarray:
        """Whether the axis moves in the positive direction."""
        return self.over["velocity"] > 0


@cache
def setting(axis: str, sensors: tuple[str, ...]) -> draw.Setting:
    """The machine in which effects are hidden."""
    return draw.draw_setting(axis, sensors, np.random.default_rng(SEED))


def log_with(effect: str, signature: Signature) -> tuple[Log, dict[str, float]]:
    """A log of the machine with the effect, and the parameters of the plain axis."""
    machine = setting(signature.axis, signature.sensors)
    hidden: tuple[laws.Effect, ...] = ()
    if not signature.lacking:
        drawn = laws.draw(effect, signature.at, np.random.default_rng(SEED + 4))
        hidden, _ = draw.tamed(machine, (draw.sized(machine, drawn, signature.ratio),))
    run = draw.simulate(machine, hidden, "identification", disturbed=False)
    readings = draw.measured(machine, run.readings, "identification")
    force = symid.load_axis(signature.axis).drive.signal
    signals = {force if name == "F" else name: values for name, values in readings.items()}
    return Log.from_arrays(signals, sampling_period=1 / gap.RATE, source=effect), dict(machine.true)


def model(signature: Signature) -> Axis:
    """The plain axis, without the law that it lacks."""
    axis = symid.load_axis(signature.axis)
    kept = tuple(e for e in axis.elements if type(e).__name__ != signature.lacking)
    return replace(axis, elements=kept)


def residual_of(effect: str) -> Residual:
    """What the re-identified plain axis leaves of a log with the effect."""
    signature = SIGNATURES[effect]
    log, true = log_with(effect, signature)
    axis = model(signature)
    record = data_of(axis, log, None, None).record
    start = {name: true[name] for name in axis.physical_parameters}
    base = refitted(fitted(*first_state(record, start, None), ITERATIONS))
    comparison = compared(record, None, [base], None)
    signals = comparison.signals()
    time, rate = signals.time, 1 / (signals.time[1] - signals.time[0])
    over = {
        "time": time,
        "velocity": signals.velocity,
        "position": signals.position,
        "drive force": signals.measured,
        "acceleration": np.gradient(signals.velocity) * rate,
        "change of force": np.gradient(signals.reidentified) * rate,
    }
    if len(signature.sensors) == 2:
        one, other = signature.sensors
        over["spring"] = np.interp(time, log.time, log[other] - log[one])
    return Residual(signals.measured - signals.reidentified, over, signals.compared, comparison)


LABELS = {
    "time": "time [s]",
    "velocity": "velocity [m/s]",
    "position": "position [m]",
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
    low, high = inside or tuple(np.quantile(x[moving], [0.002, 0.998]))
    kept = moving & (x >= low) & (x <= high)
    step = max(1, int(kept.sum()) // _SHOWN)
    for way, colour, mark, label in (
        (found.forward, MEASURED, "o", "forward"),
        (~found.forward, MODEL, "^", "backward"),
    ):
        own = np.flatnonzero(kept & way)
        axes.plot(x[own[::step]], found.error[own[::step]], mark, color=colour, ms=1.4, mew=0, alpha=0.35)
        axes.plot([], [], mark, color=colour, ms=4, label=label)
        if own.size > 200 and name != "time":
            axes.plot(*_means(x[own], found.error[own]), color=colour, linewidth=1.6)
    axes.set_xlim(low, high)
    axes.set_xlabel(LABELS[name])


def _means(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means of bins that hold equally many samples."""
    order = np.argsort(x)
    bins = [b for b in np.array_split(order, 40) if b.size]
    return np.array([x[b].mean() for b in bins]), np.array([y[b].mean() for b in bins])


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
    way = 1e6 * np.abs(q - q[begin])
    for forward, colour, mark, label in ((True, MEASURED, "o", "forward"), (False, MODEL, "^", "backward")):
        kept = (found.forward == forward) & (way > 0.3) & (way < 1e4) & (np.arange(v.size) > turn[0])
        axes.semilogx(way[kept], found.error[kept], mark, color=colour, ms=1.8, mew=0, alpha=0.5)
        axes.plot([], [], mark, color=colour, ms=4, label=label)
        axes.plot(*_means(way[kept], found.error[kept]), color=colour, linewidth=1.6)
    axes.set_xlabel("way since the last reversal [µm]")


def draw_spectrum(axes: Axes, found: Residual) -> None:
    """Density of the force error beside that of the noise."""
    spectrum = found.comparison.spectrum()
    axes.loglog(spectrum.frequency, spectrum.reidentified, color="black", linewidth=1.0, label="force error")
    axes.loglog(spectrum.frequency, spectrum.noise, "--", color=NOISE, linewidth=1.0, label="noise")
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("N/√Hz")


def draw_panel(axes: Axes, found: Residual, panel: str) -> None:
    """One panel by its name."""
    axes.set_ylabel("force error [N]")
    if panel == "frequency":
        draw_spectrum(axes, found)
    elif panel == "since reversal":
        draw_since_reversal(axes, found)
    elif panel == "low speed":
        draw_over(axes, found, "velocity", (-0.1, 0.1))
    elif panel == "part of the stroke":
        draw_part(axes, found, "position", 0.2)
    elif panel == "part of the time":
        draw_part(axes, found, "time", 0.06)
    else:
        draw_over(axes, found, panel)


def picture(effect: str, file: Path) -> None:
    """Draw the signature of an effect."""
    found = residual_of(effect)
    panels = SIGNATURES[effect].panels
    with mpl.rc_context({**PLOT_STYLE, "svg.hashsalt": "symid"}):
        figure = Figure(figsize=(8.0, 2.6), layout="constrained")
        for axes, panel in zip(figure.subplots(1, len(panels)), panels, strict=True):
            draw_panel(axes, found, panel)
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=8)
        figure.savefig(file, dpi=90, metadata={"Software": None})


def main() -> None:
    """Draw the signatures of the named effects, or of all."""
    for effect in sys.argv[1:] or SIGNATURES:
        picture(effect, FOLDER / f"{effect}.png")
        print(f"{effect}.png")


if __name__ == "__main__":
    main()
