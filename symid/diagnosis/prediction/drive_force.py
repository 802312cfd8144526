"""Forces in joints as the drive feels them, through gears, springs and drive constants."""

from __future__ import annotations

import numpy as np

from symid.diagnosis.prediction.joint import Joint
from symid.diagnosis.prediction.prediction import Prediction

_AT_REST = 1e-9
"""Displacement of a joint, relative to the largest, below which it does not follow the drive."""


def drive_force_of(prediction: Prediction, joint: Joint) -> float:
    """Force of the drive, in the unit of its record, that balances a unit force in a joint in slow motion.

    A spring between two bodies is held at its other end. A joint that does not follow the drive, such as that of a
    structure, counts as moving as far as the drive does.
    """
    k, plant, rows = prediction.drive_of(joint), prediction.response.plant, prediction.driven_rows
    # The shape of least elastic energy with the driven position at 1, and those of other drives at 0
    n, stiffness = plant.stiffness.shape[0], plant.stiffness / (np.abs(plant.stiffness).max() or 1.0)
    system = np.block([[stiffness, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    shapes = [np.linalg.lstsq(system, np.eye(len(system))[n + k], rcond=None)[0][:n]]
    if np.count_nonzero(joint.direction) > 1:  # between two bodies: one end moves
        shapes.append(np.linalg.pinv(rows)[:, k])
    for shape in shapes:
        moved, pushed = abs(joint.direction @ shape), abs(plant.drives[:, k] @ shape)
        if moved > _AT_REST * np.abs(shape).max() * np.abs(joint.direction).max():
            return float(moved / pushed)
    return float(1.0 / np.abs(plant.drives[:, k]).max())
