"""Tracking errors of simulated machines before and after a diagnosis, on a held-out log.

EMPS under its published cascade (Kpp 160.18 1/s, Kpv 243.45 V s/m times 35.15 N/V) along its logged reference, each of
its two logs held out once, by the published symmetric model. The torque-limited pendulum along its logged desired
trajectory under its measured torque, with a slow observer, each of its two swings held out once, by a model without
friction and by the full one. For each case it prints the effects found, the measured tracking error, and the difference
of the simulated one from it with the nominal, the re-identified and the explained axis.

Usage: python -m benchmarks.diagnosis.motion [CASE ...] [--json FILE]
"""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from benchmarks.emps import SYMMETRIC
from benchmarks.options import parser_of
from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    PendulumWeight,
    Position,
    ViscousFriction,
    load_axis,
)
from symid.diagnosis import Diagnosis, MotionError, diagnose
from symid.simulation import Cascade

from .real import recordings
from .real.case import identified, log_of
from .real.recordings import DATA, EMPS_GAIN

CASCADE = Cascade("q", position_gain=160.18, velocity_gain=243.45 * EMPS_GAIN, integral_gain=0.0)
"""Of EMPS, from the machine's report."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A machine, two of its logs with their references, and its controller where that is known."""

    name: str  # short name for the command line
    axis: Axis  # the model
    nominal: dict[str, float]  # values of the simulation
    # training, held_out: for identification, and for the motion
    training: Log
    held_out: Log
    controller: Cascade | None = None  # published


def cases(names: list[str]) -> Iterator[Case]:
    """The cases whose names begin with one of those given; all of them without any."""
    for case in (*emps(), *pendulum()):
        if not names or any(case.name.startswith(name) for name in names):
            yield case


def emps() -> Iterator[Case]:
    """Either log, the other held out."""
    axis = load_axis("emps")
    logs = [emps_log(axis, name) for name in ("DATA_EMPS", "DATA_EMPS_PULSES")]
    nominal = {name: SYMMETRIC[name] for name in axis.physical_parameters}
    for name, (training, held_out) in (("emps", logs), ("emps-pulses", logs[::-1])):
        yield Case(
            name=name, axis=axis, nominal=nominal, training=training, held_out=held_out, controller=CASCADE
        )


def emps_log(axis: Axis, name: str) -> Log:
    """A log of EMPS with its reference."""
    reference = loadmat(DATA / "emps" / f"{name}.mat", variable_names=("qg",))["qg"]
    return with_reference(log_of(axis, recordings.emps(name)), np.asarray(reference, dtype=float).ravel())


def pendulum() -> Iterator[Case]:
    """Without friction and with it, either swing held out."""
    body = Body("pendulum", inertia="J")
    friction = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fc"))
    full = Axis(
        "pendulum", (body, PendulumWeight(body, "ml"), *friction), Drive("tau", body), (Position("q", body),)
    )
    methods = ("ddp", "direct_collocation")
    for model, axis in (("frictionless", full.without(*friction)), ("full", full)):
        for first, other in (methods, methods[::-1]):
            yield Case(
                name=f"pendulum-{model}-{first}",
                axis=axis,
                nominal=identified(axis, recordings.pendulum(first)),
                training=pendulum_log(axis, first),
                held_out=pendulum_log(axis, other),
            )


def pendulum_log(axis: Axis, method: str) -> Log:
    """A swing with its desired trajectory at its own times."""
    log = log_of(axis, recordings.pendulum(method))
    file = DATA / f"dfki_simple_pendulum/control_method_{method}__data_desired.csv"
    desired = np.genfromtxt(file, delimiter=",", names=True)
    return with_reference(log, np.interp(log.time, desired["time"], desired["position"]))


def with_reference(log: Log, reference: np.ndarray) -> Log:
    return replace(log, signals={**log.signals, "reference": reference})


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("cases", nargs="*", help="names, or their beginnings [all]")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table")
    given = parser.parse_args()
    rows = []
    for case in cases(given.cases):
        begun = time.process_time()
        found = diagnose(
            case.axis,
            case.training,
            validation=case.held_out,
            nominal=case.nominal,
            controller=case.controller,
        )
        print_case(case, found, time.process_time() - begun)
        rows.append(row_of(case, found))
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))


def row_of(case: Case, found: Diagnosis) -> dict[str, object]:
    """One line of the table: fits in per cent and errors in micrometres or microradians."""
    motion = found.gap.motion
    assert motion is not None
    return {
        "case": case.name,
        "verdict": found.verdict,
        "effects": [f"{effect.effect} at {effect.at}" for effect in found.effects],
        "driver": motion.driver,
        "tracking_rms": 1e6 * motion.tracking_rms,
        **{
            name: {"tracking_fit": error.tracking_fit, "position_rms": 1e6 * error.position_rms}
            for name, error in models(found)
        },
    }


def models(found: Diagnosis) -> list[tuple[str, MotionError]]:
    """Nominal, re-identified and explained axis."""
    motion = found.gap.motion
    assert motion is not None
    assert motion.nominal is not None
    return [
        ("nominal", motion.nominal),
        ("re-identified", motion.reidentified),
        *((f"+ {effect.effect}", step) for effect, step in zip(found.effects, motion.steps, strict=True)),
    ]


def print_case(case: Case, found: Diagnosis, seconds: float) -> None:
    """Effects found, and the motion with each model."""
    motion = found.gap.motion
    assert motion is not None
    gains = ", ".join(f"{name} {value:.5g}" for name, value in motion.gains.items())
    unit = f"u{motion.unit}"
    print(f"\n=== {case.name}: {found.verdict}, {seconds:.0f} s of processor time\n{found.sentence}")
    print(f"  held out {case.held_out.source}; {motion.driver} ({gains})")
    print(f"  measured tracking error {1e6 * motion.tracking_rms:.4g} {unit} rms")
    print(f"  {'model':30}  tracking fit  position fit  off by [{unit}]  at reversals [{unit}]")
    for name, error in models(found):
        if error.status != "ok":
            print(f"  {name:30}  failed: {error.message}")
            continue
        off, turning = 1e6 * error.position_rms, 1e6 * error.reversal_rms
        print(
            f"  {name:30}  {error.tracking_fit:10.2f} %  {error.position_fit:10.4f} %  {off:11.4g}  {turning:11.4g}"
        )
    if motion.explained.message:
        print(f"  not simulated: {motion.explained.message}")


if __name__ == "__main__":
    main()
