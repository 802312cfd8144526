"""An axis at given parameter values, as the simulation and the diagnosis see it.

M x(2) + C x(1) + K x = B F + c - sum_j d_j f_j(d_j x, d_j x(1)), x being the absolute displacements of the free
bodies, F the drive forces, d_j the direction of a joint and f_j the nonlinear laws in it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from symid.arrays import ComplexArray, FloatArray
from symid.axis import Between, Body, Ground, Joint, carrier_of
from symid.errors import SettingError

LawFunction = Callable[[Any, Any], Any]
"""Of the displacement and the velocity of a joint, each a number or an array."""

JUST_MOVING = 1e-300
"""Speed just above zero: laws are evaluated at it for their limits at rest."""
_FELT = 1e-200
"""Least force that counts as a jump at rest; a smooth law gives far less at `JUST_MOVING`."""
_PLACES = np.array([0.0, *(sign * 10.0 ** (k / 4) for k in range(-24, 5) for sign in (1.0, -1.0))])
"""Displacements at which a law may hold its joint: 0, and four in each decade from 1 um or urad to 10 m or rad."""


class SensorRow(NamedTuple):
    """Reading of a sensor as a linear function of body motion and drive forces, plus a constant."""

    row: FloatArray
    """Factors of the displacements of the free bodies, shape (n_bodies,); of a force sensor, of that in its joint."""
    order: int | None
    """Derivative that is read: 0 for a position, 1 for a velocity, 2 for an acceleration; None for a force."""
    motion: FloatArray
    """Factors of displacements, velocities and accelerations in the reading; shape (3, n_bodies)."""
    drives: FloatArray
    """Factors of the drive forces in it; shape (n_drives,)."""
    constant: float = 0.0
    """Reading when motion and forces are zero."""
    law: int | None = None
    """Place in the plant's laws of those in the spring whose force is read."""
    per_force: float = 1.0
    """Reading per unit of their force."""

    def at(self, s: npt.NDArray[np.complexfloating[Any, Any]]) -> ComplexArray:
        """Reading for displacements of the bodies at complex frequencies, of shape (n_bodies, n_frequencies)."""
        used = [(factors, k) for k, factors in enumerate(self.motion) if factors.any()]
        zero = np.zeros((self.row.size, s.size), dtype=complex)
        return np.asarray(sum((np.multiply.outer(factors, s**k) for factors, k in used), zero))


class ScaledLaw(NamedTuple):
    """A law: parameter, SI, times an expression of displacement and velocity of the joint.

    `code` is the expression as NumPy code; its z is the state of the memory with the number `memory`, if there is one.
    """

    parameter: float
    expression: LawFunction
    code: str
    memory: int = -1


@dataclass(frozen=True, eq=False)
class JointLaw:
    """All nonlinear laws of a joint, whose displacement is `direction` times the bodies' displacements.

    A law is `timed` if it depends on more than the motion and changes from sample to sample.
    """

    direction: FloatArray
    terms: tuple[ScaledLaw, ...]
    timed: bool = False

    def force(self, q: Any, v: Any) -> Any:
        """Force that opposes the motion, at numbers or arrays."""
        return sum(term.parameter * term.expression(q, v) for term in self.terms)

    def limits(self, q: float) -> tuple[float, float]:
        """Lowest and highest force at rest; they differ where the law can hold the joint."""
        return float(self.force(q, -JUST_MOVING)), float(self.force(q, JUST_MOVING))

    @property
    def can_hold(self) -> bool:
        """Whether the joint can stick: the law jumps at rest at some displacement within 10 m or rad."""
        with np.errstate(over="ignore", invalid="ignore"):
            low, high = (self.force(_PLACES, side * JUST_MOVING) for side in (-1.0, 1.0))
            return bool(np.any(high - low > _FELT))


@dataclass(frozen=True, eq=False)
class Plant:
    """Matrices of an axis; see the module for the equation."""

    bodies: tuple[str, ...]
    """Free bodies, in the order of the displacements."""
    mass: FloatArray
    """M; shape (n, n)."""
    damping: FloatArray
    """C; shape (n, n)."""
    stiffness: FloatArray
    """K; shape (n, n)."""
    drives: FloatArray
    """B; shape (n, n_drives)."""
    constant: FloatArray
    """c; shape (n,)."""
    laws: tuple[JointLaw, ...]
    """Nonlinear laws by joint."""
    sensors: Mapping[str, SensorRow]
    """Reading of each sensor, by signal."""
    nodes: tuple[str, ...] = ()
    """Bodies whose mass only stands for none."""

    @property
    def drive(self) -> FloatArray:
        """B of an axis with one drive, as a vector of shape (n,)."""
        (column,) = self.drives.T
        return np.asarray(column)

    @cached_property
    def natural_frequencies(self) -> tuple[float, ...]:
        """Undamped natural frequencies in ascending order, Hz; rigid-body modes are left out.

        Examples
        --------
        >>> from symid.axis import load_axis
        >>> from symid.simulation import plant_of
        >>> paper = {"Ms": 3899.0, "Fvs": 0.0, "Ks": 1e9, "Mm": 362.58, "Fvm": 0.0, "Fsm": 0.0}
        >>> [round(f, 1) for f in plant_of(load_axis("direct_2m1s"), paper).natural_frequencies]
        [80.6]
        """
        stiffness, mass = self.stiffness, self.mass
        if self.nodes:  # where the springs beside them balance
            heavy = np.array([name not in self.nodes for name in self.bodies])
            stiffness, mass = stiffness[np.ix_(heavy, heavy)], mass[np.ix_(heavy, heavy)]
            beside = self.stiffness[np.ix_(~heavy, heavy)]
            stiffness = stiffness - beside.T @ np.linalg.solve(self.stiffness[np.ix_(~heavy, ~heavy)], beside)
        squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
        floor = 1e-9 * max(squares.max(initial=0.0), 1e-12)
        return tuple(sorted(float(np.sqrt(w) / (2 * np.pi)) for w in squares if w > floor))

    @property
    def highest_mode(self) -> float:
        """Highest natural frequency, Hz; 0 without springs."""
        return max(self.natural_frequencies, default=0.0)

    @property
    def feedthrough(self) -> dict[str, FloatArray]:
        """Acceleration that each accelerometer reads at once per unit of each drive's force, of shape (n_drives,).

        Examples
        --------
        >>> from symid.axis import load_axis
        >>> from symid.simulation import plant_of
        >>> paper = {"Ms": 4000.0, "Fvs": 0.0, "Ks": 1e9, "Mm": 500.0, "Fvm": 0.0, "Fsm": 0.0}
        >>> read = plant_of(load_axis("direct_2m1s"), paper).feedthrough
        >>> {name: d.round(8).tolist() for name, d in read.items()}
        {'ddq1': [-0.00025], 'ddq2': [0.00225]}
        """
        at_once = np.linalg.solve(self.mass, self.drives)
        return {name: one.motion[2] @ at_once for name, one in self.sensors.items() if one.motion[2].any()}

    def follows(self, readings: Mapping[str, tuple[float, float]]) -> FloatArray:
        """State in which position sensors read given values and speeds, with the springs in equilibrium.

        Parameters
        ----------
        readings : mapping of str to (float, float)
            Reading of each of some position sensors and its derivative, SI.

        Returns
        -------
        array of shape (2 n,)
            Displacements of least energy in springs and constant forces, then velocities that leave the springs at
            their lengths as far as possible.

        Examples
        --------
        >>> from symid.axis import load_axis
        >>> from symid.simulation import plant_of
        >>> plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 3.0, "Fs": 4.0}).follows({"q": (0.1, 0.5)}).tolist()
        [0.1, 0.5]
        """
        rows = np.array([self.sensors[signal].row for signal in readings])
        m, n = rows.shape
        scale = max(float(np.abs(self.stiffness).max()), 1.0)
        matrix = np.block([[self.stiffness / scale, rows.T], [rows, np.zeros((m, m))]])
        wanted = np.zeros((n + m, 2))
        wanted[:n, 0], wanted[n:] = self.constant / scale, list(readings.values())
        return np.asarray(np.linalg.lstsq(matrix, wanted, rcond=1e-12)[0][:n].T.ravel())


def condensed(dynamics: Any, T: Any, bodies: tuple[str, ...]) -> Any:
    """The plant in terms of the displacements of some bodies, which determine all others: x = T x_bodies.

    Also for a plant of symbols, with SymPy matrices in place of arrays.
    """
    return replace(
        dynamics,
        bodies=bodies,
        mass=T.T @ dynamics.mass @ T,
        damping=T.T @ dynamics.damping @ T,
        stiffness=T.T @ dynamics.stiffness @ T,
        drives=T.T @ dynamics.drives,
        constant=T.T @ dynamics.constant,
        laws=tuple(replace(law, direction=law.direction @ T) for law in dynamics.laws),
        sensors={
            name: sensor._replace(row=sensor.row @ T, motion=sensor.motion @ T)
            for name, sensor in dynamics.sensors.items()
        },
    )


def direction_of(joint: Joint, bodies: Sequence[str]) -> FloatArray:
    """Row whose product with the absolute displacements of a plant's bodies is the displacement in a joint.

    A free body that is not in the plant has no mass; only springs may act on it.

    >>> from symid.axis import load_axis
    >>> axis = load_axis("direct_2m1s")
    >>> direction_of(axis.bodies[1], [body.name for body in axis.bodies]).tolist()
    [-1.0, 1.0]
    """
    row = dict.fromkeys(bodies, 0.0)
    for name, share in _shares(joint):
        row[name] = row.get(name, 0.0) + share
    if massless := [name for name, share in row.items() if share and name not in bodies]:
        raise SettingError(
            f"an imperfection acts on body {massless[0]!r}, which has no mass: give it one to simulate"
        )
    return np.array([row[name] for name in bodies])


def _shares(joint: Joint) -> Iterator[tuple[str, float]]:
    """Factors of the displacements of free bodies whose sum is the displacement in a joint."""
    if isinstance(joint, Between):
        first, second = joint.first, joint.second
        for body, other, factor in ((second, first, 1.0), (first, second, -joint.ratio)):
            yield from _absolute(body, factor)
            yield from _absolute(carrier_of(body, other), -factor)
    elif joint.gears:
        yield from ((name, gear.ratio * share) for gear in joint.gears for name, share in _shares(gear.to))
    else:
        yield joint.name, 1.0
        if joint.parent is not None:
            yield joint.parent.name, -1.0


def _absolute(body: Body | Ground, factor: float) -> Iterator[tuple[str, float]]:
    """The factors for a multiple of the displacement of a body relative to the ground."""
    if isinstance(body, Body):
        yield from ((name, factor * share) for name, share in _shares(body))
        if isinstance(body.on, Body) and body.on.turns == body.turns:  # else it turns by its own coordinate
            yield from _absolute(body.on, factor)
