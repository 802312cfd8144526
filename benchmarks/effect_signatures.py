"""The signature of each effect: what the re-identified model leaves of a log in which the effect is hidden.

The machines are those of `benchmarks.blind`, a simulator that shares no code with symid; the effect is so strong that
the gap is about fifty times the noise. The plain axis is fitted to the log as in the diagnosis, and its force error is
drawn over the quantity that shows the effect: velocity, position, time, frequency and so on. Motion forward and
backward have different colours, lines are means in bins. For a spring the error is that of its force, from the motion
of both ends. For a further reading it is the error of the reading, with the true values of the machine, since damping
of the spring would absorb most of it.

Usage: python -m benchmarks.effect_signatures [EFFECT ...] writes docs/effects/EFFECT.png
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import symid
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, Spring, ViscousFriction
from symid.data import LowPass, derivatives
from symid.diagnosis import LIBRARY
from symid.diagnosis.findings.comparison import Comparison, compared
from symid.diagnosis.findings.curves import signal_curves, spectrum_of
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recorded, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.report.figures.colours import MEASURED, MODEL, NOISE
from symid.report.figures.identification_figure import PLOT_STYLE

from .blind import draw, gap, laws, motion
from .blind.engine import CONTROL_HZ, LOG_TICKS
from .diagnosis.other_machines import Loop, Recorder, run

FOLDER = Path(__file__).parents[1] / "docs" / "effects"
READING = "ql"
DAMPING = "damping"
"""What a model lacks whose spring is declared without it."""
"""Further reading of the ball screw."""
SEED, RATIO = 7, 50.0
LATE = 0.25e-3
"""Time by which a late reading is late, s: one sample of the logs of the blind cases."""
MOVES = ((0.4, 0.2), (0.01, 0.02), (0.2, 0.2), (0.04, 0.06), (0.5, 0.2), (0.1, 0.1))
"""Speed and way of the moves to and fro, m/s and m."""
_TURNED = 12.0
"""Angle of the table per metre of the other moves, rad/m."""
_SHOWN = 5000
_BINS, _LEAST_IN_BIN = 60, 2
_LEAST_SPEED = 2e-3


@dataclass(frozen=True)
class Signature:
    """Where an effect is hidden, and over what the force error is drawn.

    `shape` fixes numbers of the effect other than its size. `lacking` is a law that the model does without: the effect
    is then what the machine has anyway. Where `shaken`, a multisine is added to the force.
    """

    at: str
    panels: tuple[str, ...]
    shape: dict[str, float] = field(default_factory=dict)
    lacking: str | None = None
    shaken: bool = False

    @property
    def axis(self) -> str:
        """The ball screw for effects in a spring or in a further reading, else the rigid axis."""
        return "ballscrew_2m1s" if self.at in ("transmission", READING) else "rigid_1m"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Both ends of the spring where there is one."""
        return ("qm", READING) if self.axis == "ballscrew_2m1s" else ("q",)

    @property
    def unit(self) -> tuple[str, float]:
        """Label of the error that is drawn, and its scale."""
        if self.at == "table":
            return "torque error [N m]", 1.0
        return (f"error of {READING} [µm]", 1e6) if self.at == READING else ("force error [N]", 1.0)


SIGNATURES = {
    "viscous_friction": Signature("motor", ("velocity", "time"), lacking="ViscousFriction"),
    "coulomb_friction": Signature("motor", ("velocity", "time"), lacking="CoulombFriction"),
    "stribeck_friction": Signature("motor", ("velocity", "low speed"), {"vs": 0.02}),
    "asymmetric_friction": Signature("motor", ("velocity", "position"), {"side": 1.0}),
    "presliding_friction": Signature("motor", ("since reversal", "velocity")),
    "load_dependent_friction": Signature("motor", ("drive force", "acceleration")),
    "position_dependent_friction": Signature("motor", ("position", "time"), {"pitch": 0.15, "phase": 0.0}),
    "friction_drift": Signature("motor", ("time", "velocity"), {"time": 4.0}),
    "quadratic_drag": Signature("motor", ("velocity", "time")),
    "offset_force": Signature("motor", ("velocity", "position"), {"side": 1.0}),
    "position_stiffness": Signature("motor", ("position", "time")),
    "weight": Signature("table", ("angle", "time")),
    "cogging": Signature("motor", ("part of the stroke", "frequency"), {"pitch": 0.01, "phase": 0.0}),
    "periodic_disturbance": Signature("motor", ("frequency", "part of the time"), {"frequency": 8.0}),
    "payload_change": Signature("motor", ("time", "acceleration"), {"time": 6.0}),
    "backlash": Signature("transmission", ("spring", "frequency"), shaken=True),
    "stiffness_nonlinearity": Signature("transmission", ("spring", "frequency"), shaken=True),
    "spring_damping": Signature(READING, ("part of the time", "velocity"), lacking=DAMPING),
    "flexible_mode": Signature(
        "motor", ("frequency", "time"), {"frequency": 30.0, "damping": 0.02}, shaken=True
    ),
    "delay": Signature("actuator", ("change of force", "frequency")),
    "actuator_lag": Signature("actuator", ("change of force", "frequency")),
    "saturation": Signature("actuator", ("drive force", "time")),
    "gain_nonlinearity": Signature("actuator", ("drive force", "acceleration"), {"cubic": 1.0}),
    "force_constant_ripple": Signature(
        "actuator", ("part of the stroke", "drive force"), {"pitch": 0.02, "phase": 0.0}
    ),
    "sensor_delay": Signature(READING, ("velocity", "time")),
    "encoder_ripple": Signature("q", ("part of the stroke", "velocity"), {"pitch": 0.004, "phase": 0.0}),
}


def signature_of(effect: str) -> Signature:
    """Where and how an effect is shown: unless `SIGNATURES` knows better, in the motor over velocity and position."""
    return SIGNATURES.get(effect, Signature("motor", ("velocity", "position")))


@dataclass(frozen=True, eq=False)
class Residual:
    """An error of the re-identified plain axis, named by `label`, and what it may be drawn over, all of shape (n,)."""

    label: str
    error: np.ndarray
    over: dict[str, np.ndarray]
    used: np.ndarray
    comparison: Comparison

    @property
    def forward(self) -> np.ndarray:
        """Whether the axis moves in the positive direction."""
        return self.over["velocity"] > 0


def moves() -> np.ndarray:
    """Position and velocity at the controller's rate: to and fro at each speed, with short rests."""
    rest = np.zeros(CONTROL_HZ // 10)
    parts = [rest]
    for speed, way in MOVES:
        for side in (1, -1):
            parts += [motion.velocity_profile(side * way, speed, 6.0, 0.02), rest]
    v = np.concatenate(parts)
    v = v[: v.size // LOG_TICKS * LOG_TICKS]
    return np.stack([np.cumsum(v) / CONTROL_HZ, v])


@cache
def setting(axis: str, sensors: tuple[str, ...], *, shaken: bool) -> draw.Setting:
    """The machine in which effects are hidden, on moves that show them, shaken where that is needed to see them."""
    drawn = draw.draw_setting(axis, sensors, np.random.default_rng(SEED))
    path = moves()
    force = np.zeros(path.shape[1])
    if shaken:
        shaking = drawn.motions["identification"][2]
        force[: shaking.size] = shaking[: force.size]
    machine = replace(drawn, motions=dict.fromkeys(draw.SECONDS, np.vstack([path, force])))
    plain = draw.simulate(machine, (), "identification", disturbed=False)
    peaks = {"force": plain.readings["F"], "deflection": plain.deflection}
    return replace(machine, travel={name: float(np.abs(x).max()) for name, x in peaks.items()})


def log_with(effect: str, signature: Signature) -> tuple[Log, dict[str, float]]:
    """A log of the machine with the effect, and the parameters of the plain axis."""
    machine = setting(signature.axis, signature.sensors, shaken=signature.shaken)
    hidden: tuple[laws.Effect, ...] = ()
    if not signature.lacking and signature.at != READING:
        drawn = laws.draw(effect, signature.at, np.random.default_rng(SEED))
        shaped = replace(drawn, numbers=drawn.numbers | signature.shape)
        hidden, _ = draw.tamed(machine, (draw.sized(machine, shaped, RATIO)[0],))
    run = draw.simulate(machine, hidden, "identification", disturbed=False)
    readings = draw.measured(machine, run.readings, "identification")
    if signature.at == READING and not signature.lacking:
        readings[READING] = np.roll(readings[READING], round(LATE * gap.RATE))
    force = symid.load_axis(signature.axis).drive.signal
    signals = {force if name == "F" else name: values for name, values in readings.items()}
    return Log.from_arrays(signals, sampling_period=1 / gap.RATE, source=effect), dict(machine.true)


def model(signature: Signature) -> Axis:
    """The plain axis, without the law that it lacks."""
    axis = symid.load_axis(signature.axis)
    if signature.lacking == DAMPING:
        undamped = (replace(e, damping=None) if isinstance(e, Spring) else e for e in axis.elements)
        return replace(axis, elements=tuple(undamped))
    kept = tuple(e for e in axis.elements if type(e).__name__ != signature.lacking)
    return replace(axis, elements=kept)


def turning_table() -> tuple[Axis, Log, dict[str, float]]:
    """A model of a table without weight, a log of it with a weight at its rim, and its values."""
    table = Body("table", inertia="J")
    laws = ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs")
    axis = Axis("table", (table, *laws), Drive("F", table), (Position("q", table),))
    values = {"J": 0.6, "Fv": 1.5, "Fs": 1.0}
    course = _TURNED * moves()[0, :: CONTROL_HZ // 2000]
    loop = Loop(2000.0, 0.6 * 60.0**2, 1.6 * 0.6 * 60.0, 1e-6, noise=0.05)
    signals = run(values | {"Gs": 4.0, "Gc": -2.0}, loop, course, Recorder(every=2), SEED).signals
    log = Log.from_arrays({name: signals[name] for name in ("q", "F")}, sampling_period=1e-3)
    return axis, log, values


@cache
def residual_of(effect: str) -> Residual:
    """Error of the re-identified plain axis on a log with the effect; for a late reading, of the true axis."""
    signature = signature_of(effect)
    if signature.at == "table":
        axis, log, true = turning_table()
    else:
        axis, (log, true) = model(signature), log_with(effect, signature)
    record = data_of(axis, (joined([log]), None), Recorded({}, held=None)).record
    start = {name: true[name] for name in axis.physical_parameters}
    begun = first_state(record, start)
    base = Fit(*begun) if effect == "sensor_delay" else fitted_axis(*begun)
    comparison = compared(record, None, [base], None)
    signals = signal_curves(comparison)
    time, rate = signals.time, 1 / (signals.time[1] - signals.time[0])
    over = {
        "time": time,
        "velocity": signals.velocity,
        "position": signals.position,
        "angle": signals.position,
        "drive force": signals.measured,
        "acceleration": np.gradient(signals.velocity) * rate,
        "change of force": np.gradient(signals.reidentified) * rate,
    }
    error = signals.measured - signals.reidentified
    if signature.at == READING:
        error = error_of_reading(comparison)
    if signature.at == "transmission":
        over["spring"], error = (np.interp(time, log.time, x) for x in spring_force(log, base.parameters))
    label, scale = signature.unit
    return Residual(label, scale * error, over, signals.compared, comparison)


def error_of_reading(comparison: Comparison) -> np.ndarray:
    """Measured less predicted further reading of the re-identified model, in the rows of the comparison's signals."""
    record, state = comparison.record, comparison.states[1]
    assert state is not None
    return record.rows(state.errors[1] * record.taper)[record.rows_in_log]


def spring_force(log: Log, p: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Deflection of a ball screw's spring, and its force beyond the best spring and damper, from both encoders."""
    low_pass = LowPass(120.0)
    qm, ql = (low_pass.apply(log[name], log.sampling_frequency) for name in ("qm", "ql"))
    v, a = derivatives(ql, log.sampling_period, 2)
    force, bent = -(p["Ml"] * a + p["Fvl"] * v), ql - qm
    columns = np.stack([bent, np.gradient(bent), np.ones_like(bent)], axis=1)
    return bent, force - columns @ np.linalg.lstsq(columns / 1e-6, force, rcond=None)[0] / 1e-6


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
    """One panel by its name."""
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
    """Draw the signature of an effect."""
    found = residual_of(effect)
    panels = signature_of(effect).panels
    with mpl.rc_context({**PLOT_STYLE, "svg.hashsalt": "symid"}):
        figure = Figure(figsize=(8.0, 2.6), layout="constrained")
        for axes, panel in zip(figure.subplots(1, len(panels)), panels, strict=True):
            draw_panel(axes, found, panel)
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=8)
        figure.savefig(file, dpi=90, metadata={"Software": None})


def main() -> None:
    """Draw the signatures of the named effects, or of all."""
    for effect in sys.argv[1:] or dict.fromkeys(known.name for known in LIBRARY):
        picture(effect, FOLDER / f"{effect}.png")
        print(f"{effect}.png")


if __name__ == "__main__":
    main()
