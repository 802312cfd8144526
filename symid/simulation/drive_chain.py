"""The chain from the commanded force to the acting one: gain, limit, lag, delay."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.axis import ActuatorDelay, ActuatorLag, DriveImperfection, ForceLimit
from symid.axis.drive_imperfections import in_order
from symid.simulation.controller import Command, Controller, LinearLaw, linear_law
from symid.simulation.imperfect_plant import scalar_law


@dataclass(frozen=True, eq=False)
class ThroughDrive(Controller):
    """A controller whose force passes through an imperfect drive: gain first, then limit, lag and delay.

    A force is held from sample to sample. Where a lag or a fractional delay changes it between two samples, its mean
    over the sample acts.

    >>> from symid.simulation.controller import OpenLoop
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
    def _bends(self) -> tuple[Callable[..., float], ...]:
        """Laws of gains and limits, in the order in which they act."""
        bends = in_order(item for item in self.drive if not isinstance(item, (ActuatorLag, ActuatorDelay)))
        return tuple(map(scalar_law, bends))

    @cached_property
    def _n_past(self) -> int:
        """Number of past forces that the delay stores."""
        return math.floor(self._delay / self.period + 1e-9) + 2 if self._delay else 0

    @cached_property
    def _given(self) -> tuple[FloatArray, FloatArray] | None:
        """A force given in advance, as commanded and after lags and delay; with it taken apart, the rest is linear."""
        law = linear_law(self.inner, self.period)
        if law is None or not law.given.size or not (self._lags or self._n_past) or self._bends:
            return None
        given = law.given_at(self.sent.size)
        late, state = np.zeros(given.size), [given[0]] * (len(self._lags) + self._n_past)
        for k, force in enumerate(given.tolist()):
            late[k], state = self._behind(force, state)
        return given, late

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
        acting, apart = float(force), 0.0
        if self._given is not None:
            given, late = self._given
            index = min(command.index, given.size - 1)
            acting, apart = acting - float(given[index]), float(late[index])
        for law in self._bends:
            acting = law(0.0, 0.0, acting, 0.0, 0.0)
        own = state[n:].tolist()
        if own and math.isnan(own[0]):  # the steady state of a constant force
            own = [acting] * len(own)
        acting, own = self._behind(acting, own)
        return acting + apart, np.concatenate([inner, own])

    def _behind(self, acting: Any, state: list[Any]) -> tuple[Any, list[Any]]:
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
        """The law of a linear controller followed by lags and delay, or by a limit below which the law is valid."""
        law = linear_law(self.inner, period)
        limits = [item.force for item in self.drive if isinstance(item, ForceLimit)]
        if law is None or math.isfinite(law.limit):
            return None
        if len(limits) < len(self._bends) or (limits and (self._lags or self._n_past)):
            return None
        n, n_state = len(law.A), self.start.size
        rows = np.eye(
            n_state, n_state + law.D.size
        )  # state after the sample, on that before it and the inputs
        rows[:n] = np.hstack([law.A, np.zeros((n, n_state - n)), law.B])
        acting, own = self._behind(np.concatenate([law.C, np.zeros(n_state - n), law.D]), list(rows[n:]))
        rows = np.vstack([rows[:n], *own])
        return LinearLaw(
            A=rows[:, :n_state],
            B=rows[:, n_state:],
            C=acting[:n_state],
            D=acting[n_state:],
            limit=min(limits, default=math.inf),
            given=law.given if self._given is None else self._given[1],
        )

    def sent_along(self, inputs: FloatArray) -> FloatArray:
        """Commanded force of a linear controller along references and readings, of shape (n_samples, 3 + n_signals)."""
        from symid.simulation.sample_loop import recursion  # numba takes 0.3 s to import

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
