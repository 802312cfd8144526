"""A place at which a force may act, and its motion under a record."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.diagnosis.prediction.corners import Reversals, reversals_of, with_corners
from symid.diagnosis.prediction.record import SLOW_SHARE, Record
from symid.last_values import LastValues
from symid.simulation.plants import LawTerm

_BACK = 0.02
"""Share of the way against the usual direction up to which a joint moves in one direction (single moves of drawn racks
and spindles, whose missing friction was called one of direction)."""


@dataclass(frozen=True, eq=False)
class RecordedJoint:
    """A place at which a force may act, and its motion on the fine grid."""

    name: str
    """The body whose joint it is, or the spring."""
    direction: FloatArray
    """The product with the displacements of the bodies is the displacement of the joint; shape (n_bodies,)."""
    spectrum: ComplexArray
    """Its displacement, measured where there are sensors; shape (n_bins,)."""
    modelled: ComplexArray
    """Its displacement that follows from the driven position; shape (n_bins,)."""
    record: Record
    """The log."""
    memory: LastValues = field(default_factory=LastValues, repr=False)
    """Cache of values that follow from its motion alone."""

    @cached_property
    def q(self) -> FloatArray:
        """Displacement on the fine grid."""
        return self.record.fine(self.spectrum)

    @property
    def v(self) -> FloatArray:
        """Velocity on the fine grid."""
        return self._reversals.velocity

    @cached_property
    def _reversals(self) -> Reversals:
        """The velocity and its changes of sign; measured motion has corners there."""
        record = self.record
        velocity = record.fine(1j * record.omega * self.spectrum)
        if self.modelled is not self.spectrum:
            return reversals_of(velocity)
        highest = float(record.omega[-1] * record.fine_time[1])
        return with_corners(velocity, highest, record.moves(np.abs(velocity)))

    @cached_property
    def a(self) -> FloatArray:
        """Acceleration from the driven position, without the noise of further readings."""
        return self.record.fine(-(self.record.omega**2) * self.modelled)

    def averaged(self, force: FloatArray) -> FloatArray:
        """Mean over each step of a force on the fine grid that may jump where the velocity changes sign.

        A jump between two points is divided between them; without this its time would be off by up to half a step.
        """
        _, k, passed = self._reversals
        jump = force[..., k + 1] - force[..., k]
        shift = np.zeros_like(force)
        shift[..., k] += np.maximum(0.5 - passed, 0.0) * jump
        shift[..., k + 1] -= np.maximum(passed - 0.5, 0.0) * jump
        return np.asarray(force + shift)

    def law_force(self, term: LawTerm) -> ComplexArray:
        """Spectrum of a term of a declared law."""
        return self.memory.of(
            ("law", id(term)), None, lambda: self.record.from_grid(self.averaged(term.forces(self.q, self.v)))
        )

    @cached_property
    def moving(self) -> BoolArray:
        """Points of the fine grid within the log at which the joint is not at rest."""
        return self.record.in_log & (np.abs(self.v) > SLOW_SHARE * self.top_speed)

    @cached_property
    def range(self) -> tuple[float, float]:
        """Lowest and highest displacement within the log."""
        inside = self.q[self.record.in_log]
        return float(inside.min()), float(inside.max())

    @property
    def stroke(self) -> float:
        """Highest less lowest displacement within the log, m or rad."""
        return self.range[1] - self.range[0]

    @cached_property
    def moves_both_ways(self) -> bool:
        """Whether more than a small part of the way within the log is against the usual direction."""
        speed = self.v[self.record.in_log]
        forward, way = float(np.sum(speed[speed > 0])), float(np.sum(np.abs(speed)))
        return min(forward, way - forward) > _BACK * way

    @cached_property
    def top_speed(self) -> float:
        """Highest speed within the log."""
        return float(np.abs(self.v[self.record.in_log]).max())
