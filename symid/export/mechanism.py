"""An axis in the terms of multibody simulators: inertias, and simple properties along combinations of joints."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import sympy as sp

from symid.axis import AsymmetricFriction, Axis, Backlash, Body, Damper, Law, PendulumWeight, Spring, Weight
from symid.errors import SettingError
from symid.export.exported import require_physical
from symid.symbolic import Kinematics

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
_NO_MASS = 1e-9  # kg or kg m^2: stands for none, which simulators refuse


@dataclass(frozen=True)
class Properties:
    """Forces and inertia along a path with displacement q and velocity v.

    The force against the motion is stiffness q + cubic q^3 + damping v + drag v abs(v) + frictionloss sign(v).
    """

    stiffness: float = 0.0
    cubic: float = 0.0
    damping: float = 0.0
    drag: float = 0.0
    frictionloss: float = 0.0
    constant: float = 0.0  # force in the positive direction
    armature: float = 0.0  # inertia


@dataclass(frozen=True)
class Play:
    """A spring along a path with play."""

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
    # of each free body in the tree of joints; 0 if it is an armature of a path instead
    inertia: Mapping[str, float]
    # m l of each pendulum, scaled by its gravity relative to that of the first one
    moments: Mapping[str, float]
    paths: Mapping[Path, Properties]  # forces and inertias along each path
    plays: tuple[Play, ...]  # springs with play
    drives: tuple[Path, ...]  # path of each drive
    gains: tuple[float, ...]  # force per unit of each drive's command, or of its signal without a command
    readings: Mapping[str, Path]  # displacement of which each sensor measures a derivative
    losses: tuple[str, ...]  # parts of the axis that cannot be expressed

    @property
    def roots(self) -> tuple[Body, ...]:
        """Bodies without a parent in the tree."""
        return tuple(b for b in self.bodies if _parent_in_tree(b) is None)

    def children(self, body: Body) -> tuple[Body, ...]:
        """Bodies whose parent in the tree is the given one."""
        return tuple(b for b in self.bodies if _parent_in_tree(b) == body)

    def inertial(self, body: Body) -> Inertial:
        """Inertia of a body, at least a tiny one, which simulators require where an armature holds the inertia.

        The centre of mass of a pendulum is below its hinge; half of the inertia about the hinge is that about the
        centre.
        """
        inertia, moment = max(self.inertia[body.name], _NO_MASS), self.moments.get(body.name, 0.0)
        if not moment:
            return Inertial(inertia, 0.0, inertia)
        mass = 2 * moment**2 / inertia
        return Inertial(mass, -moment / mass, inertia / 2)

    def moves_freely(self, body: Body) -> bool:
        """Whether a body is part of the tree and has its own frame."""
        return body.geared is None and bool(self.inertia[body.name])


def mechanism(axis: Axis, values: Mapping[str, float]) -> Mechanism:
    """The axis as inertias and simple properties.

    >>> from symid.axis import load_axis
    >>> found = mechanism(load_axis("rigid_1m"), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> found.paths[(("motor", 1.0),)].frictionloss
    20.0
    """
    require_physical(axis, values)
    return _Collector(axis, values).mechanism()


def is_joint(path: Path) -> bool:
    """Whether a path is the joint of a single body."""
    return len(path) == 1 and path[0][1] == 1.0


def _parent_in_tree(body: Body) -> Body | None:
    """Parent of a body: the free body that carries it, or that turns the geared body that carries it."""
    gears = body.on.gears if isinstance(body.on, Body) else ()
    return gears[0].to if gears else body.parent


def _upwards(body: Body, parent: Callable[[Body], Body | None]) -> list[Body]:
    """A body and its ancestors."""
    line = [body]
    while (above := parent(line[-1])) is not None:
        line.append(above)
    return line


class _Collector:
    def __init__(self, axis: Axis, values: Mapping[str, float]) -> None:
        self.axis, self.values = axis, axis.with_known_values(values)
        self.kinematics = Kinematics(axis)
        self.paths: dict[Path, Properties] = {}
        self.plays: list[Play] = []
        self.losses: list[str] = []
        self.moments: dict[str, float] = {}

    def mechanism(self) -> Mechanism:
        """The mechanism of all elements of the axis."""
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
        """Add a property along a path; along a single joint with a ratio, it becomes a property of that joint."""
        if len(path) == 1:
            ((body, ratio),) = path
            power = {"stiffness": 2, "damping": 2, "armature": 2, "cubic": 4, "drag": 3}.get(name, 1)
            path = ((body, 1.0),)
            value *= ratio if name == "constant" else abs(ratio) ** power
        properties = self.paths.get(path, Properties())
        self.paths[path] = replace(properties, **{name: getattr(properties, name) + value})

    def _check_coupling(self, body: Body, path: Path) -> None:
        """SettingError if a body couples joints that are not nested: MuJoCo cannot couple the inertia of these."""
        moved = [b for b in self.axis.free_bodies if b.name in dict(path)]
        lines = [_upwards(moving, _parent_in_tree) for moving in moved]
        longest = max(lines, key=len)
        if not all(line[0] in longest for line in lines):
            raise SettingError(
                f"body {body.name!r} moves with {', '.join(name for name, _ in path)}, none of which carries "
                "the other: MuJoCo cannot couple their inertias; export this axis to C"
            )

    def _is_in_tree(self, body: Body) -> bool:
        """Whether the displacement of a body is the sum of the joints between it and the ground."""
        joints = {above.name: 1.0 for above in _upwards(body, lambda one: one.parent)}
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
