"""The axis driven by its measured motion: hidden motion, drive force and further readings as frequency responses.

With Z = -w^2 M + j w C + K, the drive's effect B and the row r of the driven position q,

    [ Z  -B ] [ x ]   [ f ]
    [ r   0 ] [ u ] = [ q ]

gives at each frequency the displacements x and the drive force u that belong to a motion q and to forces f on the
bodies. Eliminating x by hand leads to the rational functions of the paper: [14] for direct_2m1s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.prediction.record import Record
from symid.simulation import Plant


@dataclass(frozen=True, eq=False)
class Response:
    """Frequency responses of an axis at parameter values.

    Parameters
    ----------
    plant : Plant
        The axis.
    motion : array of shape (n_bins, n_bodies, n_bodies + 1)
        Displacements for forces on the bodies and for the driven position.
    outputs : array of shape (n_outputs, n_bins, n_bodies + 1)
        Drive force and further readings for the same.
    """

    plant: Plant
    motion: ComplexArray
    outputs: ComplexArray

    @property
    def of_position(self) -> ComplexArray:
        """Outputs for the driven position, of shape (n_outputs, n_bins)."""
        return self.outputs[:, :, -1]

    def of_force(self, direction: FloatArray) -> ComplexArray:
        """Outputs for a force along a direction over the bodies, of shape (n_outputs, n_bins)."""
        found = np.zeros(self.outputs.shape[:2], dtype=complex)
        for i in np.flatnonzero(direction):
            found += direction[i] * self.outputs[:, :, i]
        return found

    def of_forces(self, forces: ComplexArray) -> ComplexArray:
        """Outputs for forces on the bodies of shape (n_bins, n_bodies)."""
        found = np.zeros(self.outputs.shape[:2], dtype=complex)
        for j in range(forces.shape[1]):
            found += self.outputs[:, :, j] * forces[:, j]
        return found

    def displacements(self, position: ComplexArray, forces: ComplexArray) -> ComplexArray:
        """Displacements of shape (n_bodies, n_bins) for the driven position and forces on the bodies."""
        moved = self.motion[:, :, -1] * position[:, None]
        for j in range(forces.shape[1]):
            moved += self.motion[:, :, j] * forces[:, j, None]
        return np.asarray(moved.T)


def response_of(
    record: Record,
    parameters: Mapping[str, float],
    impedances: Sequence[tuple[FloatArray, ComplexArray]] = (),
) -> Response:
    """Frequency responses at parameter values.

    Parameters
    ----------
    record : Record
        Says the frequencies, the driven position and the other sensors.
    parameters : mapping of str to float
        Physical parameters, SI.
    impedances : sequence of (array, array)
        Direction over the bodies and dynamic stiffness, of shape (n_bins,), of what hangs on the axis besides.
    """
    plant = record.dynamics.at(parameters)
    n, s = len(plant.bodies), 1j * record.omega
    matrix = np.zeros((record.n_bins, n + 1, n + 1), dtype=complex)
    matrix[:, :n, :n] = (
        s[:, None, None] ** 2 * plant.mass + s[:, None, None] * plant.damping + plant.stiffness
    )
    for direction, stiffness in impedances:
        matrix[:, :n, :n] += stiffness[:, None, None] * np.outer(direction, direction)
    matrix[:, :n, n] = -plant.drive
    matrix[:, n, :n] = plant.sensors[record.signals[0]][0]
    inverse = _inverse(matrix)
    outputs = [inverse[:, n, :]]
    for name in record.signals[1:]:
        row, order = plant.sensors[name]
        outputs.append((s**order)[:, None] * np.einsum("i,kij->kj", row, inverse[:, :n, :]))
    return Response(plant, inverse[:, :n, :], np.stack(outputs))


def _inverse(matrix: ComplexArray) -> ComplexArray:
    """Inverse of each matrix of shape (n_bins, n, n); by cofactors for two bodies, ten times faster than LAPACK."""
    if matrix.shape[1] != 3:
        return np.asarray(np.linalg.inv(matrix), dtype=np.complex128)
    rows = [[np.ascontiguousarray(matrix[:, i, j]) for j in range(3)] for i in range(3)]
    inverse = np.empty_like(matrix)
    for i in range(3):
        (a, b, c), (d, e, f) = rows[i - 2], rows[i - 1]
        for j, cofactor in enumerate((b * f - c * e, c * d - a * f, a * e - b * d)):
            inverse[:, j, i] = cofactor
    determinant = sum(rows[0][j] * inverse[:, j, 0] for j in range(3))
    return np.asarray(inverse / np.asarray(determinant)[:, None, None], dtype=np.complex128)


def noise_weights(record: Record, response: Response, levels: Sequence[float] = ()) -> FloatArray:
    """What makes noise alone white with unit variance at the rows: 1 / sqrt(S), of shape (n_outputs, n_bins).

    S = level^2 sigma^2 + |G|^2 sigma_q^2: each output has its own noise, and that of the driven position comes through
    G. A level above 1 allows for errors of the model besides the noise.
    """
    own = record.noise[1:] * (np.array(levels) if len(levels) else 1.0)
    spread = own[:, None] ** 2 + np.abs(response.of_position) ** 2 * record.noise[0] ** 2
    return np.asarray(1 / np.sqrt(spread * 2 * record.n_bins / record.n_extended * record.freedom))
