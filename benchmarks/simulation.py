"""Speed and accuracy of the simulation engine beside scipy's solve_ivp, on a mass with spring and Coulomb friction.

solve_ivp is restarted at every sample (the drive force is held) and at every zero of the velocity, which it locates as
an event: the only way in which it keeps its accuracy with friction that sticks. Run: python benchmarks/simulation.py
"""

from __future__ import annotations

import time

import numpy as np
from scipy.integrate import solve_ivp

from symid import Axis, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction, load_axis
from symid.simulation import Engine, plant_of, simulate, trapezoids, tuned_cascade

STEP = 1 / 4000
M, K, FV, FS = 2.0, 500.0, 4.0, 6.0


def stick_slip_axis() -> Axis:
    """Mass on a spring with viscous and Coulomb friction."""
    body = Body("slide", mass="M")
    elements = (body, Spring("spring", body, "K"), ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"))
    return Axis("stick_slip", elements, Drive("F", body), (Position("q", body),))


def by_engine(forces: np.ndarray) -> np.ndarray:
    """Displacement at every sample, by symid."""
    engine = Engine(plant_of(stick_slip_axis(), {"M": M, "K": K, "Fv": FV, "Fs": FS}))
    found = np.zeros(forces.size)
    for k, force in enumerate(forces):
        engine.advance(float(force), STEP)
        found[k] = engine.state[0]
    return found


def by_solve_ivp(forces: np.ndarray, tolerance: float) -> np.ndarray:
    """Displacement at every sample, by DOP853 with events."""
    state, found = np.zeros(2), np.zeros(forces.size)
    for k, force in enumerate(forces):
        left = STEP
        while left > 1e-16:
            pull = force - K * state[0]
            if state[1] == 0 and abs(pull) <= FS:
                break
            sign = np.sign(state[1]) if state[1] else np.sign(pull)
            state, made = _until_rest(state, float(force), float(sign), left, tolerance)
            left -= made
        found[k] = state[0]
    return found


def _until_rest(
    state: np.ndarray, force: float, sign: float, left: float, tolerance: float
) -> tuple[np.ndarray, float]:
    def motion(_: float, z: np.ndarray) -> list[float]:
        return [z[1], (force - K * z[0] - FV * z[1] - FS * sign) / M]

    def rest(_: float, z: np.ndarray) -> float:
        return float(sign * z[1] + (1e-18 if sign * z[1] >= 0 else 0))

    rest.terminal, rest.direction = True, -1  # type: ignore[attr-defined]  # how solve_ivp takes them
    run = solve_ivp(motion, (0, left), state, "DOP853", rtol=tolerance, atol=tolerance * 1e-3, events=rest)
    end = run.y[:, -1].copy()
    if run.status == 1:
        end[1] = 0.0
    return end, float(run.t[-1])


def main() -> None:
    """Print accuracy and steps per second of both, and of a closed loop."""
    forces = 15 * np.sin(2 * np.pi * 0.9 * STEP * np.arange(8000))
    reference = by_solve_ivp(forces, 1e-13)
    print(f"{'stick and slip, open loop':28} {'steps/s':>10} {'largest error':>14}")
    speeds = {}
    for name, method in (
        ("symid", by_engine),
        ("solve_ivp, rtol 1e-6", lambda f: by_solve_ivp(f, 1e-6)),
        ("solve_ivp, rtol 1e-10", lambda f: by_solve_ivp(f, 1e-10)),
    ):
        begin = time.perf_counter()
        found = method(forces)
        speeds[name] = forces.size / (time.perf_counter() - begin)
        print(f"{name:28} {speeds[name]:10.0f} {np.abs(found - reference).max():11.1e} m")
    print(
        f"ratio to solve_ivp, rtol 1e-10: {speeds['symid'] / speeds['solve_ivp, rtol 1e-10']:.0f} (aim 100)"
    )
    axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
    path = trapezoids([0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=STEP / 4)
    begin = time.perf_counter()
    simulate(axis, values, path, tuned_cascade(plant_of(axis, values), "q"))
    print(f"closed loop of rigid_1m: {path.n_samples / (time.perf_counter() - begin):.0f} steps/s")


if __name__ == "__main__":
    main()
