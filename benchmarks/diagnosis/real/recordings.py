"""Readers of the real logs, with numpy and scipy only: signals in SI units on a uniform grid.

Where the times of a file jitter, signals are interpolated linearly on a grid of the median period that begins with the
first sample. No reader filters, smooths or corrects; parts are cut out as `Recording.between` says.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

DATA = Path(__file__).parents[3] / "data"
EMPS_GAIN = 35.15065188248547
"""N/V."""
ROBOT_RATIO = 256.857
"""Turns of the motor of axis 1 per turn of the axis."""
SERVO_COUNTS = 4096
"""Counts of the servo's encoder a turn."""
SERVO_DUTY = 1.0 / (256 * 885)
"""Duty of the servo's bridge per count of position error and unit of its gain."""
MOTOR_COUNTS = 8192
"""Counts of the slow motor's encoder a turn."""
FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording:
    """Signals of one run in SI units, uniformly sampled."""

    source: str  # file within data/
    # start, period: time of the first sample, and between two, s
    start: float
    period: float
    signals: Mapping[str, FloatArray]  # values of each signal

    def __getitem__(self, name: str) -> FloatArray:
        return self.signals[name]

    def between(self, begin: float, end: float) -> Recording:
        """Samples from `begin` to before `end`, in s from the first one."""
        part = slice(max(round(begin / self.period), 0), round(min(end, 1e9) / self.period))
        signals = {name: values[part] for name, values in self.signals.items()}
        return Recording(f"{self.source}, {begin:g} to {end:g} s", self.start + begin, self.period, signals)


def on_grid(source: str, time: FloatArray, **signals: FloatArray) -> Recording:
    """Recording of signals with jittering times: linear interpolation on a grid of the median period."""
    period = float(np.median(np.diff(time)))
    grid = time[0] + period * np.arange(int((time[-1] - time[0]) / period) + 1)
    return Recording(
        source, float(grid[0]), period, {n: np.interp(grid, time, x) for n, x in signals.items()}
    )


def emps(file: str = "DATA_EMPS") -> Recording:
    """The electro-mechanical positioning system, force made of the controller's volts."""
    found = loadmat(DATA / "emps" / f"{file}.mat", variable_names=("t", "qm", "vir"))
    t, q, volts = (np.asarray(found[name], dtype=float).ravel() for name in ("t", "qm", "vir"))
    period = round(float(t[-1] - t[0]) / (t.size - 1), 9)  # the times are rounded to some nanoseconds
    return Recording(f"emps/{file}.mat", float(t[0]), period, {"q": q, "F": EMPS_GAIN * volts})


def bench(which: str) -> Recording:
    """Two motors on a flexible coupling, log A or B; the load's angle with the sign of the motor's."""
    file = f"flex_motor_bench/MultisineType{which}.mat"
    found = loadmat(DATA / file, variable_names=("iq_adx", "theta_mx", "theta_my", "time"))
    t, current, motor, load = (
        np.asarray(found[n], dtype=float).ravel() for n in ("time", "iq_adx", "theta_mx", "theta_my")
    )
    return Recording(
        file, 1e-6 * t[0], 1e-6 * float(np.median(np.diff(t))), {"iq": current, "qm": motor, "ql": -load}
    )


def pendulum(method: str) -> Recording:
    """The torque-limited pendulum, swung up by a method: ddp or direct_collocation."""
    file = f"dfki_simple_pendulum/control_method_{method}__data_measured.csv"
    found = np.genfromtxt(DATA / file, delimiter=",", names=True)
    period = float(np.median(np.diff(found["time"])))
    return Recording(file, float(found["time"][0]), period, {"q": found["position"], "tau": found["torque"]})


def robot(which: str, axis: int = 1) -> Recording:
    """An axis of the robot, run A, B or C: angles of motor (geared down) and arm, torque of axis 1 on the arm's side.

    The gears of the other axes are not published: their torques are those of the motors.
    """
    file = f"kuka_kr300/kuka_{which}.mat"
    rec: Any = loadmat(DATA / file, squeeze_me=True, struct_as_record=False)["rec"]
    signals = {
        "qm": np.deg2rad(rec.act_pos_mot_deg[axis - 1]),
        "ql": np.deg2rad(rec.act_pos_se_deg[axis - 1]),
        "tau": (ROBOT_RATIO if axis == 1 else 1.0) * rec.act_torque_abs_nm[axis - 1],
    }
    t = rec.time_cont
    return Recording(file, float(t[0]), float((t[-1] - t[0]) / (len(t) - 1)), signals)


def double_pendulum(run: str) -> Recording:
    """Shoulder of the double pendulum, with the elbow's angle: measured angles and torque of a run."""
    file = f"double_pendulum/design_C.1_sys_id_20230629_20230629-{run}_trajectory.csv"
    found = np.genfromtxt(DATA / file, delimiter=",", names=True)
    return on_grid(
        file, found["time"], q=found["pos_meas1"], elbow=found["pos_meas2"], tau=found["tau_meas1"]
    )


def servo(run: str) -> Recording:
    """The servo with a weight on a lever: its angle, and the voltage that its position controller applies.

    The controller's law gives the duty, and that times the measured supply voltage the drive, at the times of the file.
    """
    file = f"bam_xl330/bak_2026-01-15_{run}.json"
    found = json.loads((DATA / file).read_text())
    time, goal, q, volts = (
        np.array([entry[name] for entry in found["entries"]], dtype=float)
        for name in ("timestamp", "goal_position", "position", "input_volts")
    )
    error = (goal - q) * SERVO_COUNTS / (2.0 * np.pi)
    duty = np.clip(found["kp"] * error * SERVO_DUTY, -1.0, 1.0)
    return on_grid(file, time, q=q, u=duty * volts)


def motor(run: str) -> Recording:
    """The motor turned slowly: its angle and its current."""
    file = f"odrive_cogging/{run}.mat"
    time, counts, current = np.asarray(loadmat(DATA / file)["data"], dtype=float)
    return on_grid(file, time, q=counts * 2.0 * np.pi / MOTOR_COUNTS, i=current)


def tiago(joint: str) -> Recording:
    """A joint of the service robot: its position, and the effort of its motor."""
    signals = {}
    for name, key in (("position", "q"), ("effort", "F")):
        file = DATA / "pal_tiago" / f"tiago_{name}.csv"
        header = file.read_text().partition("\n")[0].split(",")
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        signals[key] = table[:, header.index(f"- {joint}_{name}")]
    return on_grid(f"pal_tiago, {joint}", table[:, 0], **signals)
