"""Frequency responses of the axis driven by its measured motion: hidden motion, drive forces and further readings.

With Z = -w^2 M + j w C + K, the factors B of the drive forces and the rows R of the driven positions q,

    [ Z  -B ] [ x ]   [ f ]
    [ R   0 ] [ u ] = [ q ]

gives at each frequency the displacements x and the drive forces u for motions q and forces f on the bodies.
Eliminating x by hand leads to the rational functions of the paper: [14] for direct_2m1s. Bodies without mass stay in x,
as Z has their springs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.prediction.record import Record
from symid.last_values import LastValues
from symid.simulation import Plant

Impedance = tuple[FloatArray, ComplexArray]
"""Direction over the bodies and dynamic stiffness."""


@dataclass(frozen=True, eq=False)
class Solution:
    """The equations of an axis solved at each frequency of a record, when first asked for."""

    record: Record
    plant: Plant
    impedances: tuple[Impedance, ...] = ()  # further ones on the axis

    @cached_property
    def motion(self) -> ComplexArray:
        """Displacements for forces on the bodies and driven positions, (n_bins, n_bodies, n_bodies + n_drives)."""
        return np.moveaxis(self._inverse[: len(self.plant.bodies)], -1, 0)

    @cached_property
    def outputs(self) -> ComplexArray:
        """Drive forces and further readings for these inputs, (n_outputs, n_bins, n_bodies + n_drives)."""
        n, s = len(self.plant.bodies), 1j * self.record.omega
        moved, forces = self._inverse[:n], self._inverse[n:]
        outputs = list(forces)
        for name in self.record.readings:
            reading = self.plant.sensors[name]
            outputs.append(
                np.sum(reading.at(s)[:, None] * moved, axis=0) + np.tensordot(reading.drives, forces, 1)
            )
        return np.stack(outputs).swapaxes(1, 2)

    @cached_property
    def _inverse(self) -> ComplexArray:
        record, plant, s = self.record, self.plant, 1j * self.record.omega
        n = len(plant.bodies)
        matrix = np.zeros((n + record.n_drives, n + record.n_drives, record.n_bins), dtype=complex)
        matrix[:n, :n] = sum(np.multiply.outer(m, s**k) for m, k in ((plant.mass, 2), (plant.damping, 1)))
        matrix[:n, :n] += plant.stiffness[..., None]
        for direction, stiffness in self.impedances:
            matrix[:n, :n] += np.multiply.outer(np.outer(direction, direction), stiffness)
        matrix[:n, n:] = -plant.drives[..., None]
        matrix[n:, :n] = np.stack([plant.sensors[name][0] for name in record.driven])[..., None]
        return _inverse(matrix)


@dataclass(frozen=True, eq=False)
class Response:
    """Frequency responses of an axis at parameter values."""

    plant: Plant  # the axis
    solution: Solution  # of it, or of the axis at values nearby
    # cache of values that follow from the solution alone
    memory: LastValues = field(default_factory=LastValues, repr=False)

    def released(self) -> Response:
        """The response without its arrays, which are recomputed on demand."""
        return Response(self.plant, replace(self.solution))

    @property
    def motion(self) -> ComplexArray:
        """Motion of the bodies, see `Solution.motion`."""
        return self.solution.motion

    @property
    def outputs(self) -> ComplexArray:
        """Outputs of the model, see `Solution.outputs`."""
        return self.solution.outputs

    @property
    def inertia(self) -> float:
        """Mass or inertia that the drive moves at low frequencies: that of all bodies that follow its position.

        Of several drives, the geometric mean of those along the principal ways in which they move the axis.
        """
        follows = self.motion[0, :, len(self.plant.bodies) :].real
        return float(np.linalg.det(follows.T @ self.plant.mass @ follows) ** (1 / follows.shape[1]))

    @property
    def of_positions(self) -> ComplexArray:
        """Outputs for each driven position, of shape (n_drives, n_outputs, n_bins)."""
        return np.moveaxis(self.outputs[:, :, len(self.plant.bodies) :], -1, 0)

    def of_motions(self, positions: ComplexArray) -> ComplexArray:
        """Outputs for driven positions of shape (n_drives, n_bins), of shape (n_outputs, n_bins)."""
        found = self.of_positions[0] * positions[0]
        for gain, position in zip(self.of_positions[1:], positions[1:], strict=True):
            found += gain * position
        return np.asarray(found)

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

    def displacements(self, positions: ComplexArray, forces: ComplexArray) -> ComplexArray:
        """Displacements of shape (n_bodies, n_bins) for driven positions and forces on the bodies."""
        n = len(self.plant.bodies)
        moved = self.motion[:, :, n] * positions[0][:, None]
        for d, position in enumerate(positions[1:], 1):
            moved += self.motion[:, :, n + d] * position[:, None]
        for j in range(forces.shape[1]):
            moved += self.motion[:, :, j] * forces[:, j, None]
        return np.asarray(moved.T)


def axis_response(
    record: Record, parameters: Mapping[str, float], impedances: Sequence[Impedance] = ()
) -> Response:
    """Frequency responses at parameter values, with further impedances on the axis."""
    plant = record.dynamics.with_nodes(parameters)
    return Response(plant, Solution(record, plant, tuple(impedances)))


def _inverse(matrix: ComplexArray) -> ComplexArray:
    """Inverses of matrices of shape (n, n, n_bins); for n of 2 and 3 by cofactors, which is faster than LAPACK."""
    if len(matrix) == 2:
        (a, b), (c, d) = matrix
        return np.asarray(np.array([[d, -b], [-c, a]]) / (a * d - b * c), dtype=np.complex128)
    if len(matrix) != 3:
        found = np.asarray(np.linalg.inv(np.moveaxis(matrix, -1, 0)), dtype=np.complex128)
        return np.moveaxis(found, 0, -1)
    inverse = np.empty_like(matrix)
    for i in range(3):
        (a, b, c), (d, e, f) = matrix[i - 2], matrix[i - 1]
        for j, cofactor in enumerate((b * f - c * e, c * d - a * f, a * e - b * d)):
            inverse[j, i] = cofactor
    inverse /= sum(matrix[0, j] * inverse[j, 0] for j in range(3))
    return inverse


@dataclass(frozen=True, eq=False)
class ForcePath:
    """The path from the logged forces to the acting ones: gains and limits, then delays and lags.

    An output is predicted as response * p + withheld, where p is the prediction without these effects: for a force,
    the one that acts. Late readings have a response too. The arrays have shape (n_outputs, n_bins).
    """

    response: ComplexArray  # of delays and lags
    withheld: ComplexArray  # part of the logged forces that gains and limits withhold

    def acting(self, measured: ComplexArray) -> ComplexArray:
        """Outputs at the end of the path from the measured ones.

        >>> path = ForcePath(np.array([[2 + 0j]]), np.array([[1 + 0j]]))
        >>> path.acting(np.array([[7 + 0j]]))
        array([[3.+0.j]])
        """
        return np.asarray((measured - self.withheld) / self.response)


def noise_weights(
    record: Record, response: Response, levels: Sequence[float] = (), path: ForcePath | None = None
) -> FloatArray:
    """Weights that whiten noise to unit variance in the rows: 1 / sqrt(S), of shape (n_outputs, n_bins).

    S = level^2 sigma^2 + |G|^2 sigma_q^2: the noise of the output, and the noise of each driven position through its G.
    A level above 1 allows for errors of the model besides the noise. With coarse readings sigma has spectral lines.
    Delays and lags on the `path` of the forces follow G.
    """
    n = record.n_drives
    own = record.noise_of_outputs * (np.array(levels) if len(levels) else 1.0)
    spread = own[:, None] ** 2 * record.noise_spread[n:]
    for of_position, sigma, lines in zip(
        response.of_positions, record.noise_of_motions, record.noise_spread[:n], strict=True
    ):
        gain = of_position if path is None else of_position * path.response
        spread = spread + (gain.real**2 + gain.imag**2) * sigma**2 * lines
    return np.asarray(1 / np.sqrt(spread * 2 * record.n_bins / record.n_extended * record.freedom))


def as_measured(
    record: Record, response: Response, displacements: ComplexArray, misread: ComplexArray | None = None
) -> ComplexArray:
    """Displacements of the bodies, corrected to the readings of further position sensors.

    The first driven position is `misread` by an error, (n_bins,).
    """
    sensors = response.plant.sensors
    positions = [i for i, name in enumerate(record.signals) if sensors[name][1] == 0]
    further = [i for i in positions if i >= record.n_drives]
    if not further:
        return displacements
    rows = np.stack([sensors[record.signals[i]][0] for i in positions])
    read = np.concatenate([record.motions, record.measured[further]])
    if misread is not None:
        read[0] -= misread
    return np.asarray(displacements + np.linalg.pinv(rows) @ (read - rows @ displacements))
