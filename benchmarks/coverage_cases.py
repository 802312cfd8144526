"""Rows of `coverage_map`: settings, true logs, and logs with noise."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

import symid
from symid.simulation import multisine, plant_of, simulate, tuned_cascade

FloatArray = NDArray[np.float64]
ENGINE_RATE = 4000.0
SECONDS = {"rigid_1m": 10.0, "ballscrew_2m1s": 5.0, "direct_2m1s": 5.0}
CLOSED_LOOPS = {"rigid_1m": 0.03, "ballscrew_2m1s": 0.004}  # amplitude of the reference, m
VALUES: dict[str, dict[str, float]] = {
    "rigid_1m": {"M": 95.0, "Fv": 200.0, "Fs": 20.0},
    "ballscrew_2m1s": {
        "Mm": 80.0, "Fvm": 120.0, "Fsm": 0.0, "Kt": 6e5, "Ft": 700.0, "Ml": 100.0, "Fvl": 150.0
    },
    "direct_2m1s": {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 0.0},
}  # fmt: skip
LINES = {
    "rigid_1m": (0.4, 1.1, 2.9),
    "ballscrew_2m1s": (1.0, 2.0, 5.0, 9.0, 14.0),
    "direct_2m1s": tuple(np.arange(2.0, 71.0, 2.0)),
}


@dataclass(frozen=True)
class Case:
    """A row of the map; noise by signal, as a standard deviation, or as a step of an encoder if `in_steps`."""

    axis: str
    measured: tuple[str, ...]
    method: str
    rate: float
    cutoff: float | None
    decimation: int | None
    noise: tuple[tuple[str, float], ...]
    in_steps: bool = False
    filter_force: bool = True
    moved: int = 0

    def __str__(self) -> str:
        noise = " ".join(f"{name} {size:g}" for name, size in self.noise)
        kind = " step" if self.in_steps else ""
        sides = "" if self.filter_force else ", motion only"
        cutoff = "chosen" if self.cutoff is None else f"{self.cutoff:g}"
        return (
            f"{','.join(self.measured)} {self.method} {self.rate:g} Hz, {cutoff}/{self.decimation or '-'}{sides}, "
            f"{noise}{kind}"
        )


@cache
def controller_of(axis: str) -> symid.simulation.Cascade:
    declared = symid.load_axis(axis)
    return tuned_cascade(plant_of(declared, VALUES[axis]), declared.sensors[0].signal)


@cache
def true_log(axis: str, rate: float) -> symid.Log:
    """Log without noise: a closed loop, or exact periodic motion for direct_2m1s."""
    if axis in CLOSED_LOOPS:
        reference = multisine(
            LINES[axis],
            CLOSED_LOOPS[axis],
            sampling_period=1 / ENGINE_RATE,
            quantity="position",
            seconds=SECONDS[axis],
        )
        log = simulate(
            symid.load_axis(axis), VALUES[axis], reference, controller_of(axis), frequency_hz=rate
        ).log
        return log.window(0, int(SECONDS[axis] * rate))
    return periodic_log(rate)


def periodic_log(rate: float) -> symid.Log:
    """Exact steady state of the linear direct_2m1s under a sum of sines of force."""
    p = VALUES["direct_2m1s"]
    t = np.arange(int(SECONDS["direct_2m1s"] * rate)) / rate
    M, K = np.diag([p["Ms"], p["Mm"]]), np.diag([p["Ks"], 0.0])
    C = np.array([[p["Fvs"] + p["Fvm"], -p["Fvm"]], [-p["Fvm"], p["Fvm"]]])
    phases = np.random.default_rng(1).uniform(0, 2 * np.pi, len(LINES["direct_2m1s"]))
    signals = {name: np.zeros(t.size) for name in ("q2", "ddq1", "Fm")}
    for frequency, phase in zip(LINES["direct_2m1s"], phases, strict=True):
        s, force = 2j * np.pi * frequency, 200.0 * np.exp(1j * phase)
        x = linalg.solve(M * s**2 + C * s + K, np.array([-1.0, 1.0]) * force)
        for name, amplitude in (("q2", x[1] - x[0]), ("ddq1", s**2 * x[0]), ("Fm", force)):
            signals[name] += (amplitude * np.exp(s * t)).real
    return symid.Log.from_arrays(signals, sampling_period=1 / rate)


def noisy_log(case: Case, random: np.random.Generator) -> symid.Log:
    """The true log with noise, and with the force recorded `moved` samples late."""
    true = true_log(case.axis, case.rate)
    signals = dict(true.signals)
    force = symid.load_axis(case.axis).drive.signal
    for name, size in case.noise:
        if case.in_steps and name != force:
            # an encoder's zero lies anywhere between two of its steps
            signals[name] = size * np.round(signals[name] / size + random.uniform(-0.5, 0.5))
        else:
            signals[name] = signals[name] + size * random.standard_normal(true.n_samples)
    if case.moved:
        ahead, behind = max(case.moved, 0), max(-case.moved, 0)
        n = true.n_samples - ahead - behind
        signals = {
            name: x[behind : behind + n] if name == force else x[ahead : ahead + n]
            for name, x in signals.items()
        }
    return symid.Log.from_arrays(signals, sampling_period=true.sampling_period)


def preparation_of(case: Case) -> symid.Preparation:
    """Settings of a case; a force that the simulated controller holds acts half a sample late."""
    force = symid.load_axis(case.axis).drive.signal
    late = {force: -0.5 / ENGINE_RATE} if case.axis in CLOSED_LOOPS else {}
    return symid.Preparation(
        cutoff_hz=case.cutoff, decimation=case.decimation, filter_force=case.filter_force, late=late
    )


def true_values(case: Case) -> FloatArray:
    """Minimal and physical parameters of the true axis."""
    model, values = symid.load_generated(case.axis, case.measured), VALUES[case.axis]
    physical = np.array([values[name] for name in model.physical_units])
    return np.concatenate([model.minimal_parameters(*physical), physical])


def names_of(case: Case) -> tuple[str, ...]:
    """Names of the minimal and physical parameters."""
    model = symid.load_generated(case.axis, case.measured)
    return (*model.minimal_units, *model.physical_units)


def cases(quick: bool) -> Iterator[Case]:
    """Settings of the rows of the map."""
    force, white, steps = (("F", 20.0),), (("F", 1.0), ("q", 5e-6)), (("F", 1.0), ("q", 2e-5))
    rigid = Case("rigid_1m", ("q",), "wls", 1000.0, 20.0, None, force)
    yield rigid
    yield replace(rigid, cutoff=60.0, noise=white)
    if quick:
        return
    settings = [(1000.0, cutoff, None) for cutoff in (None, 20.0, 60.0)]
    settings += [(1000.0, 20.0, 1), (1000.0, 60.0, 1), (250.0, 20.0, None), (250.0, 10.0, 1)]
    for rate, cutoff, decimation in settings:
        for noise, in_steps in ((force, False), (white, False), (steps, True)):
            case = replace(rigid, rate=rate, cutoff=cutoff, decimation=decimation)
            case = replace(case, noise=noise, in_steps=in_steps)
            if case not in (rigid, replace(rigid, cutoff=60.0, noise=white)):
                yield case
    for cutoff, noise in ((20.0, force), (60.0, force), (20.0, white)):
        yield replace(rigid, cutoff=cutoff, noise=noise, filter_force=False)
    for cutoff in (20.0, 60.0):
        for noise, in_steps in ((force, False), (white, False), (steps, True)):
            yield replace(rigid, method="iv", cutoff=cutoff, noise=noise, in_steps=in_steps)
    flexible = Case("direct_2m1s", ("q2",), "wls", 4000.0, 100.0, None, (("Fm", 5.0),))
    for measured in (("q2",), ("q2", "ddq1")):
        for rate, cutoff in ((4000.0, 100.0), (4000.0, 200.0), (1000.0, 100.0)):
            for noise in ((("Fm", 20.0),), (("Fm", 5.0), ("q2", 1e-8), ("ddq1", 0.01))):
                chosen = tuple(pair for pair in noise if pair[0] in ("Fm", *measured))
                yield replace(flexible, measured=measured, rate=rate, cutoff=cutoff, noise=chosen)


def timing_cases(quick: bool) -> Iterator[Case]:
    """Rows whose force is moved by a sample to either side."""
    rigid = Case("rigid_1m", ("q",), "wls", 1000.0, 20.0, None, (("F", 20.0),), moved=1)
    yield rigid
    if quick:
        return
    yield replace(rigid, moved=-1)
    yield replace(rigid, cutoff=None, noise=(("F", 1.0), ("q", 2e-5)), in_steps=True)
    yield replace(rigid, cutoff=60.0, noise=(("F", 1.0), ("q", 1e-6)), moved=-1)
    yield replace(rigid, rate=250.0, noise=(("F", 1.0), ("q", 1e-6)))
    for measured in (("q2",), ("q2", "ddq1")):
        flexible = Case("direct_2m1s", measured, "wls", 4000.0, 100.0, None, (("Fm", 20.0),), moved=1)
        yield flexible
        yield replace(flexible, moved=-1)
