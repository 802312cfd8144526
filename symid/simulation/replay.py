"""A log driven through an axis again: its force, and a cascade that answers to departures from its motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.controller import Cascade, Command, Controller, LinearLaw


@dataclass(frozen=True)
class Replay(Controller):
    """A recorded force, and a cascade that keeps the axis to the recorded position against small differences.

    Parameters
    ----------
    forces : array of shape (n_samples,)
        Recorded force at each sample of the controller.
    cascade : Cascade
        Adds its own.

    Examples
    --------
    >>> loop = Replay(np.array([1.0, 2.0]), Cascade("q", position_gain=0.0, velocity_gain=3.0, integral_gain=0.0))
    >>> loop.force(Command(1, 0.0, 0.5, 0.0), {"q": 0.0}, loop.start, 1e-3)[0]
    3.5
    """

    forces: FloatArray
    cascade: Cascade

    @property
    def signals(self) -> tuple[str, ...]:
        """The controlled position."""
        return self.cascade.signals

    @property
    def start(self) -> FloatArray:
        """State of the cascade before the first sample."""
        return self.cascade.start

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Recorded force and that of the cascade; the last one recorded is kept beyond the end."""
        added, state = self.cascade.force(command, measured, state, period)
        return float(self.forces[min(command.index, len(self.forces) - 1)]) + added, state

    def linear(self, period: float) -> LinearLaw | None:
        """The cascade's law with the force as given; None if the cascade's own force has a limit."""
        if np.isfinite(self.cascade.force_limit):
            return None
        return replace(self.cascade.linear(period), given=np.asarray(self.forces, dtype=np.float64))
