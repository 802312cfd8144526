"""Forces in joints as the drive feels them, through gears, springs and drive constants."""

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.record import Record

_AT_REST = 1e-9
"""Displacement of a joint, relative to the largest, below which it does not follow the drive."""
_SMOOTHED, _MARGIN = 15, 4.0
"""Frequencies over which the power of a force is averaged, and its least ratio to the power of noise in it."""


def drive_force_of(prediction: Prediction, joint: RecordedJoint) -> float:
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


def denoised_force(prediction: Prediction, drive: int) -> FloatArray:
    """Force of a drive at all samples of a period, (n_extended,): the modelled one, and the recorded one in its noise.

    The modelled force has the noise of the position, times the square of the frequency. Where that exceeds the force,
    towards the end of the band and beyond it, the recorded force stands for it (a Wiener filter), less its own noise.
    """
    record, modelled = prediction.record, prediction.outputs[drive]
    if prediction.changes is not None:
        modelled = modelled + prediction.changes[drive]
    power = scipy.ndimage.uniform_filter1d(np.abs(modelled) ** 2, _SMOOTHED)
    spread = record.noise_spread[: record.n_drives] * record.noise_of_motions[:, None] ** 2
    noise = (
        np.sum(np.abs(prediction.response.of_positions[:, drive]) ** 2 * spread, axis=0) * record.n_extended
    )
    share = np.minimum(_MARGIN * noise / np.maximum(power, np.finfo(float).tiny), 1.0)
    force = record.memory.of(("beyond", drive), None, lambda: _beyond_band(record, drive)).copy()
    force[: record.n_bins] = modelled + share * (record.measured[drive] - modelled)
    return np.asarray(scipy.fft.irfft(force, record.n_extended))


def _beyond_band(record: Record, drive: int) -> ComplexArray:
    """Spectrum of the recorded force of a drive beyond the band, less its noise; the band is empty."""
    force = np.asarray(scipy.fft.rfft(record.whole_forces[drive]))
    omega = np.asarray(2 * np.pi / record.period * np.arange(force.size), dtype=np.float64)
    force = force * record.clock(record.forces[drive], omega)
    force[: record.n_bins] = 0.0
    of_noise = record.noise_of_outputs[drive] ** 2 * record.n_extended * (force.size - record.n_bins)
    share = max(1 - of_noise / max(float(np.sum(np.abs(force) ** 2)), of_noise), 0.0)
    return np.asarray(np.sqrt(share) * force)
