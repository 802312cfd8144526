"""From the force that a controller sends to the force that acts: gain, limit, lag, delay."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symid.arrays import FloatArray
from symid.axis import ActuatorDelay, ActuatorLag, DriveImperfection
from symid.axis.imperfections import in_order
from symid.simulation.controller import Command, Controller
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
        Receives the commanded force.

    Examples
    --------
    >>> from symid.simulation.controller import OpenLoop
    >>> late = ThroughDrive(OpenLoop(np.array([0.0, 4.0, 4.0])), (ActuatorDelay(0.25),), np.zeros(3))
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
    lags: tuple[float, ...] = field(init=False)
    delay: float = field(init=False)
    _bends: tuple[Callable[..., float], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        bends = in_order(item for item in self.drive if not isinstance(item, (ActuatorLag, ActuatorDelay)))
        object.__setattr__(self, "_bends", tuple(map(scalar_law, bends)))
        object.__setattr__(
            self, "lags", tuple(item.seconds for item in self.drive if isinstance(item, ActuatorLag))
        )
        object.__setattr__(
            self, "delay", sum(item.seconds for item in self.drive if isinstance(item, ActuatorDelay))
        )

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that the controller reads."""
        return self.inner.signals

    @property
    def start(self) -> FloatArray:
        """State of the controller; that of the drive begins with the first force."""
        return self.inner.start

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force that acts until the next sample."""
        n = self.inner.start.size
        force, inner = self.inner.force(command, measured, state[:n], period)
        self.sent[command.index] = force
        acting = float(force)
        for law in self._bends:
            acting = law(0.0, 0.0, acting, 0.0, 0.0)
        # at the first sample lags and delay are in the steady state of a constant force
        past_samples = math.floor(self.delay / period + 1e-9) + 2 if self.delay else 0
        own = state[n:].tolist() or [acting] * (len(self.lags) + past_samples)
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
        return acting, np.array([*inner, *lagging, *past])
