"""The interface of an effect: its places, its shape, and its change of the predicted outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.axis import force_unit, length_unit
from symid.diagnosis.prediction.hidden_equation import MassChange
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.places import place_named
from symid.diagnosis.prediction.prediction import Prediction
from symid.units import Unit

Shape = tuple[float, ...]
"""Values of the shape parameters of an effect, in which its force is not linear."""
Key = tuple[str, str]
"""Names of an effect and of its place."""

ParametersBefore = tuple[Mapping[str, float], Sequence[Shape]]
"""Parameters before an effect begins that changes them during a log, and shapes that lead to the same values."""

FreeForce = tuple[FloatArray, ComplexArray]
"""Direction over the bodies, and spectrum of a force along it for a pulse that excites hidden motion."""

MatchedFilter = Callable[[ComplexArray], FloatArray]
"""Correlation of a signal with the residual over time, on the fine grid, from the response of the outputs to it
(the adjoint of the weighting, applied to the residual)."""

ACTUATOR = "actuator"


class Effect(ABC):
    """An effect that a model may lack. It adds amplitudes times columns to the predicted outputs."""

    name: str
    """Name of the effect, see `symid.diagnosis.effects`."""
    amplitudes: tuple[str, ...]
    """Names of its amplitudes."""
    shape_names: tuple[str, ...] = ()
    """Names of its shape parameters."""
    positive: bool = False
    """Whether its first amplitude cannot be negative."""
    fixed: ClassVar[bool] = False
    """Whether its amplitude is 1, so that only the shape is free."""
    implicit: ClassVar[bool] = False
    """Whether its force depends on outputs that it changes itself, so that an equation has to be solved."""
    moments: ClassVar[tuple[str, ...]] = ()
    """Shape parameters that a log need not determine, such as the time of a change while the axis was at rest."""
    may_be_zero: ClassVar[tuple[str, ...]] = ()
    """Shape parameters that may be as small as their standard deviation, such as the damping of a mode."""
    per_log: ClassVar[bool] = False
    """Whether its amplitudes are properties of a log, for instance because time starts at 0 in each."""
    refines: tuple[str, ...] = ()
    """Names of simpler effects that it contains as a special case, and that may explain the same gap."""

    @property
    def may_be_undetermined(self) -> frozenset[str]:
        """Shape parameters whose standard deviation may exceed them."""
        return frozenset((*self.moments, *self.may_be_zero))

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """Whether a machine can have these amplitudes."""
        return not (self.positive and placed.amplitudes[0] < 0)

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """Whether the values are of the size of those of machines, and not at a bound of the search."""
        return True

    def recurs(self, found: Placed, here: Placed) -> bool:
        """Whether the values `here`, fitted to another log, agree with those found; by default not."""
        return False

    @abstractmethod
    def places(self, prediction: Prediction) -> Iterable[str]:
        """Places at which the effect is possible."""

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        """Shapes that the search tries at a place; one empty shape for an effect that is linear in its values."""
        return ((),)

    def mass_change(self, prediction: Prediction, placed: Placed) -> MassChange | None:
        """The change of a mass for the integration of hidden motion; None by default."""
        return None

    def free_forces(self, prediction: Prediction, placed: Placed) -> tuple[FreeForce, ...]:
        """Forces on bodies for pulses that excite hidden motion of the effect; none by default."""
        return ()

    def elsewhere(self, prediction: Prediction, placed: Placed) -> Iterable[Placed]:
        """The effect at places where linear screening does not find it, with initial values; none by default."""
        return ()

    def changes_to(self, prediction: Prediction, place: str) -> Iterable[ParametersBefore]:
        """Changes during the log to the parameters of a prediction; none by default."""
        return ()

    def shapes_of_log(self, prediction: Prediction, placed: Placed) -> Iterable[Shape]:
        """Shapes to be tried for another log, if part of the shape is a property of a log."""
        return ()

    def close_shapes(self, prediction: Prediction, placed: Placed, reach: float) -> Iterable[Shape]:
        """Shapes on a grid so fine that it resolves the minimum of the error, if `shapes_of_log` does not.

        Their moments are at most `reach` from that of the effect, relative to the log.
        """
        return ()

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        """The nearest admissible shape."""
        return shape

    @abstractmethod
    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        """Change of the predicted outputs for unit amplitudes, of shape (n_amplitudes, n_outputs, n_bins)."""

    def change(self, prediction: Prediction, placed: Placed) -> ComplexArray:
        """Change of the predicted outputs, of shape (n_outputs, n_bins)."""
        return np.tensordot(placed.amplitudes, self.columns(prediction, placed.at, placed.shape), 1)

    @property
    def is_of_command(self) -> bool:
        """Whether it acts on the command of the drive, before any delay or lag."""
        return False

    def varies_with_parameters(self, prediction: Prediction, place: str) -> bool:
        """Whether its change of the outputs depends on the physical parameters strongly, and not only by a force."""
        return False

    def passed_on(self, prediction: Prediction, placed: Placed, outputs: ComplexArray) -> ComplexArray | None:
        """Response to small changes of the predicted outputs, (..., n_outputs, n_bins); None without response."""
        return None

    def misreading(self, prediction: Prediction, placed: Placed) -> ComplexArray | None:
        """Error of the driven positions, of shape (n_drives, n_bins); None without error."""
        return None

    @abstractmethod
    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        """Units of amplitudes and shape parameters."""


class JointEffect(Effect):
    """An effect whose force opposes the motion of a joint."""

    @abstractmethod
    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        """Spectra of the forces for unit amplitudes, of shape (n_amplitudes, n_bins)."""

    def forces_at(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        """The same as `forces`, kept with the joint unless they depend on more than its motion."""
        if self.implicit:
            return self.forces(prediction, joint, shape)
        return joint.memory.of(self, shape, lambda: self.forces(prediction, joint, shape))

    def pointwise(
        self, prediction: Prediction, shape: Shape, amplitudes: tuple[float, ...]
    ) -> Pointwise | None:
        """Force of the effect as a function of the motion at an instant, for hidden joints; None if it is not one."""
        return None

    def strong_starts(
        self, spring: RecordedJoint, stiffness: float
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        """Shapes and amplitudes that change the motion of a hidden joint as much as its spring of that stiffness."""
        return ()

    def joint(self, prediction: Prediction, place: str) -> RecordedJoint:
        """The joint whose motion the effect depends on, from the name of its place."""
        return prediction.joints[place]

    def places(self, prediction: Prediction) -> Iterable[str]:
        return tuple(prediction.joints)

    def columns(self, prediction: Prediction, place: str, shape: Shape) -> ComplexArray:
        joint = self.joint(prediction, place)
        return prediction.column(joint, self.forces_at(prediction, joint, shape))


class LinearEffect(JointEffect):
    """A joint effect that is linear in the motion: a dynamic stiffness."""

    @abstractmethod
    def stiffness(self, omega: FloatArray, shape: Shape) -> ComplexArray:
        """Force for a unit displacement and amplitude, of shape (n_bins,)."""

    def impedance(self, omega: FloatArray, placed: Placed) -> ComplexArray:
        """Dynamic stiffness of the effect with its values, of shape (n_bins,)."""
        return np.asarray(placed.amplitudes[0] * self.stiffness(omega, placed.shape))

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        return (self.stiffness(prediction.record.omega, shape) * joint.modelled)[None]


def sampled(prediction: Prediction, *forces: FloatArray, joint: RecordedJoint | None = None) -> ComplexArray:
    """Spectra of signals on the fine grid, one per row; `joint` is given if they jump with its velocity."""
    values = np.stack(forces)
    return prediction.record.from_grid(values if joint is None else joint.averaged(values))


def joint_units(prediction: Prediction, place: str) -> tuple[Unit, Unit]:
    """Units of force and displacement at a place."""
    at = place_named(prediction.axis, place)
    return force_unit(prediction.axis.drives, at), length_unit(at)


@dataclass(frozen=True, eq=False)
class Placed:
    """An effect at a place with values."""

    effect: Effect
    """The effect."""
    at: str
    """Its place."""
    shape: Shape
    amplitudes: tuple[float, ...]
    """`shape`, `amplitudes`: values of its shape parameters and amplitudes."""
    integrated: bool = False
    """Whether the motion of a hidden joint is integrated with its force."""

    @property
    def key(self) -> Key:
        """Names of effect and place."""
        return self.effect.name, self.at

    def refines(self, key: Key) -> bool:
        """Whether it refines an effect at a place, as presliding friction refines Coulomb friction."""
        name, place = key
        return self.at == place and name in self.effect.refines

    @property
    def free(self) -> tuple[float, ...]:
        """Its free values: the amplitudes, unless they are fixed, then the shape."""
        return self.shape if self.effect.fixed else (*self.amplitudes, *self.shape)

    @property
    def n_free(self) -> int:
        """Number of free values."""
        return len(self.free)

    def with_free(self, values: Sequence[float]) -> Placed:
        """The effect with other free values."""
        first = self.n_free - len(self.shape)
        amplitudes = self.amplitudes if self.effect.fixed else tuple(values[:first])
        return replace(self, amplitudes=amplitudes, shape=tuple(values[first:]))

    def change(self, prediction: Prediction) -> ComplexArray:
        """Change of the predicted outputs, of shape (n_outputs, n_bins)."""
        return self.effect.change(prediction, self)

    def values(self, prediction: Prediction) -> list[tuple[str, float, str]]:
        """Name, value and unit of each free amplitude and shape parameter."""
        names = (*self.effect.amplitudes, *self.effect.shape_names)
        units = self.effect.units(prediction, self.at)
        first = len(names) - self.n_free
        return list(zip(names[first:], self.free, units[first:], strict=True))


def best_peaks(score: FloatArray, places: FloatArray, count: int) -> Sequence[float]:
    """Places of the highest local maxima of a score."""
    inner = np.flatnonzero((score[1:-1] >= score[:-2]) & (score[1:-1] > score[2:])) + 1
    if not inner.size:
        inner = np.array([int(np.argmax(score))])
    chosen = inner[np.argsort(-score[inner])[:count]]
    return [float(places[i]) for i in chosen]
