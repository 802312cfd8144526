"""A run of rigid_1m as a controller records it, and its columns as text."""

import numpy as np

from symid import load_axis, simulate
from symid.data import Log
from symid.simulation import plant_of, trapezoids, tuned_cascade

TRUE = {"M": 50.0, "Fv": 40.0, "Fs": 15.0}
PERIOD = 1e-3


def recorded_run() -> Log:
    """The log, without noise."""
    axis = load_axis("rigid_1m")
    reference = trapezoids([0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, sampling_period=PERIOD)
    return simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "q")).log


def table(columns: dict[str, np.ndarray], separator: str, *, comma: bool = False) -> str:
    rows = [separator.join(f"{x:.10g}" for x in row) for row in zip(*columns.values(), strict=True)]
    text = "\n".join(rows)
    return separator.join(columns) + "\n" + (text.replace(".", ",") if comma else text) + "\n"
