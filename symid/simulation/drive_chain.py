"""From the force that a controller sends to the force that acts: gain, limit, lag, delay."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symid.arrays import FloatArray
from symid.axis import ActuatorDelay, ActuatorLag, DriveImperfection, ForceLimit
from symid.axis.imperfections import in_order
from symid.simulation.controller import Command, Controller, LinearLaw, linear_law
from symid.simulation.imperfect_plant import scalar_law


@dataclass(frozen=True, eq=False)
class ThroughDrive(Controller):
    """A controller whose force passes through an imperfect drive: gain first, then limit, lag and delay.

    A force is held from sample to sample; of a force that changes in between, by a lag or a delay of no whole number of
    samples, the mean acts.

    Parameters
    ----------
    inner : Controller
        Controller that commands the force.
    drive : sequence of DriveImperfection
        Imperfections of the drive of the axis.
    sent : array of shape (n_samples,)
        Receives the commanded force, unless the loop is linear: then `sent_along` has it.
    period : float
        Time between two samples, s.

    Examples
    --------
    >>> from symid.simulation.controller import OpenLoop
    >>> late = ThroughDrive(OpenLoop(np.array([0.0, 4.0, 4.0])), (ActuatorDelay(0.25),), np.zeros(3), 1.0)
    >>> state, acting = late.start, []
    >>> for k in range(3):
    ...     force, state = late.force(Command(k, 0.0, 0.0, 0.0), {}, state, 1.0)
    ...     acting.append(force)
    >>> acting, late.sent.tolist()
    ([0.0, 3.0, 4.0], [0.0, 4.0, 4.0])
    """

    inner: Controller
    drive: Sequence[DriveImperfection]
    sent: FloatArray
    period: float
    lags: tuple[float, ...] = field(init=False)
    delay: float = field(init=False)
    _bends: tuple[Callable[..., float], ...] = field(init=False, repr=False)
    _given: FloatArray = field(init=False, repr=False)
    _given_late: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        bends = in_order(item for item in self.drive if not isinstance(item, (ActuatorLag, ActuatorDelay)))
        object.__setattr__(self, "_bends", tuple(map(scalar_law, bends)))
        object.__setattr__(
            self, "lags", tuple(item.seconds for item in self.drive if isinstance(item, ActuatorLag))
        )
        object.__setattr__(
            self, "delay", sum(item.seconds for item in self.drive if isinstance(item, ActuatorDelay))
        )
        # A force that is given whole passes through lags and delay before the run, so that the rest is linear.
        object.__setattr__(self, "_given", np.zeros(0))
        law = linear_law(self.inner, self.period)
        if law is not None and law.given.size and self._is_late and not self._bends:
            given = law.given[np.minimum(np.arange(self.sent.size), law.given.size - 1)]
            object.__setattr__(self, "_given_late", self._late(given))
            object.__setattr__(self, "_given", given)

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that the controller reads."""
        return self.inner.signals

    @property
    def past_samples(self) -> int:
        """Number of past forces that a delay takes."""
        return math.floor(self.delay / self.period + 1e-9) + 2 if self.delay else 0

    @property
    def _is_late(self) -> bool:
        return bool(self.lags or self.past_samples)

    @property
    def start(self) -> FloatArray:
        """State of the controller; that of the drive is not known before the first force."""
        return np.concatenate([self.inner.start, np.full(len(self.lags) + self.past_samples, math.nan)])

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force that acts until the next sample."""
        n = self.inner.start.size
        force, inner = self.inner.force(command, measured, state[:n], period)
        self.sent[command.index] = force
        acting, apart = float(force), 0.0
        if self._given.size:
            index = min(command.index, self._given.size - 1)
            acting, apart = acting - float(self._given[index]), float(self._given_late[index])
        for law in self._bends:
            acting = law(0.0, 0.0, acting, 0.0, 0.0)
        acting, own = self._behind(acting, state[n:], period)
        return acting + apart, np.concatenate([inner, own])

    def _behind(self, acting: float, state: FloatArray, period: float) -> tuple[float, FloatArray]:
        """Force behind lags and delay, and their state."""
        own = state.tolist()
        if own and math.isnan(own[0]):  # the steady state of a constant force
            own = [acting] * len(own)
        lagging, past = own[: len(self.lags)], own[len(self.lags) :]
        # Each lag follows the force exponentially; the mean over the sample acts. A delay of no whole number of samples
        # is the mean of two past forces, weighted by the time for which each acts.
        for i, time in enumerate(self.lags):
            decay = math.exp(-period / time)
            left = lagging[i] - acting
            lagging[i] = acting + left * decay
            acting += left * (time / period) * (1.0 - decay)
        if past:
            past = [acting, *past[:-1]]
            share = self.delay / period - (len(past) - 2)
            acting = (1.0 - share) * past[-2] + share * past[-1]
        return acting, np.array([*lagging, *past])

    def linear(self, period: float) -> LinearLaw | None:
        """The law of a linear controller behind lags and delay, or behind a limit, below which it holds."""
        law = linear_law(self.inner, period)
        limits = [item.force for item in self.drive if isinstance(item, ForceLimit)]
        if law is None or math.isfinite(law.limit):
            return None
        if len(limits) < len(self._bends) or (limits and self._is_late):
            return None
        n, n_state = len(law.A), self.start.size
        rows = np.eye(
            n_state, n_state + law.D.size
        )  # state after the sample, on that before it and the inputs
        rows[:n] = np.hstack([law.A, np.zeros((n, n_state - n)), law.B])
        acting = np.concatenate([law.C, np.zeros(n_state - n), law.D])
        for i, time in enumerate(self.lags, start=n):
            decay, left = math.exp(-period / time), np.eye(n_state + law.D.size)[i] - acting
            rows[i] = acting + left * decay
            acting = acting + left * (time / period) * (1.0 - decay)
        if past := self.past_samples:
            first = n + len(self.lags)
            rows[first + 1 :] = np.roll(rows[first:], 1, axis=0)[1:]
            rows[first] = acting
            share = self.delay / period - (past - 2)
            acting = (1.0 - share) * rows[-2] + share * rows[-1]
        return LinearLaw(
            A=rows[:, :n_state],
            B=rows[:, n_state:],
            C=acting[:n_state],
            D=acting[n_state:],
            limit=min(limits, default=math.inf),
            given=self._given_late if self._given.size else law.given,
        )

    def _late(self, forces: FloatArray) -> FloatArray:
        """Given forces behind lags and delay."""
        state, found = np.full(len(self.lags) + self.past_samples, math.nan), np.zeros(forces.size)
        for k, force in enumerate(forces.tolist()):
            found[k], state = self._behind(force, state, self.period)
        return found

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
        if law.given.size:
            sent[1:] += law.given[np.minimum(np.arange(1, sent.size), law.given.size - 1)]
        return sent
