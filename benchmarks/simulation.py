"""Speed and accuracy of closed loops with Coulomb friction: symid, scipy's solve_ivp and MuJoCo's engine.

Two axes follow jerk-limited trapezoids under the same cascade. solve_ivp is restarted at every sample of the
controller, since its force is held, and at the events at which friction sticks or breaks loose; otherwise it loses its
accuracy. MuJoCo runs with its default integrator and soft friction at the same step, once with the controller in a
Python loop, and once without controller in its own loop in C. It is skipped if it is not installed. Times are
processor times, medians of alternating repetitions. Whole processes and loops that are simulated sample by sample
follow.

Usage: python -m benchmarks.simulation
"""

import importlib.util
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.installed import as_installed
from benchmarks.simulation_peers import Loop, Machine, by_mujoco, by_solve_ivp, direct, rigid, rolled_out

RATE = 4000.0
"""Rate of the controller where solve_ivp takes part, Hz."""
FINE = 16_000.0
"""Rate for the comparison with MuJoCo, Hz."""


@dataclass(frozen=True)
class Case:
    """An axis with values and a controlled sensor, and the same machine by hand."""

    axis: str
    values: dict[str, float]
    signal: str
    bandwidth_hz: float
    machine: Callable[..., Machine]

    def by_hand(self) -> Machine:
        """The equations of motion written down without symid."""
        return self.machine(**self.values)


CASES = (
    Case("rigid_1m", {"M": 100.0, "Fv": 80.0, "Fs": 40.0}, "q", 20.0, rigid),
    Case(
        "direct_2m1s",
        {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 80.0},
        "q2",
        10.0,
        direct,
    ),
)


def prepared(case: Case, rate: float):
    """Run of symid without arguments, and the same loop for the peers."""
    from symid import load_axis
    from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

    axis = load_axis(case.axis)
    path = trapezoids([0.05], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / rate)
    gains = tuned_cascade(plant_of(axis, case.values), case.signal, case.bandwidth_hz)
    loop = Loop(
        path.position,
        path.velocity,
        path.sampling_period,
        (gains.position_gain, gains.velocity_gain, gains.integral_gain),
    )
    return lambda: simulate(axis, case.values, path, gains), loop


def errors(case: Case, n_samples: int, found: dict[str, np.ndarray]) -> dict[str, float]:
    """Largest error of displacements over the first samples, against solve_ivp at its tightest."""
    _, loop = prepared(case, RATE)
    cut = Loop(loop.position[:n_samples], loop.velocity[:n_samples], loop.period, loop.gains)
    true = by_solve_ivp(case.by_hand(), cut, "DOP853", 1e-13)
    n = true.shape[1] // 2
    return {name: float(np.abs(states[:n_samples] - true)[:, :n].max()) for name, states in found.items()}


def seconds(calls: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Median processor time of each of some calls, run in turn; those that take long once."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for repetition in range(7):
        for name, call in calls.items():
            if repetition and times[name][0] > 2.0:
                continue
            begin = processor_time()
            call()
            times[name].append(processor_time() - begin)
    return {name: median(found) for name, found in times.items()}


def processor_time() -> float:
    """Of this process and those that it has run, s: other work on the machine does not count."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def beside_solve_ivp(case: Case) -> None:
    run, loop = prepared(case, RATE)
    machine, found = case.by_hand(), {"symid": run().states}

    def peer(method: str, tolerance: float) -> Callable[[], object]:
        name = f"solve_ivp, {method}, rtol {tolerance:g}"
        return lambda: found.update({name: by_solve_ivp(machine, loop, method, tolerance)})

    calls = {f"solve_ivp, {m}, rtol {t:g}": peer(m, t) for m, t in (("RK45", 1e-6), ("DOP853", 1e-10))}
    taken = seconds({"symid": run, **calls})
    accuracy = errors(case, loop.position.size, found)
    print(f"\n{case.axis}, closed loop, {loop.position.size} samples at {RATE:g} Hz")
    for name, time_taken in taken.items():
        ratio = time_taken / taken["symid"]
        speed = loop.position.size / time_taken
        print(f"  {name:30} {speed:10.0f} steps/s  error {accuracy[name]:.1e} m  {ratio:6.1f} x the time")


def beside_mujoco(case: Case) -> None:
    """Print steps per second and ratios, the distance of MuJoCo's soft friction, and times of whole processes."""
    run, loop = prepared(case, FINE)
    exact, machine = run(), case.by_hand()
    calls = {"symid, closed loop": run}
    if has_mujoco():
        calls["mujoco, controller in Python"] = lambda: by_mujoco(machine, loop)
        calls["mujoco, its own loop, forces given"] = lambda: rolled_out(machine, loop, exact.forces)
    print(f"\n{case.axis}, {loop.position.size} samples at {FINE:g} Hz")
    taken = seconds(calls)
    for name, time_taken in taken.items():
        speed, ratio = loop.position.size / time_taken, time_taken / taken["symid, closed loop"]
        print(f"  {name:36} {speed:10.0f} steps/s  {ratio:6.1f} x the time")
    if has_mujoco():
        distance = np.abs(by_mujoco(machine, loop) - exact.log[case.signal]).max()
        print(f"  mujoco is up to {distance:.1e} m from the exact motion")
    whole = whole_processes(case)
    print("  whole process: " + ", ".join(f"{name} {time_taken:.2f} s" for name, time_taken in whole.items()))
    if has_mujoco():
        gained = (taken["mujoco, controller in Python"] - taken["symid, closed loop"]) / loop.position.size
        ahead = loop.position.size + (whole["symid"] - whole["mujoco"]) / gained
        print(f"  from {ahead:.2g} samples on the whole process of symid ends first")


def whole_processes(case: Case) -> dict[str, float]:
    """Time of a process from start to end, derivation of the plant included."""
    _, loop = prepared(case, FINE)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "loop.npz"
        np.savez(
            file,
            values=list(case.values.values()),
            gains=loop.gains,
            position=loop.position,
            velocity=loop.velocity,
            period=loop.period,
        )
        commands = {"symid": ["benchmarks.simulation", case.axis]}
        if has_mujoco():
            commands["mujoco"] = ["benchmarks.simulation_peers", str(file)]
        run = partial(subprocess.run, check=True, env=as_installed(Path(folder) / "compiled"))
        calls = {name: partial(run, [sys.executable, "-m", *command]) for name, command in commands.items()}
        for call in calls.values():
            call()  # compiles its modules
        return seconds(calls)


def sample_by_sample() -> None:
    """Print steps per second where no blocks are possible: a quantised encoder, friction that falls with speed."""
    from symid import StribeckFriction, load_axis
    from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

    rigid = load_axis("rigid_1m")
    stribeck = rigid.with_effect(StribeckFriction(rigid.bodies[0], "dF", velocity=0.01))
    quantised = rigid.with_signal("q", noise=0.0, resolution=1e-7)
    noisy = rigid.with_signal("q", noise=1e-6)
    values = CASES[0].values
    path = trapezoids([0.05], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / FINE)
    gains = tuned_cascade(plant_of(quantised, values), "q")
    calls = {
        "quantised encoder": lambda: simulate(quantised, values, path, gains),
        "noisy encoder, friction never at rest": lambda: simulate(noisy, values, path, gains),
        "Stribeck friction": lambda: simulate(stribeck, {**values, "dF": 20.0}, path, gains),
    }
    print(f"\nrigid_1m sample by sample, {path.n_samples} samples at {FINE:g} Hz")
    for name, time_taken in seconds(calls).items():
        print(f"  {name:40} {path.n_samples / time_taken:10.0f} steps/s")


def dry_structure() -> None:
    """Speed with dry friction at motor and structure, whose joints turn every few samples under a noisy encoder."""
    from symid import CoulombFriction, load_axis
    from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

    base = load_axis("direct_2m1s")
    axis = base.with_effect(CoulombFriction(base.bodies[0], "Fss"))
    values = {**CASES[1].values, "Fss": 60.0}
    path = trapezoids([0.05], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / FINE)
    print(f"\ndirect_2m1s with dry friction of the structure, {path.n_samples} samples at {FINE:g} Hz")
    for noise in (0.0, 2e-7):
        noisy = axis.with_signal("q2", noise=noise)
        controller = tuned_cascade(plant_of(noisy, values), "q2", bandwidth_hz=10.0)
        (taken,) = seconds({"": partial(simulate, noisy, values, path, controller)}).values()
        print(f"  encoder noise {1e6 * noise:g} um: {path.duration / taken:6.1f} times real time")


def has_mujoco() -> bool:
    return importlib.util.find_spec("mujoco") is not None


def main() -> None:
    if len(sys.argv) > 1:
        prepared(next(case for case in CASES if case.axis == sys.argv[1]), FINE)[0]()
        return
    for case in CASES:
        beside_solve_ivp(case)
    for case in CASES:
        beside_mujoco(case)
    sample_by_sample()
    dry_structure()


if __name__ == "__main__":
    main()
