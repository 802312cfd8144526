"""An axis as what simulators of mechanisms know: inertias, and linear or simple properties along paths of joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import sympy as sp

from symid.axis import (
    AsymmetricFriction,
    Axis,
    Backlash,
    Body,
    Damper,
    Law,
    PendulumWeight,
    Spring,
    Weight,
)
from symid.errors import SettingError
from symid.symbolic.lagrange import Kinematics

Path: TypeAlias = tuple[tuple[str, float], ...]
"""A displacement as coefficients of the free bodies' coordinates."""
_PROPERTIES = {
    "v": "damping",
    "q": "stiffness",
    "q**3": "cubic",
    "v*abs(v)": "drag",
    "sign(v)": "frictionloss",
    "1": "constant",
}
"""Field of `Properties` for each law expression that has one."""
_NO_MASS = 1e-9


@dataclass(frozen=True)
class Properties:
    """Forces along a path of displacement q and speed v."""

    # stiffness, cubic, damping, drag, frictionloss: force against the motion: stiffness q + cubic q^3 + damping v
    # + drag v abs(v) + frictionloss sign(v)
    stiffness: float = 0.0
    cubic: float = 0.0
    damping: float = 0.0
    drag: float = 0.0
    frictionloss: float = 0.0
    constant: float = 0.0  # force in the positive direction
    armature: float = 0.0  # inertia that resists its acceleration


@dataclass(frozen=True)
class Play:
    """A spring along a path that is loose within a gap."""

    path: Path
    stiffness: float
    gap: float


class Inertial(NamedTuple):
    """Mass, height of its centre above the joint, and inertia about that centre."""

    mass: float
    height: float
    inertia: float


@dataclass(frozen=True)
class Mechanism:
    """The axis in these terms."""

    bodies: tuple[Body, ...]  # free bodies
    # of each free body where its joint is that of a tree; 0 where an armature holds it
    inertia: Mapping[str, float]
    moments: Mapping[str, float]  # m l of each pendulum, in units of the first one's gravity
    paths: Mapping[Path, Properties]  # forces and inertias along each path
    plays: tuple[Play, ...]  # springs with play
    drives: tuple[Path, ...]  # along which each drive pushes
    gains: tuple[float, ...]  # force per unit of each drive's command, or of its signal without a command
    readings: Mapping[str, Path]  # displacement of each sensor, before it is differentiated
    losses: tuple[str, ...]  # parts of the axis that none of these holds

    @property
    def roots(self) -> tuple[Body, ...]:
        """Bodies that are on no other one."""
        return tuple(b for b in self.bodies if _parent_in_tree(b) is None)

    def children(self, body: Body) -> tuple[Body, ...]:
        """Bodies that a body carries."""
        return tuple(b for b in self.bodies if _parent_in_tree(b) == body)

    def inertial(self, body: Body) -> Inertial:
        """Inertia of a body; readers demand some where the axis has it in an armature.

        A pendulum's centre of mass hangs below its hinge; half of its inertia is then about that centre.
        """
        inertia, moment = max(self.inertia[body.name], _NO_MASS), self.moments.get(body.name, 0.0)
        if not moment:
            return Inertial(inertia, 0.0, inertia)
        mass = 2 * moment**2 / inertia
        return Inertial(mass, -moment / mass, inertia / 2)

    def moves_freely(self, body: Body) -> bool:
        """Whether a body is one of the tree, with a frame that moves as it does."""
        return body.geared is None and bool(self.inertia[body.name])


def mechanism(axis: Axis, values: Mapping[str, float]) -> Mechanism:
    """The axis as inertias and simple properties.

    >>> from symid.axis import load_axis
    >>> found = mechanism(load_axis("rigid_1m"), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> found.paths[(("motor", 1.0),)].frictionloss
    20.0
    """
    return _Collector(axis, values).mechanism()


def is_joint(path: Path) -> bool:
    """Whether a path is the joint of one body and nothing else."""
    return len(path) == 1 and path[0][1] == 1.0


def _parent_in_tree(body: Body) -> Body | None:
    """The free body under which a body is nested: what carries it, or what turns the geared body that carries it."""
    gears = body.on.gears if isinstance(body.on, Body) else ()
    return gears[0].to if gears else body.carrier


def _upwards(body: Body, parent: Callable[[Body], Body | None]) -> list[Body]:
    """A body, its parent, and so on."""
    line = [body]
    while (above := parent(line[-1])) is not None:
        line.append(above)
    return line


class _Collector:
    """Goes through the elements of an axis once."""

    def __init__(self, axis: Axis, values: Mapping[str, float]) -> None:
        self.axis, self.values = axis, axis.with_known_values(values)
        self.kinematics = Kinematics(axis)
        self.paths: dict[Path, Properties] = {}
        self.plays: list[Play] = []
        self.losses: list[str] = []
        self.moments: dict[str, float] = {}

    def mechanism(self) -> Mechanism:
        """The mechanism of all elements."""
        inertia = {}
        for body in self.axis.bodies:
            value, path = self.values[body.inertial], self.path(self.kinematics.absolute(body))
            if self._is_in_tree(body):
                inertia[body.name] = value
            else:
                inertia |= {body.name: 0.0} if body.geared is None else {}
                self._check_coupling(body, path)
                self.add(path, "armature", value)
        for element in self.axis.elements:
            self._element(element)
        return Mechanism(
            bodies=self.axis.free_bodies,
            inertia=inertia,
            moments=self.moments,
            paths=self.paths,
            plays=tuple(self.plays),
            drives=tuple(self.path(self.kinematics.displacement(d.at)) for d in self.axis.drives),
            gains=tuple(
                d.factor * (self.values[d.constant] if d.constant else 1.0) for d in self.axis.drives
            ),
            readings={s.signal: self.path(self.kinematics.displacement(s.joint)) for s in self.axis.sensors},
            losses=tuple(self.losses),
        )

    def path(self, displacement: sp.Expr) -> Path:
        """Coefficients of a displacement as numbers."""
        constants = {sp.Symbol(name): value for name, value in self.kinematics.constants.items()}
        factors = ((b.name, displacement.coeff(self.kinematics.symbol(b))) for b in self.axis.free_bodies)
        return tuple((name, float(factor.xreplace(constants))) for name, factor in factors if factor != 0)

    def add(self, path: Path, name: str, value: float) -> None:
        """One more property along a path; along a single joint, it becomes one of that joint."""
        if len(path) == 1:
            ((body, ratio),) = path
            power = {"stiffness": 2, "damping": 2, "armature": 2, "cubic": 4, "drag": 3}.get(name, 1)
            path = ((body, 1.0),)
            value *= ratio if name == "constant" else abs(ratio) ** power
        found = self.paths.get(path, Properties())
        self.paths[path] = replace(found, **{name: getattr(found, name) + value})

    def _check_coupling(self, body: Body, path: Path) -> None:
        """MuJoCo couples the inertia of joints only where one is nested under the other."""
        moved = [b for b in self.axis.free_bodies if b.name in dict(path)]
        lines = [_upwards(one, _parent_in_tree) for one in moved]
        longest = max(lines, key=len)
        if not all(line[0] in longest for line in lines):
            raise SettingError(
                f"body {body.name!r} moves with {', '.join(name for name, _ in path)}, none of which carries "
                "the other: MuJoCo cannot couple their inertias; export this axis to C"
            )

    def _is_in_tree(self, body: Body) -> bool:
        """Whether its displacement is the sum of the joints down to the ground."""
        joints = {above.name: 1.0 for above in _upwards(body, lambda one: one.carrier)}
        return body.geared is None and dict(self.path(self.kinematics.absolute(body))) == joints

    def _element(self, element: object) -> None:
        value, displacement = self.values, self.kinematics.displacement
        match element:
            case Spring():
                path = self.path(displacement(element.at))
                self.add(path, "stiffness", value[element.named("stiffness")])
                if element.damping:
                    self.add(path, "damping", value[element.named("damping")])
            case Damper():
                self.add(self.path(displacement(element.at)), "damping", value[element.named("damping")])
            case Weight():
                force = -value[element.body.inertial] * element.acceleration
                self.add(self.path(self.kinematics.absolute(element.body)), "constant", force)
            case PendulumWeight(body=body) if self._is_in_tree(body):
                first = next(e for e in self.axis.elements if isinstance(e, PendulumWeight))
                moment = value[element.named("moment")] * element.acceleration / first.acceleration
                self.moments[body.name] = self.moments.get(body.name, 0.0) + moment
            case PendulumWeight(body=body):
                self.losses.append(f"PendulumWeight of {body.name}: it turns with a gear and has no frame.")
            case Law():
                self._law(element, self.path(displacement(element.at)))

    def _law(self, law: Law, path: Path) -> None:
        match law:
            case AsymmetricFriction():
                forward, backward = ([self.values[p[i]] for p in (law.viscous, law.coulomb)] for i in (0, 1))
                self.add(path, "damping", (forward[0] + backward[0]) / 2)
                self.add(path, "frictionloss", (forward[1] + backward[1]) / 2)
                self.add(path, "constant", -(forward[1] - backward[1]) / 2)
                if forward[0] != backward[0]:
                    self._lose(law, "one viscous coefficient for both directions, their mean")
            case Backlash():
                stiffness = self.values[law.named("stiffness")]
                self.add(path, "stiffness", -stiffness)
                self.plays.append(Play(path, stiffness, law.gap))
            case _:
                for term in law.terms():
                    name, value = _PROPERTIES.get(term.expression), self.values[term.parameter]
                    if name:
                        self.add(path, name, -value if name == "constant" else value)
                    else:
                        self._lose(law, f"left out: {value:.4g} {term.expression}")

    def _lose(self, law: Law, how: str) -> None:
        at = law.at
        place = at.name if isinstance(at, Body) else f"{at.first.name} and {at.second.name}"
        self.losses.append(f"{type(law).__name__} at {place}: {how}.")
