"""Closed loops of two axes with Coulomb friction by solve_ivp and by MuJoCo; run by `benchmarks.simulation`.

Written by hand from the equations of motion, without symid. `python -m benchmarks.simulation_peers REFERENCE.npz`
simulates the loop in that file by MuJoCo, as a process whose time includes the start-up.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Machine:
    """M x(2) + C x(1) + K x + d Fs sign(d x(1)) = B F, one to two bodies, one joint d with Coulomb friction."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    drive: np.ndarray
    joint: np.ndarray
    friction: float
    xml: str

    def position(self, state: np.ndarray) -> float:
        """Reading of the controller: displacement in the joint."""
        return float(self.joint @ state[: self.joint.size])


@dataclass(frozen=True)
class Loop:
    """Reference and gains of a cascade: P position, PI velocity from differences."""

    position: np.ndarray
    velocity: np.ndarray
    period: float
    gains: tuple[float, float, float]

    def controller(self) -> Callable[[int, float], float]:
        """Force at sample k for a reading; to be called once a sample."""
        Kpp, Kpv, Kiv = self.gains
        position, velocity = self.position.tolist(), self.velocity.tolist()
        integral, last = 0.0, None

        def force(k: int, reading: float) -> float:
            nonlocal integral, last
            speed = 0.0 if last is None else (reading - last) / self.period
            error = velocity[k] + Kpp * (position[k] - reading) - speed
            integral += Kiv * self.period * error
            last = reading
            return Kpv * (error + integral)

        return force


def rigid(M: float, Fv: float, Fs: float) -> Machine:
    """Rigid axis with one mass for both simulators."""
    xml = f"""<body><joint name="motor" type="slide" axis="1 0 0" damping="{Fv}" frictionloss="{Fs}"/>
        <geom size="0.1" mass="{M}"/></body>"""
    one = np.ones(1)
    return Machine(M * np.eye(1), Fv * np.eye(1), np.zeros((1, 1)), one, one, Fs, xml)


def direct(Ms: float, Fvs: float, Ks: float, Mm: float, Fvm: float, Fsm: float) -> Machine:
    """Motor on a structure with a spring to the ground, the drive between the two; absolute displacements."""
    joint = np.array([-1.0, 1.0])
    xml = f"""<body><joint type="slide" axis="1 0 0" stiffness="{Ks}" damping="{Fvs}"/><geom size="0.1" mass="{Ms}"/>
        <body><joint name="motor" type="slide" axis="1 0 0" damping="{Fvm}" frictionloss="{Fsm}"/>
        <geom size="0.1" mass="{Mm}"/></body></body>"""
    damping = np.diag([Fvs, 0.0]) + Fvm * np.outer(joint, joint)
    return Machine(np.diag([Ms, Mm]), damping, np.diag([Ks, 0.0]), joint, joint, Fsm, xml)


def by_solve_ivp(machine: Machine, loop: Loop, method: str, tolerance: float) -> np.ndarray:
    """States at the samples, restarted at each of them and where the joint comes to rest or breaks loose."""
    force, n = loop.controller(), machine.joint.size
    state, sign, states = np.zeros(2 * n), 0.0, np.zeros((loop.position.size, 2 * n))
    phases = {sign: _Phase(machine, sign) for sign in (-1.0, 0.0, 1.0)}
    for k in range(loop.position.size):
        states[k] = state
        drive, left = force(k, machine.position(state)), loop.period
        while left > 1e-15 * loop.period:
            if sign == 0.0:
                holding = phases[0.0].holding(state, drive)
                sign = float(np.sign(holding)) if abs(holding) > machine.friction else 0.0
            made, state, stopped = phases[sign].advance(state, drive, left, method, tolerance)
            left -= made
            if stopped:
                sign = phases[sign].after(state, drive)
    return states


class _Phase:
    """Motion with the joint sliding in one direction, or sticking (sign 0)."""

    def __init__(self, machine: Machine, sign: float) -> None:
        self._machine, self._sign, n = machine, sign, machine.joint.size
        inverse, d = np.linalg.inv(machine.mass), machine.joint
        self._hold = (d @ inverse) / (d @ inverse @ d)
        free = inverse if sign else inverse - np.outer(inverse @ d, self._hold)
        self._rows = np.hstack([-free @ machine.stiffness, -free @ machine.damping])
        self._drive, self._friction = free @ machine.drive, free @ d * machine.friction * sign
        self._n = n

    def holding(self, state: np.ndarray, drive: float) -> float:
        """Force that keeps the joint at rest."""
        m, n = self._machine, self._n
        return float(self._hold @ (m.drive * drive - m.stiffness @ state[:n] - m.damping @ state[n:]))

    def after(self, state: np.ndarray, drive: float) -> float:
        """Sign after the event: a joint at rest sticks unless pushed too hard, a stuck one leaves."""
        holding = self.holding(state, drive)
        if self._sign == 0.0 or abs(holding) > self._machine.friction:
            return float(np.sign(holding))
        return 0.0

    def advance(
        self, state: np.ndarray, drive: float, left: float, method: str, tolerance: float
    ) -> tuple[float, np.ndarray, bool]:
        """Time made, state, and whether an event ended it."""
        from scipy.integrate import solve_ivp  # here: not a part of MuJoCo's start-up

        constant = self._drive * drive - self._friction
        rows, n, joint, sign = self._rows, self._n, self._machine.joint, self._sign

        def motion(_: float, z: np.ndarray) -> np.ndarray:
            change = np.empty(2 * n)
            change[:n] = z[n:]
            change[n:] = rows @ z + constant
            return change

        def event(t: float, z: np.ndarray) -> float:
            if sign:
                return float(sign * (joint @ z[n:]) + (1e-18 if t == 0.0 else 0.0))
            return self._machine.friction - abs(self.holding(z, drive)) + (1e-12 if t == 0.0 else 0.0)

        event.terminal, event.direction = True, -1
        run = solve_ivp(
            motion, (0.0, left), state, method, rtol=tolerance, atol=tolerance * 1e-3, events=event
        )
        end = run.y[:, -1].copy()
        if run.status == 1 and sign:
            inverse = np.linalg.solve(self._machine.mass, joint)
            end[n:] -= inverse * (joint @ end[n:]) / (joint @ inverse)
        return float(run.t[-1]), end, run.status == 1


def by_mujoco(machine: Machine, loop: Loop) -> np.ndarray:
    """Positions in the joint at the samples: MuJoCo's default integrator at the same step, controller in Python."""
    import mujoco

    model, data = _mujoco_model(machine, loop.period)
    force, positions = loop.controller(), np.zeros(loop.position.size)
    joint = model.joint("motor").qposadr[0]
    for k in range(loop.position.size):
        reading = positions[k] = data.qpos[joint]
        data.ctrl[0] = force(k, float(reading))
        mujoco.mj_step(model, data)
    return positions


def rolled_out(machine: Machine, loop: Loop, forces: np.ndarray) -> np.ndarray:
    """The same for given forces, in MuJoCo's own loop in C."""
    import mujoco
    from mujoco import rollout

    model, data = _mujoco_model(machine, loop.period)
    start = np.zeros((1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    states, _ = rollout.rollout(model, data, start, np.ascontiguousarray(forces[None, :, None]))
    return np.asarray(states[0, :, 1 + model.joint("motor").qposadr[0]])


def _mujoco_model(machine: Machine, period: float):
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{period}" gravity="0 0 0"><flag contact="disable"/></option>
        <worldbody>{machine.xml}</worldbody><actuator><motor joint="motor"/></actuator></mujoco>"""
    )
    return model, mujoco.MjData(model)


def main() -> None:
    with np.load(sys.argv[1]) as file:
        machine = (rigid if file["values"].size == 3 else direct)(*file["values"])
        loop = Loop(file["position"], file["velocity"], float(file["period"]), tuple(file["gains"]))
    by_mujoco(machine, loop)


if __name__ == "__main__":
    main()
