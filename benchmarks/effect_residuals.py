"""What the re-identified model leaves of a log in which an effect is hidden."""

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

import symid
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, Spring, ViscousFriction
from symid.diagnosis.findings.comparison import Comparison, compared
from symid.diagnosis.findings.curves import signal_curves
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.signal_processing import LowPass, derivatives

from .blind import draw, gap, laws, motion
from .blind.engine import CONTROL_HZ, LOG_TICKS
from .diagnosis.other_machines import Loop, Recorder, run

READING = "ql"
"""Further reading of the ball screw."""
DAMPING = "damping"
"""What a model lacks whose spring is declared without it."""
SEED, RATIO = 7, 50.0
LATE = 0.25e-3
"""Time by which a late reading is late, s: one sample of the logs of the blind cases."""
MOVES = ((0.4, 0.2), (0.01, 0.02), (0.2, 0.2), (0.04, 0.06), (0.5, 0.2), (0.1, 0.1))
"""Speed and way of the moves to and fro, m/s and m."""
_TURNED = 12.0
"""Angle of the table per metre of the other moves, rad/m."""


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
    record = data_of(axis, (joined([log]), None), Recording({}, held=None)).record
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
