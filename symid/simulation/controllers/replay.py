"""A recorded force that a cascade supports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.controllers.controller import Cascade, Command, Controller, LinearLaw


@dataclass(frozen=True)
class Replay(Controller):
    """A recorded force, plus a cascade that corrects small deviations from the recorded position.

    Parameters
    ----------
    forces : array of shape (n_samples,)
        Recorded force at each sample of the controller.
    cascade : Cascade
        Controller whose force is added.

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

    def holding(self, force: float) -> Replay:
        """Itself: its forces are given."""
        return self

    @property
    def start(self) -> FloatArray:
        """State of the cascade before the first sample."""
        return self.cascade.start

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Recorded force plus the cascade's; the last recorded value is kept beyond the end."""
        added, state = self.cascade.force(command, measured, state, period)
        return float(self.forces[min(command.index, len(self.forces) - 1)]) + added, state

    def linear(self, period: float) -> LinearLaw | None:
        """The cascade's law with the force as given; None if the cascade's own force has a limit."""
        if np.isfinite(self.cascade.force_limit):
            return None
        return replace(self.cascade.linear(period), given=np.asarray(self.forces, dtype=np.float64))
