"""Controllers: from a reference and measured motion to a drive force, sample by sample.

A user-defined controller is a class derived from `Controller`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError


@dataclass(frozen=True)
class Command:
    """Command to a controller at a sample."""

    index: int
    """Number of the controller's sample."""
    position: float
    """Reference."""
    velocity: float
    """Its derivative."""
    acceleration: float
    """Its second derivative."""


@dataclass(frozen=True, eq=False)
class LinearLaw:
    """A controller and its drive as matrices: u = C x + D w + given is sent, f = n(u), x' = A x + B w + E f.

    x is the state; w holds the reference (position, velocity, acceleration) and then the readings, in the order of the
    controller's `signals`. The force G x + H f acts. Without nonlinearities, E and G it is the force that is sent.

    Parameters
    ----------
    A : array of shape (n_state, n_state)
    B : array of shape (n_state, 3 + n_signals)
    C : array of shape (n_state,)
    D : array of shape (3 + n_signals,)
    limit : float
        Largest sent force for which the matrices are valid.
    given : array of shape (n,)
        Given force at each sample, added to that of the matrices; the last value is kept beyond the end. May be empty.
    nonlinearities : tuple of str
        Static nonlinearities n of the drive, its gains and limits, as NumPy code in terms of F.
    E, G : array of shape (n_state,), optional
        Memory of the drive for the force f = n(u), and its part of the acting force; 0 by default.
    H : float
        Share of f that acts at once.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    limit: float = math.inf
    given: FloatArray = field(default_factory=lambda: np.zeros(0))
    nonlinearities: tuple[str, ...] = ()
    E: FloatArray | None = None
    G: FloatArray | None = None
    H: float = 1.0

    def given_at(self, n_samples: int) -> FloatArray:
        """Given force at the first `n_samples` samples; 0 if there is none."""
        if not self.given.size:
            return np.zeros(n_samples)
        return self.given[np.minimum(np.arange(n_samples), self.given.size - 1)]


class Controller(ABC):
    """Law of a sampled controller; its memory is a state that it receives and returns."""

    @abstractmethod
    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Drive force until the next sample, a `period` (s) later, and the state to remember.

        `measured` holds the sensor readings by signal; `state` is the one that the last sample returned, at first
        `start`.
        """

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that the controller reads."""
        return ()

    @property
    def start(self) -> FloatArray:
        """State before the first sample."""
        return np.zeros(0)

    def holding(self, force: float) -> Controller:
        """Controller with a state before the first sample in which it holds a force.

        SettingError if it is not 0 and the class does not say how.
        """
        if not force:
            return self
        raise SettingError(
            f"{type(self).__name__} does not say how it holds {force:.4g} at the first sample: give it a method "
            "holding(force), or start from displacements and velocities"
        )

    def linear(self, period: float) -> LinearLaw | None:
        """The law as matrices, if it is linear from the second sample on; the compiled loop then includes it.

        A class that overrides `force` without overriding this runs without matrices.
        """
        return None


@dataclass(frozen=True)
class OpenLoop(Controller):
    """A given force, for example from a log: `forces` has one value for each sample of the controller."""

    forces: FloatArray

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Drive force at this sample; the last value is kept beyond the end."""
        return float(self.forces[min(command.index, len(self.forces) - 1)]), state

    def holding(self, force: float) -> OpenLoop:
        """Itself: its forces are given."""
        return self

    def linear(self, period: float) -> LinearLaw:
        """The law with the given force alone."""
        forces = np.asarray(self.forces, dtype=np.float64)
        return LinearLaw(np.zeros((0, 0)), np.zeros((0, 3)), np.zeros(0), np.zeros(3), given=forces)


@dataclass(frozen=True)
class Cascade(Controller):
    """P position loop around a PI velocity loop, with feed-forward, force limit and anti-windup.

    F = Kpv (e_v + Kiv integral of e_v) + Kfa a_ref + Kfv v_ref with e_v = v_ref + Kpp (q_ref - q) - v. With
    ``position_gain=0`` it is the PI velocity loop of the paper, the only one that a velocity sensor allows.

    Parameters
    ----------
    signal : str
        Signal of the sensor that is controlled.
    position_gain : float
        Kpp, 1/s; 0 if the sensor reads a velocity.
    velocity_gain : float
        Kpv, N s/m.
    integral_gain : float
        Kiv, 1/s: the inverse of the integral time.
    acceleration_feedforward, velocity_feedforward : float
        Kfa in kg and Kfv in N s/m.
    force_limit : float
        Largest force, N; the integral does not grow while the force is at this limit.
    held : float
        Force that the integral holds before the first sample, N, as that of a drive whose brake opens.
    reads_velocity : bool
        Whether the sensor reads a velocity, as a tachometer or gyro does, instead of a position.

    Raises
    ------
    SettingError
        If a position gain is given and the sensor reads a velocity.

    Examples
    --------
    >>> wheel = Cascade("w", 0.0, 2.0, 0.0, reads_velocity=True)
    >>> wheel.force(Command(0, 0.0, 5.0, 0.0), {"w": 4.0}, wheel.start, 1e-3)[0]
    2.0
    """

    signal: str
    position_gain: float
    velocity_gain: float
    integral_gain: float
    acceleration_feedforward: float = 0.0
    velocity_feedforward: float = 0.0
    force_limit: float = math.inf
    held: float = 0.0
    reads_velocity: bool = False

    def __post_init__(self) -> None:
        if self.reads_velocity and self.position_gain:
            raise SettingError(
                f"Kpp is {self.position_gain:g}, and {self.signal!r} reads a velocity: a position loop needs a "
                "position sensor; declare one, or leave Kpp out"
            )

    def holding(self, force: float) -> Cascade:
        """The cascade whose integral holds a force before the first sample."""
        if force and not self.velocity_gain:
            raise SettingError(f"a cascade without velocity gain cannot hold {force:.4g}: give it one")
        return replace(self, held=force)

    def with_gains(self, **gains: float) -> Cascade:
        """A cascade with other gains, given by field name."""
        return replace(self, **gains)  # type: ignore[arg-type]  # all fields that are given are numbers

    @property
    def signals(self) -> tuple[str, ...]:
        """The controlled signal."""
        return (self.signal,)

    @property
    def start(self) -> FloatArray:
        """Integral of the velocity error, last position, and 1 once there is a last position."""
        integral = self.held / self.velocity_gain if self.held else 0.0
        return np.array([integral, 0.0, 0.0])

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Drive force; the velocity is the difference of the last two positions, as drives compute it."""
        reading = measured[self.signal]
        integral, last, started = state.tolist()
        if self.reads_velocity:
            error = command.velocity - reading
        else:
            velocity = (reading - last) / period if started else 0.0
            error = command.velocity + self.position_gain * (command.position - reading) - velocity
        grown = integral + self.integral_gain * period * error
        wanted = self.velocity_gain * (error + grown)
        wanted += self.acceleration_feedforward * command.acceleration
        wanted += self.velocity_feedforward * command.velocity
        force = min(max(wanted, -self.force_limit), self.force_limit)
        kept = grown if force == wanted or error * wanted * self.velocity_gain < 0 else integral
        return force, np.array([kept, reading, 1.0])

    def linear(self, period: float) -> LinearLaw:
        """The law while the force is below its limit; state: integral, last reading, 1."""
        per_step = 0.0 if self.reads_velocity else 1.0 / period
        of_reading = 1.0 if self.reads_velocity else self.position_gain + per_step
        error_state = np.array([0.0, per_step, 0.0])
        error_input = np.array([self.position_gain, 1.0, 0.0, -of_reading])
        growth = self.integral_gain * period
        feedforward = np.array([0.0, self.velocity_feedforward, self.acceleration_feedforward, 0.0])
        integral = np.array([1.0, 0.0, 0.0])
        return LinearLaw(
            A=np.array([integral + growth * error_state, np.zeros(3), [0.0, 0.0, 1.0]]),
            B=np.array([growth * error_input, [0.0, 0.0, 0.0, 1.0], np.zeros(4)]),
            C=self.velocity_gain * (integral + (1.0 + growth) * error_state),
            D=self.velocity_gain * (1.0 + growth) * error_input + feedforward,
            limit=self.force_limit,
        )


def linear_law(controller: Controller, period: float) -> LinearLaw | None:
    """The matrices of a controller; None if a derived class overrides `force` and not `linear`."""
    for kind in type(controller).__mro__:
        if "linear" in vars(kind):
            return controller.linear(period)
        if "force" in vars(kind):
            return None
    return None
