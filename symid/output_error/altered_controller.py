"""A controller that differs from the given one in a few linear terms: derivatives of the closed loop in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.controller import Command, Controller, LinearLaw, linear_law

TERMS = (
    "proportional gain",
    "integral gain",
    "derivative gain",
    "velocity feed-forward",
    "acceleration feed-forward",
    "delay",
)


@dataclass(frozen=True, eq=False)
class AlteredController(Controller):
    """The given controller plus `TERMS`, each times its change.

    Gains are those of the error: reference less the first signal that the controller reads. The delay is in samples of
    the controller, of which it takes the first order: sent + delay (last sent - sent).
    """

    given: Controller
    changes: FloatArray  # shape (n_terms,)
    order: int | None = 0  # derivative of the position that the first signal reads; None without an error

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals of the given controller."""
        return self.given.signals

    @property
    def start(self) -> FloatArray:
        """Integral of the error, last error, last force of the given controller, then its own state."""
        return np.concatenate([np.zeros(3), self.given.start])

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force of the given controller and the terms."""
        sent, inner = self.given.force(command, measured, state[3:], period)
        integral, last_error, last_sent = state[:3].tolist()
        error = 0.0
        if self.order is not None:
            wanted = (command.position, command.velocity, command.acceleration)[self.order]
            error = wanted - measured[self.signals[0]]
        integral += period * error
        slope = (error - last_error) / period
        terms = (error, integral, slope, command.velocity, command.acceleration, last_sent - sent)
        state = np.concatenate([[integral, error, sent], inner])
        return sent + float(self.changes @ terms), state

    def linear(self, period: float) -> LinearLaw | None:
        """The matrices of the given controller with three more states; None if it has none."""
        law = linear_law(self.given, period)
        if law is None or law.given.size or law.nonlinearities or law.E is not None:
            return None
        n, p, i, d, v, a, late = len(law.C), *self.changes
        error = np.zeros(law.D.size)
        if self.order is not None:
            error[self.order], error[3] = 1.0, -1.0
        A, B = np.zeros((n + 3, n + 3)), np.zeros((n + 3, law.D.size))
        A[0, 0], B[0] = 1.0, period * error
        B[1] = error
        A[2, 3:], B[2] = law.C, law.D
        A[3:, 3:], B[3:] = law.A, law.B
        D = (p + i * period + d / period) * error + (1.0 - late) * law.D
        D[1] += v
        D[2] += a
        C = np.concatenate([[i, -d / period, late], (1.0 - late) * law.C])
        return replace(law, A=A, B=B, C=C, D=D)
