"""Diagnoses of real logs by models that lack something, beside what is published of these machines.

EMPS by models without friction, with viscous friction only and with the published symmetric model, and its log with
pulses by the model identified on the other one; the bench of two motors by a rigid model and by the flexible one, whose
resonances another route gives in benchmarks/motor_bench.py; the pendulum by models without and with friction. Gaps are
measured on the machine's other log. Each case: the verdict, the gap in steps, what was found, what was considered
next, and what is published.

Usage: python -m benchmarks.diagnosis.real [CASE ...]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import symid
from benchmarks.emps import SYMMETRIC
from benchmarks.emps import read as read_emps
from benchmarks.motor_bench import read as read_bench
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, UnknownZero, ViscousFriction
from symid.arrays import FloatArray
from symid.axis import PendulumWeight
from symid.diagnosis import Diagnosis, Level, diagnose

DATA = Path(__file__).parents[2] / "data"
PENDULUM = DATA / "dfki_simple_pendulum"
Values = dict[str, float]


@dataclass(frozen=True)
class Case:
    """A diagnosis of a real log.

    Parameters
    ----------
    name : str
        Short name for the command line.
    model : str
        What the model holds.
    published : str
        What is known of the machine.
    axis : Axis
        The model.
    logs : tuple of Log
        For identification and for validation.
    nominal : dict of str to float
        Values of the simulation.
    """

    name: str
    model: str
    published: str
    axis: Axis
    logs: tuple[Log, Log]
    nominal: Values

    def found(self) -> Diagnosis:
        """The diagnosis."""
        return diagnose(self.axis, self.logs[0], validation=self.logs[1], nominal=self.nominal)


def identified(axis: Axis, log: Log, *measured: str) -> Values:
    """Values of a model by weighted least squares on the log: a simulation as well adjusted as its structure allows."""
    return symid.identify(symid.derive(axis, measured or None), log, examine=False).physical_parameters


def emps() -> Iterator[Case]:
    """The electro-mechanical positioning system."""
    axis = symid.load_axis("emps")
    viscous, coulomb, offset = axis.laws
    plain, pulses = (read_emps("emps", f"DATA_EMPS{end}.mat") for end in ("", "_PULSES"))
    friction = "Coulomb 20.4 N, viscous 203.5 N s/m, offset -3.2 N; by direction 166.7 and 240.4 N s/m, 20.1 and 20.6 N"
    for name, model, lacking in (
        ("emps-frictionless", "mass alone", (viscous, coulomb, offset)),
        ("emps-viscous", "mass and viscous friction", (coulomb, offset)),
    ):
        bare = axis.without(*lacking)
        yield Case(name, model, friction, bare, (plain, pulses), identified(bare, plain))
    published = {name: SYMMETRIC[name] for name in axis.physical_parameters}
    yield Case(
        "emps-symmetric",
        "mass, viscous and Coulomb friction, offset, published values",
        "asymmetric friction: 166.7 and 240.4 N s/m (half the difference -36.9), 20.1 and 20.6 N (-0.24); it lowers "
        "the error from 4.08 to 3.11 % on this log",
        axis,
        (plain, pulses),
        published,
    )
    yield Case(
        "emps-pulses",
        "as before, published values of the other log",
        "error 5.98 % instead of 4.08 %; the authors suspect a flexibility that the pulses excite",
        axis,
        (pulses, plain),
        published,
    )


def bench() -> Iterator[Case]:
    """Two motors joined by a flexible coupling, seen from the driven motor, then from both."""
    both = (read_bench("A"), read_bench("B"))
    driven = tuple(Log(log.source, log.start, log.sampling_period, _only(log, "iq", "qm")) for log in both)
    motor = Body("motor", inertia="J")
    friction = (ViscousFriction(motor, "Fv"), CoulombFriction(motor, "Fs"))
    rigid = Axis(
        "motor_bench_rigid", (motor, *friction), Drive("iq", motor, unit="A"), (Position("qm", motor),)
    )
    yield Case(
        "bench-rigid",
        "one inertia with friction, motor encoder",
        "antiresonance 53 Hz and resonance 77 Hz in the authors' figures; 53.7 and 75.7 Hz from the responses of both "
        "encoders (benchmarks/motor_bench.py)",
        rigid,
        (driven[0], driven[1]),
        identified(rigid, driven[0]),
    )
    flexible = symid.load_axis("motor_bench")
    left = "nonlinear distortions 27 dB above the noise between 11 and 40 Hz (FdiTools on these logs); no parameters"
    yield Case(
        "bench-flexible",
        "two inertias, both encoders",
        left,
        flexible,
        both,
        identified(flexible, both[0], "qm", "ql"),
    )
    hidden = flexible.without(*(law for law in flexible.laws if isinstance(law, UnknownZero)))
    yield Case(
        "bench-motor-only",
        "two inertias, motor encoder",
        left,
        hidden,
        (driven[0], driven[1]),
        identified(hidden, driven[0]),
    )


def _only(log: Log, *names: str) -> dict[str, FloatArray]:
    return {name: log[name] for name in names}


def pendulum() -> Iterator[Case]:
    """The torque-limited pendulum, swung up twice."""
    body = Body("pendulum", inertia="J")
    weight, viscous, coulomb = (
        PendulumWeight(body, "ml"),
        ViscousFriction(body, "Fv"),
        CoulombFriction(body, "Fc"),
    )
    parts = Drive("tau", body), (Position("q", body),)
    axis = Axis("pendulum", (body, weight, viscous, coulomb), *parts)
    logs = tuple(
        symid.read_axis_log(
            axis,
            PENDULUM / f"control_method_{method}__data_measured.csv",
            columns={"t": "time", "q": "position", "tau": "torque"},
        )
        for method in ("ddp", "direct_collocation")
    )
    published = (
        "weighed m l 0.304 kg m and about J 0.147 kg m^2; the authors' fit J 0.0626, m l 0.102, Fv 0.047, Fc 0.184, "
        "offset -0.076"
    )
    for name, model, lacking in (
        ("pendulum-frictionless", "inertia and weight", (viscous, coulomb)),
        ("pendulum-friction", "inertia, weight, viscous and Coulomb friction", ()),
    ):
        part = axis.without(*lacking)
        yield Case(name, model, published, part, (logs[0], logs[1]), identified(part, logs[0]))


MACHINES: dict[str, Callable[[], Iterator[Case]]] = {"emps": emps, "bench": bench, "pendulum": pendulum}


def modes(found: Diagnosis) -> Iterator[tuple[float, float]]:
    """Antiresonance and resonance, Hz, of each flexible mode found at the driven body.

    The mass m of the mode on its spring has the frequency f while the driven body stands, the antiresonance. The
    declared mass M is the total one, so that both swing against each other at f sqrt(M / (M - m)).
    """
    body = found.axis.free_bodies[0]
    total = next(p.explained for p in found.parameters if p.name in (body.mass, body.inertia))
    for effect in found.effects:
        if effect.effect == "flexible_mode":
            mass, frequency = effect.parameters["m"].value, effect.parameters["f"].value
            yield frequency, frequency * math.sqrt(total / (total - mass)) if mass < total else math.nan


def print_case(case: Case, found: Diagnosis, seconds: float) -> None:
    """Print everything of a case."""
    print(f"\n=== {case.name}: {case.model} ({seconds:.1f} s)\n{found.verdict}: {found.sentence}")
    print_gap(found)
    for effect in found.effects:
        values = ", ".join(f"{n} {p.value:.4g} ± {p.std:.2g} {p.unit}" for n, p in effect.parameters.items())
        doubt = "".join(f", or {name} at {at}" for name, at in effect.indistinguishable_from)
        print(f"  found {effect.effect} at {effect.at}{doubt} ({effect.probability:.2f}): {values}")
    for antiresonance, resonance in modes(found):
        print(f"  a mode with antiresonance {antiresonance:.2f} Hz and resonance {resonance:.2f} Hz")
    for other in found.alternatives[:3]:
        print(
            f"  considered {other.effect} at {other.at} ({other.probability:.2f}), gain {other.log_likelihood:.0f}"
        )
    for change in found.parameters:
        moved = " absorbed what was missing" if change.absorbed else ""
        print(f"  {change.name} {change.reidentified:.5g} -> {change.explained:.5g} {change.unit}{moved}")
    for fault in found.faults:
        print(f"  {fault}")
    print(f"  published: {case.published}")


def print_gap(found: Diagnosis) -> None:
    """Print the gap in steps."""
    gap = found.gap
    names = [effect.effect for effect in found.effects]
    steps = [(f"with {name}", level) for name, level in zip(names, gap.steps, strict=True)]
    rows: list[tuple[str, Level | None]] = [
        ("nominal", gap.nominal),
        ("re-identified", gap.reidentified),
        *steps,
    ]
    for name, level in (*rows, ("noise", gap.noise_floor)):
        if level is not None:
            times = level.rms / gap.noise_floor.rms
            print(
                f"  {name:32}{level.rms:10.4g} {gap.unit:4}{100 * level.relative:9.3f} %{times:9.1f} x noise"
            )


def main() -> None:
    """Diagnose all logs, or those named."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", help="names, or their beginnings [all]")
    wanted = tuple(parser.parse_args().cases)
    for machine, cases in MACHINES.items():
        if wanted and not any(name.startswith(machine) for name in wanted):
            continue
        for case in cases():
            if wanted and not case.name.startswith(wanted):
                continue
            begin = time.perf_counter()
            found = case.found()
            print_case(case, found, time.perf_counter() - begin)


if __name__ == "__main__":
    main()
