"""The chain from the commanded force to the acting one: gain, limit, lag, delay."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.axis import ActuatorDelay, ActuatorLag, DriveImperfection, imperfections_in_order
from symid.simulation.controllers.controller import Command, Controller, LinearLaw, linear_law
from symid.simulation.plants.imperfect_plant import imperfection_code, imperfection_function


@dataclass(frozen=True, eq=False)
class ThroughDrive(Controller):
    """A controller whose force passes through an imperfect drive: gain first, then limit, lag and delay.

    A force is held from sample to sample. Where a lag or a fractional delay changes it between two samples, its mean
    over the sample acts.

    >>> from symid.simulation.controllers.controller import OpenLoop
    >>> late = ThroughDrive(OpenLoop(np.array([0.0, 4.0, 4.0])), (ActuatorDelay(0.25),), np.zeros(3), 1.0)
    >>> state, acting = late.start, []
    >>> for k in range(3):
    ...     force, state = late.force(Command(k, 0.0, 0.0, 0.0), {}, state, 1.0)
    ...     acting.append(force)
    >>> acting, late.sent.tolist()
    ([0.0, 3.0, 4.0], [0.0, 4.0, 4.0])
    """

    inner: Controller  # controller that commands the force
    drive: Sequence[DriveImperfection]  # imperfections of the drive
    # shape (n_samples,): receives the commanded force, unless the loop is linear: then `sent_along` computes it
    sent: FloatArray
    period: float  # time between two samples, s

    @cached_property
    def _lags(self) -> tuple[float, ...]:
        return tuple(item.seconds for item in self.drive if isinstance(item, ActuatorLag))

    @cached_property
    def _delay(self) -> float:
        return sum(item.seconds for item in self.drive if isinstance(item, ActuatorDelay))

    @cached_property
    def _nonlinearities(self) -> tuple[DriveImperfection, ...]:
        """Gains and limits, in the order in which they act."""
        return imperfections_in_order(
            item for item in self.drive if not isinstance(item, (ActuatorLag, ActuatorDelay))
        )

    @cached_property
    def _n_past(self) -> int:
        """Number of past forces that the delay stores."""
        return math.floor(self._delay / self.period + 1e-9) + 2 if self._delay else 0

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that the controller reads."""
        return self.inner.signals

    @property
    def start(self) -> FloatArray:
        """Initial state of the controller; the state of the drive is nan until the first force."""
        return np.concatenate([self.inner.start, np.full(len(self._lags) + self._n_past, math.nan)])

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force that acts until the next sample."""
        n = self.inner.start.size
        force, inner = self.inner.force(command, measured, state[:n], period)
        self.sent[command.index] = force
        acting = float(force)
        for element in self._nonlinearities:
            acting = float(imperfection_function(element)(0.0, 0.0, acting, 0.0, 0.0))
        own = state[n:].tolist()
        if own and math.isnan(own[0]):  # the steady state of a constant force
            own = [acting] * len(own)
        acting, own = self._lagged(acting, own)
        return acting, np.concatenate([inner, own])

    def _lagged(self, acting: Any, state: list[Any]) -> tuple[Any, list[Any]]:
        """Force after lags and delay, and their new state, as numbers or as rows on the state and inputs of a law."""
        lagging, past = state[: len(self._lags)], state[len(self._lags) :]
        # Each lag follows the force exponentially; the mean over the sample acts. A fractional delay is the mean of two
        # past forces, weighted by the time for which each acts.
        for i, time in enumerate(self._lags):
            decay = math.exp(-self.period / time)
            left = lagging[i] - acting
            lagging[i] = acting + left * decay
            acting = acting + left * (time / self.period) * (1.0 - decay)
        if past:
            past = [acting, *past[:-1]]
            share = self._delay / self.period - (len(past) - 2)
            acting = (1.0 - share) * past[-2] + share * past[-1]
        return acting, [*lagging, *past]

    def linear(self, period: float) -> LinearLaw | None:
        """The law of a linear controller without a limit, followed by the drive."""
        law = linear_law(self.inner, period)
        if law is None or math.isfinite(law.limit):
            return None
        n, n_state = len(law.A), self.start.size
        drive = np.eye(n_state + 1)  # rows on the state and the force after the nonlinearities
        acting, own = self._lagged(drive[-1], list(drive[n:-1]))
        after = np.vstack([np.zeros((n, n_state + 1)), *own])
        added = n_state - n
        return replace(
            law,
            A=np.vstack([np.pad(law.A, ((0, 0), (0, added))), after[n:, :-1]]),
            B=np.pad(law.B, ((0, added), (0, 0))),
            C=np.pad(law.C, (0, added)),
            nonlinearities=tuple(map(imperfection_code, self._nonlinearities)),
            E=after[:, -1],
            G=acting[:-1],
            H=float(acting[-1]),
        )

    def sent_along(self, inputs: FloatArray) -> FloatArray:
        """Commanded force of a linear controller along references and readings, of shape (n_samples, 3 + n_signals)."""
        from symid.simulation.compiled_loop.products import recursion  # numba takes 0.3 s to import

        law = linear_law(self.inner, self.period)
        assert law is not None
        # The first sample is made by the controller's own law, which may differ.
        command = Command(0, *inputs[0, :3].tolist())
        measured = dict(zip(self.signals, inputs[0, 3:].tolist(), strict=True))
        first, state = self.inner.force(command, measured, self.inner.start, self.period)
        states = recursion(np.array(law.A, order="C"), state, inputs[1:] @ law.B.T)[:-1]
        sent = np.concatenate([[first], states @ law.C + inputs[1:] @ law.D])
        sent[1:] += law.given_at(sent.size)[1:]
        return sent
