"""The cases: eight machines, each by models that lack something."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import symid
from benchmarks.emps import SYMMETRIC
from benchmarks.emps import read as read_emps
from benchmarks.motor_bench import read as read_bench
from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Log,
    PendulumWeight,
    Position,
    Spring,
    UnknownZero,
    ViscousFriction,
)

from . import recordings
from .case import Case, identified, log_of

_PENDULUM = recordings.DATA / "dfki_simple_pendulum"


def emps() -> Iterator[Case]:
    """The electro-mechanical positioning system."""
    axis = symid.load_axis("emps")
    viscous, coulomb, offset = axis.laws
    plain, pulses = (read_emps("emps", f"DATA_EMPS{end}.mat") for end in ("", "_PULSES"))
    friction = "Coulomb 20.4 N, viscous 203.5 N s/m, offset -3.2 N; by direction 166.7 and 240.4 N s/m, 20.1 and 20.6 N"
    for name, model, lacking, right in (
        ("emps-frictionless", "mass alone", (viscous, coulomb, offset), ("coulomb", "viscous")),
        ("emps-viscous", "mass and viscous friction", (coulomb, offset), ("coulomb",)),
    ):
        bare = axis.without(*lacking)
        yield Case(
            name=name,
            model=model,
            published=friction,
            right=tuple((f"{kind}_friction", "motor") for kind in right),
            axis=bare,
            logs=(plain,),
            validation=pulses,
            nominal=identified(bare, plain),
        )
    published = {name: SYMMETRIC[name] for name in axis.physical_parameters}
    yield Case(
        name="emps-symmetric",
        model="mass, viscous and Coulomb friction, offset, published values",
        published="asymmetric friction: 166.7 and 240.4 N s/m (half the difference -36.9), 20.1 and 20.6 N (-0.24); it "
        "lowers the error from 4.08 to 3.11 % on this log",
        right=(("asymmetric_friction", "motor"),),
        axis=axis,
        logs=(plain,),
        validation=pulses,
        nominal=published,
    )
    yield Case(
        name="emps-pulses",
        model="as before, published values of the other log",
        published="error 5.98 % instead of 4.08 %; the authors suspect a flexibility that the pulses excite",
        right=(("flexible_mode", "motor"), ("asymmetric_friction", "motor")),
        axis=axis,
        logs=(pulses,),
        validation=plain,
        nominal=published,
    )


def bench() -> Iterator[Case]:
    """Two motors joined by a flexible coupling, seen from the driven motor, then from both."""
    both = (read_bench("A"), read_bench("B"))
    driven = tuple(_only(log, "iq", "qm") for log in both)
    body = Body("motor", inertia="J")
    friction = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"))
    rigid = Axis("motor_bench_rigid", (body, *friction), Drive("iq", body, unit="A"), (Position("qm", body),))
    yield Case(
        name="bench-rigid",
        model="one inertia with friction, motor encoder",
        published="antiresonance 53 Hz and resonance 77 Hz in the authors' figures; 53.7 and 75.7 Hz from the "
        "responses of both encoders (benchmarks/motor_bench.py)",
        right=(("flexible_mode", "motor"),),
        axis=rigid,
        logs=driven[:1],
        validation=driven[1],
        nominal=identified(rigid, driven[0]),
    )
    flexible = symid.load_axis("motor_bench")
    left = "nonlinear distortions 27 dB above the noise between 11 and 40 Hz (FdiTools on these logs); no parameters"
    yield Case(
        name="bench-flexible",
        model="two inertias, both encoders",
        published=left,
        axis=flexible,
        logs=both[:1],
        validation=both[1],
        nominal=identified(flexible, both[0], "qm", "ql"),
    )
    hidden = flexible.without(*(law for law in flexible.laws if isinstance(law, UnknownZero)))
    yield Case(
        name="bench-motor-only",
        model="two inertias, motor encoder",
        published=left,
        axis=hidden,
        logs=driven[:1],
        validation=driven[1],
        nominal=identified(hidden, driven[0]),
    )


def _only(log: Log, *names: str) -> Log:
    return Log(log.source, log.start, log.sampling_period, {name: log[name] for name in names})


def _rigid(name: str, unit: str, force: str, *, hangs: bool, coulomb: bool, position: str = "q") -> Axis:
    """A turning body with viscous friction, and weight and Coulomb friction as wanted."""
    body = Body("body", inertia="J")
    weight = (PendulumWeight(body, "ml"),) if hangs else ()
    dry = (CoulombFriction(body, "Fc"),) if coulomb else ()
    elements = (body, *weight, ViscousFriction(body, "Fv"), *dry)
    return Axis(name, elements, Drive(force, body, unit=unit), (Position(position, body),))


def pendulum() -> Iterator[Case]:
    """The torque-limited pendulum, swung up twice."""
    body = Body("pendulum", inertia="J")
    weight, viscous, coulomb = (
        PendulumWeight(body, "ml"),
        ViscousFriction(body, "Fv"),
        CoulombFriction(body, "Fc"),
    )
    axis = Axis("pendulum", (body, weight, viscous, coulomb), Drive("tau", body), (Position("q", body),))
    logs = tuple(
        symid.read_axis_log(
            axis,
            _PENDULUM / f"control_method_{method}__data_measured.csv",
            columns={"t": "time", "q": "position", "tau": "torque"},
        )
        for method in ("ddp", "direct_collocation")
    )
    published = (
        "weighed m l 0.304 kg m and about J 0.147 kg m^2; the authors' fit J 0.0626, m l 0.102, Fv 0.047, Fc 0.184, "
        "offset -0.076"
    )
    for name, model, lacking, right in (
        ("pendulum-frictionless", "inertia and weight", (viscous, coulomb), ("coulomb", "viscous")),
        ("pendulum-friction", "inertia, weight, viscous and Coulomb friction", (), ()),
    ):
        part = axis.without(*lacking)
        yield Case(
            name=name,
            model=model,
            published=published,
            right=tuple((f"{kind}_friction", "pendulum") for kind in right),
            axis=part,
            logs=logs[:1],
            validation=logs[1],
            nominal=identified(part, logs[0]),
        )


def robot() -> Iterator[Case]:
    """Axis 1 of a robot of six: as one body, then with its joint and the encoder behind the gear."""
    runs = {which: recordings.robot(which) for which in "ABC"}
    rigid = _rigid("robot_rigid", "N*m", "tau", hangs=False, coulomb=False, position="qm")
    own = {which: log_of(run, "qm", "tau") for which, run in runs.items()}
    yield Case(
        name="robot-viscous",
        model="one inertia and viscous friction, motor encoder",
        published="Coulomb 355 N m, viscous 2050 N m s/rad, offset 54 N m; the inertia depends on the pose of the "
        "other axes, 719 to 1690 kg m^2 within the runs",
        right=(("coulomb_friction", "body"),),
        axis=rigid,
        logs=(own["A"], own["C"]),
        validation=own["B"],
        nominal=identified(rigid, own["A"]),
    )
    logs = {which: log_of(run) for which, run in runs.items()}
    yield Case(
        name="robot-flexible",
        model="motor and arm joined by a spring, both encoders, published values",
        published="the encoder behind the gear is read 2.8 ms late, which is 91 % of the difference of the two; "
        "stiffness 4.6e6 N m/rad, backlash 3e-5 rad",
        right=(("sensor_delay", "ql"),),
        axis=_joint(),
        logs=(logs["A"], logs["C"]),
        validation=logs["B"],
        nominal=_PUBLISHED_JOINT,
    )


_PUBLISHED_JOINT = {
    "Jm": 609.0, "Fvm": 2050.0, "Fcm": 355.0, "Kt": 4.6e6, "Ft": 0.0, "Pt": 0.0, "Jl": 1000.0, "Fvl": 0.0,
}  # fmt: skip


def _joint() -> Axis:
    motor, arm = Body("motor", inertia="Jm"), Body("arm", inertia="Jl")
    gear = Between(first=motor, second=arm)
    spring = Spring("gear", gear, stiffness="Kt", damping="Ft")
    friction = ViscousFriction(motor, "Fvm"), CoulombFriction(motor, "Fcm"), ViscousFriction(arm, "Fvl")
    return Axis(
        "robot_flexible",
        (motor, arm, spring, UnknownZero(gear, "Pt"), *friction),
        Drive("tau", motor),
        (Position("qm", motor), Position("ql", arm)),
    )


def servo() -> Iterator[Case]:
    """A servo motor that swings a weight on a lever."""
    axis = _rigid("servo", "V", "u", hangs=True, coulomb=False)
    runs = {run: log_of(recordings.servo(run)) for run in ("10h28m32", "10h28m10", "10h29m04")}
    yield Case(
        name="servo-viscous",
        model="inertia, weight and viscous friction in units of voltage",
        published="the authors fit Coulomb, Stribeck and load-dependent friction (0.07 to 0.27 of the load)",
        right=(
            ("coulomb_friction", "body"),
            ("load_dependent_friction", "body"),
            ("stribeck_friction", "body"),
        ),
        axis=axis,
        logs=(runs["10h28m32"], runs["10h28m10"]),
        validation=runs["10h29m04"],
        nominal=identified(axis, runs["10h28m32"]),
    )


def motor() -> Iterator[Case]:
    """A direct-drive motor that turns slowly."""
    logs = {run: log_of(recordings.motor(run)) for run in ("nocomp_0", "nocomp_1")}
    for name, model, coulomb in (
        ("motor-viscous", "inertia and viscous friction in units of current", False),
        ("motor-friction", "inertia, viscous and Coulomb friction in units of current", True),
    ):
        axis = _rigid("motor", "A", "i", hangs=False, coulomb=coulomb)
        yield Case(
            name=name,
            model=model,
            published="cogging of orders 7, 14, 28, 36 and 12 a turn, strongest 7",
            right=(("cogging", "body"),),
            axis=axis,
            logs=(logs["nocomp_0"],),
            validation=logs["nocomp_1"],
            nominal=identified(axis, logs["nocomp_0"]),
        )


def shoulder() -> Iterator[Case]:
    """The shoulder of a double pendulum while its elbow stands still."""
    axis = _rigid("shoulder", "N*m", "tau", hangs=True, coulomb=False)
    run = recordings.double_pendulum("143906")
    first, last = (log_of(run.between(*part), "q", "tau") for part in ((0.0, 6.5), (6.5, 10.0)))
    yield Case(
        name="shoulder-viscous",
        model="inertia, weight and viscous friction",
        published="Coulomb 0.16 N m; a torque ripple of 126 waves a turn, 0.026 N m",
        right=(("coulomb_friction", "body"),),
        axis=axis,
        logs=(first,),
        validation=last,
        nominal=identified(axis, first),
    )


MACHINES: dict[str, Callable[[], Iterator[Case]]] = {
    "emps": emps,
    "bench": bench,
    "pendulum": pendulum,
    "robot": robot,
    "servo": servo,
    "motor": motor,
    "shoulder": shoulder,
}
