"""Motion of an axis under a record, and the places at which forces may act on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import GROUND, Axis, Between, Body, Spring
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.response import Response
from symid.simulation.plants import direction_of


@dataclass(frozen=True, eq=False)
class AxisMotion:
    """Motion of every joint of an axis under a record, at given parameters."""

    record: Record  # the log
    parameters: Mapping[str, float]  # physical parameters, SI
    response: Response  # frequency responses of the axis at these parameters
    # shape (n_bodies, n_bins): motion of the bodies that follows from the driven positions
    displacements: ComplexArray
    # the same, corrected to the readings of further position sensors; laws are evaluated at it
    observed: ComplexArray

    @property
    def axis(self) -> Axis:
        """The axis as declared, without the effects that were found."""
        return self.record.dynamics.axis

    @cached_property
    def driven_rows(self) -> FloatArray:
        """Driven positions as products with the displacements of the bodies, of shape (n_drives, n_bodies)."""
        return np.stack([self.response.plant.sensors[name].row for name in self.record.driven])

    @property
    def free_directions(self) -> FloatArray:
        """Directions over the bodies that leave the driven positions at rest, of shape (n, n_bodies)."""
        rows = self.driven_rows
        free = self.record.memory.of("free", rows.tobytes(), lambda: np.linalg.svd(rows)[2])
        return np.asarray(free[self.record.n_drives :])

    @cached_property
    def joints(self) -> Mapping[str, RecordedJoint]:
        """Joints of the bodies that have a mass, and of those geared to several, whose motion is that of no other."""
        names, heavy = self.response.plant.bodies, self.record.dynamics.bodies
        found = {
            body.name: self._joint(body.name, direction_of(body, names))
            for body in self.axis.free_bodies
            if body.name in heavy
        }
        return self._with_geared(found, {body: body for body in self.axis.bodies if body.geared})

    @cached_property
    def joints_of_drives(self) -> tuple[RecordedJoint, ...]:
        """Displacements in the joints in which the drives act."""
        names = self.response.plant.bodies
        return tuple(self._joint(drive.signal, direction_of(drive.at, names)) for drive in self.axis.drives)

    def drive_of(self, joint: RecordedJoint) -> int:
        """The drive that pushes most along a joint."""
        return int(np.argmax(np.abs(joint.direction @ self.response.plant.drives)))

    @cached_property
    def springs(self) -> Mapping[str, RecordedJoint]:
        """Joints with a spring, by the name of a spring between bodies, or of the body in whose joint the spring is."""
        bodies = self.response.plant.bodies
        return {
            place_of(element): self._joint(place_of(element), direction_of(element.at, bodies))
            for element in self.axis.elements
            if isinstance(element, Spring)
        }

    @cached_property
    def bodies(self) -> Mapping[str, RecordedJoint]:
        """Absolute motion of the free bodies that have a mass, along which inertia acts."""
        names, heavy = self.response.plant.bodies, self.record.dynamics.bodies
        rows = zip(names, np.eye(len(names)), strict=True)
        return {name: self._joint(name, row) for name, row in rows if name in heavy}

    @cached_property
    def loaded(self) -> Mapping[str, RecordedJoint]:
        """`bodies`, and those geared to several, whose motion is that of no other: each may carry a load."""
        geared = (body for body in self.axis.bodies if body.geared)
        return self._with_geared(self.bodies, {body: Between(first=GROUND, second=body) for body in geared})

    def _with_geared(
        self, found: Mapping[str, RecordedJoint], geared: Mapping[Body, Body | Between]
    ) -> Mapping[str, RecordedJoint]:
        """Joints, and those of geared bodies whose motion is that of no other."""
        joints = dict(found)
        for body, at in geared.items():
            row = direction_of(at, self.response.plant.bodies)
            if not any(_are_parallel(row, joint.direction) for joint in joints.values()):
                joints[body.name] = self._joint(body.name, row)
        return joints

    def along(self, direction: FloatArray) -> RecordedJoint:
        """The motion along a direction over the bodies."""
        return self._joint("", direction)

    def driven_shares(self, direction: FloatArray) -> FloatArray | None:
        """Displacement along a direction for a unit of each driven position; None if it depends on other motion too."""
        rows, key = self.driven_rows, ("driven shares", direction.tobytes())
        return self.record.memory.of(key, rows.tobytes(), lambda: _shares(rows, direction))

    def _joint(self, name: str, direction: FloatArray) -> RecordedJoint:
        sensors = self.response.plant.sensors
        n_positions = sum(sensors[name][1] == 0 for name in self.record.signals)
        # With redundant position sensors, the displacement is their least-squares estimate.
        shares = None if n_positions > direction.size else self.driven_shares(direction)
        if shares is not None:  # measured motion, whatever the model: one joint for all predictions
            spectrum = np.asarray(shares @ self.record.motions)
            made = RecordedJoint(name, direction, spectrum, spectrum, self.record)
            known: RecordedJoint = self.record.driven_joints.setdefault((name, direction.tobytes()), made)
            return known
        observed, modelled = (_along(direction, x) for x in (self.observed, self.displacements))
        return RecordedJoint(name, direction, observed, modelled, self.record)


def _are_parallel(one: FloatArray, other: FloatArray) -> bool:
    return bool(abs(one @ other) > (1.0 - 1e-12) * np.linalg.norm(one) * np.linalg.norm(other))


def _shares(rows: FloatArray, direction: FloatArray) -> FloatArray | None:
    shares = np.asarray(np.linalg.solve(rows @ rows.T, rows @ direction))
    return shares if np.allclose(direction, shares @ rows, rtol=0, atol=1e-12) else None


def _along(direction: FloatArray, displacements: ComplexArray) -> ComplexArray:
    """Displacement along a direction over the bodies."""
    found = np.zeros(displacements.shape[1], dtype=complex)
    for i in np.flatnonzero(direction):
        found += direction[i] * displacements[i]
    return found
