"""Each effect of the library as an element of an axis, from its declaration to the axis that a diagnosis writes.

For each element: how fast its closed loop runs under a controller of 16 kHz, in multiples of real time (processor), and
how far one step of the engine in a sample is from eight, in um; whether the regressor holds it; of a machine that has
it, the effect that a diagnosis of all effects names first, and the error of the position on another run, of the
re-identified and of the written axis read from its file: under the controller, and under the measured force alone with
an observer; how far the effect on the motion under a given force is off in exported C code, compiled in an
FMU, relative to the effect; what MuJoCo's format lacks; whether the schematic and the catalogue show it.

Usage: python -m benchmarks.effect_elements [EFFECT ...]
"""

import sys
import tempfile
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import fmpy
import fmpy.fmi2
import numpy as np

from symid import ActuatorDelay, Axis, PayloadChange, derive, load_axis, write_axis
from symid.diagnosis import Diagnosis, diagnose, explained_axis
from symid.diagnosis.in_motion.declared import ExplainedAxis
from symid.diagnosis.in_motion.identified_motion import identified_motion
from symid.diagnosis.in_motion.replayed import without_noise
from symid.errors import SymidError
from symid.export import mjcf, write_fmu
from symid.report.figures.schematic import schematic_svg
from symid.report.pages.diagnosis_page import effect_catalogue
from symid.simulation import OpenLoop, Trajectory, simulate

from .effect_machines import KINDS, LOOP, PERIOD, Kind, machine, path

CONTROL_HZ = 16_000


class Row(NamedTuple):
    """What was found of one kind."""

    kind: Kind
    speed: float
    steps: float
    in_regressor: bool
    first: str
    under_loop: tuple[float, float]  # of the re-identified axis, of the written one, m
    under_force: tuple[float, float]
    in_fmu: float
    lost: str
    drawn: bool
    catalogued: bool


def row(kind: Kind) -> Row:
    speed, steps = run_speed(kind)
    found = diagnose(
        kind.plain,
        machine(kind.axis, kind.of(kind.axis), 1, kind.size),
        nominal=kind.of(kind.plain),
        held=True,
        controller=LOOP,
    )
    under_loop, under_force = moved(kind, found)
    return Row(
        kind,
        speed,
        steps,
        in_regressor(kind),
        found.effects[0].effect if found.effects else found.verdict,
        under_loop,
        under_force,
        in_fmu(kind),
        "; ".join(
            loss for loss in mjcf(without_noise(kind.axis), kind.of(kind.axis)).losses if "left out" in loss
        ),
        schematic_svg(kind.axis) != schematic_svg(kind.plain),
        kind.effect in effect_catalogue(),
    )


def run_speed(kind: Kind) -> tuple[float, float]:
    """Multiples of real time, and the distance from eight steps in a sample, in m."""
    axis, values, reference = without_noise(kind.axis), kind.of(kind.axis), path(2, CONTROL_HZ, kind.size)
    simulate(axis, values, path(2, size=kind.size), LOOP)  # the first loop of a kind is compiled
    begun = time.process_time()
    once = simulate(axis, values, reference, LOOP).log["q"]
    took = time.process_time() - begun
    finely = simulate(axis, values, reference, LOOP, steps=8).log["q"]
    return float(reference.time[-1]) / took, rms(once - finely)


def moved(kind: Kind, found: Diagnosis) -> tuple[tuple[float, float], tuple[float, float]]:
    """Errors of the position on another run before and after the effects found, under the controller and the force."""
    before = ExplainedAxis(kind.plain, {p.name: p.reidentified for p in found.parameters}, ())
    try:
        after = written(explained_axis(found))
    except SymidError:
        after = before
    log = machine(kind.axis, kind.of(kind.axis), 2, kind.size)
    alone = replace(log, signals={name: x for name, x in log.signals.items() if name != "reference"})
    under_loop = [
        rms(log["q"] - simulate(without_noise(one.axis), one.values, path(2, size=kind.size), LOOP).log["q"])
        for one in (before, after)
    ]
    motions = [
        identified_motion(one.axis, one.values, alone, acting_late(one.axis)).motions
        for one in (before, after)
    ]
    under_force = [motion[0].explained.position_rms if motion else np.nan for motion in motions]
    return (under_loop[0], under_loop[1]), (under_force[0], under_force[1])


def acting_late(axis: Axis) -> dict[str, float]:
    """Time by which the force is recorded late, negative: it is held from sample to sample, and may be delayed."""
    delays = (item.seconds for item in axis.imperfections if isinstance(item, ActuatorDelay))
    return {"F": -PERIOD / 2 - sum(delays)}


def written(explained: ExplainedAxis) -> ExplainedAxis:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "written.py"
        write_axis(explained.axis, file)
        return replace(explained, axis=load_axis(str(file)))


def in_regressor(kind: Kind) -> bool:
    """Whether the regressor of the derived model has a parameter of the element."""
    try:
        there, here = (
            str(derive(axis, [s.signal for s in axis.sensors])) for axis in (kind.axis, kind.plain)
        )
    except SymidError:
        return False
    return there != here


def in_fmu(kind: Kind) -> float:
    """How far the effect on the motion under a given force is in an exported unit from that in the simulation."""
    if isinstance(kind.element, PayloadChange):
        kind = replace(kind, element=replace(kind.element, time=0.3))
    (unit, simulated), (without_unit, without) = (
        both_motions(axis, tuple(kind.of(axis).items())) for axis in (kind.axis, kind.plain)
    )
    return rms((unit - without_unit) - (simulated - without)) / rms(simulated - without)


@cache
def both_motions(axis: Axis, values: tuple[tuple[str, float], ...]) -> tuple[np.ndarray, np.ndarray]:
    """Position under a given force by the exported unit, and by the simulation."""
    t = PERIOD * np.arange(700)
    force = 400.0 * np.sin(2 * np.pi * 3.0 * t) + 120.0 * np.sin(2 * np.pi * 7.0 * t)
    rest = Trajectory(0 * t, 0 * t, 0 * t, PERIOD, "rest")
    axis = without_noise(axis)
    simulated = simulate(axis, dict(values), rest, OpenLoop(force), steps=4).log["q"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{axis.name}.fmu"
        write_fmu(axis, dict(values), file)
        return run_unit(file, force), simulated


def run_unit(file: Path, force: np.ndarray) -> np.ndarray:
    """Position at the samples of a force that is held from one to the next."""
    description = fmpy.read_model_description(str(file))
    places = {v.name: v.valueReference for v in description.modelVariables}
    unit = fmpy.fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="axis",
    )
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    read = []
    for k, value in enumerate(force):
        read.append(unit.getReal([places["q"]])[0])
        unit.setReal([places["F"]], [float(value)])
        unit.doStep(currentCommunicationPoint=k * PERIOD, communicationStepSize=PERIOD)
    unit.terminate()
    unit.freeInstance()
    return np.array(read)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


HEAD = (
    f"{'element':26} {'speed':>6} {'step':>7} {'regr.':5}  {'loop [um]':>17}  {'force [um]':>17}  "
    f"{'FMU off':>8}  drawn  listed  named first, lacking in MuJoCo"
)


def line(found: Row) -> str:
    numbers = [f"{found.speed:6.0f} {1e6 * found.steps:7.4f} {'yes' if found.in_regressor else 'no':5}"]
    for before, after in (found.under_loop, found.under_force):
        numbers.append(f"{1e6 * before:8.2f} {1e6 * after:8.2f}")
    shown = [f"{'yes' if one else 'NO':6}" for one in (found.drawn, found.catalogued)]
    first = "" if found.first == found.kind.effect else f"NOT {found.kind.effect} BUT {found.first} "
    name = type(found.kind.element).__name__
    return f"{name:26} {'  '.join(numbers)}  {found.in_fmu:8.1%}  {' '.join(shown)}  {first}{found.lost}".rstrip()


def main() -> None:
    wanted = sys.argv[1:]
    print(HEAD)
    for kind in KINDS:
        if not wanted or kind.effect in wanted:
            print(line(row(kind)), flush=True)


if __name__ == "__main__":
    main()
