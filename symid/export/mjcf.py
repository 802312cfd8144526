"""An axis as a MuJoCo model: slides and hinges, joint and tendon properties, actuators and sensors.

Every free body has one slide along x or one hinge about x. A force in the joint of one body becomes a property of the
joint; a force between bodies, or on a geared body, becomes a fixed tendon, a linear combination of joints.
"""

import math
from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

from symid.axis import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    Body,
    Drive,
    ForceLimit,
    MotionSensor,
    PendulumWeight,
    Sensor,
)
from symid.errors import SettingError
from symid.export.exported import Exported, TextTarget, losses_of_imperfections, losses_of_signals
from symid.export.mechanism import Mechanism, Path, is_joint, mechanism
from symid.simulation import plant_of

_TEMPLATE = """\
<mujoco model="{name}">
{notes}  <compiler angle="radian"/>
  <option timestep="{timestep:.3g}" integrator="implicitfast" gravity="0 0 {gravity}">
    <flag contact="disable"/>
  </option>
  <worldbody>
{bodies}
  </worldbody>
{tendons}  <actuator>
{actuators}
  </actuator>
  <sensor>
{sensors}
  </sensor>
</mujoco>
"""

_LONGEST_STEP = 2.5e-4  # s
_STEPS_A_RADIAN = 20  # of the fastest motion
_SITE = 0.05  # half the side of the boxes that are drawn, m; they have neither mass nor contact

_SOFT = (
    "Coulomb friction: MuJoCo's friction constraint is soft, so a joint at rest creeps instead of sticking; "
    "solreffriction and solimpfriction are as hard as the time step allows."
)


def mjcf(axis: Axis, values: Mapping[str, float]) -> Exported:
    """MuJoCo model of an axis.

    Parameters
    ----------
    axis : Axis
        The axis; laws that MuJoCo cannot express become losses.
    values : mapping of str to float
        Physical parameters, SI.

    Raises
    ------
    SettingError
        If a parameter is missing, a mass is not positive, or a body has no mass.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> exported = mjcf(load_axis("rigid_1m"), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> 'damping="200"' in exported.text, 'frictionloss="20"' in exported.text
    (True, True)
    """
    if nodes := [b.name for b in axis.free_bodies if axis.known_parameters.get(b.inertial) == 0]:
        raise SettingError(
            f"MuJoCo has no bodies without mass ({', '.join(nodes)}): give each a mass, or declare the springs beside "
            "them as one"
        )
    fastest = 2 * math.pi * plant_of(axis, values).highest_mode  # rad/s
    timestep = min(_LONGEST_STEP, 1 / (_STEPS_A_RADIAN * max(fastest, 1.0)))
    return _Writer(axis, mechanism(axis, values), timestep).exported()


class _Writer:
    """Writes the parts of a model; tendons are collected as they are needed."""

    def __init__(self, axis: Axis, machine: Mechanism, timestep: float) -> None:
        self.axis, self.machine, self.timestep = axis, machine, timestep
        self.tendons: dict[Path, str] = {}
        self.losses = [*machine.losses, *losses_of_signals(axis)]
        # Of the imperfections, MuJoCo has delay, limit and one lag of each drive.
        for drive in axis.drives:
            lags = (e for e in axis.imperfections_of(drive) if isinstance(e, ActuatorLag))
            self.losses += [
                f"ActuatorLag: MuJoCo has one for each actuator, the slowest; left out: {lag.formula}."
                for lag in sorted(lags, key=lambda lag: lag.seconds)[:-1]
            ]
        self.losses += losses_of_imperfections(axis, "MuJoCo", (ActuatorDelay, ActuatorLag, ForceLimit))
        if any(p.frictionloss for p in machine.paths.values()):
            self.losses.append(_SOFT)

    def exported(self) -> Exported:
        """The model as text, with its losses."""
        bodies = "\n".join(self._body(b, 2) for b in self.machine.roots)
        driven = zip(self.axis.drives, self.machine.drives, self.machine.gains, strict=True)
        motors = [self._motor(drive, path, gain) for drive, path, gain in driven]
        actuators = "\n".join(["    " + line for line in (*motors, *self._constants())])
        sensors = "\n".join("    " + line for s in self.axis.sensors for line in self._sensor(s))
        gravity = next((-e.acceleration for e in self.axis.elements if isinstance(e, PendulumWeight)), 0.0)
        text = _TEMPLATE.format(
            name=self.axis.name,
            timestep=self.timestep,
            gravity=_written(gravity),
            bodies=bodies,
            tendons=self._tendons(),
            actuators=actuators,
            sensors=sensors,
            notes="".join(f"  <!-- {line} -->\n" for line in self._notes()),  # last: all losses are known
        )
        return Exported({".xml": text}, tuple(self.losses))

    def _notes(self) -> list[str]:
        sent = (f"ctrl[{i}] is {d.command or d.signal}" for i, d in enumerate(self.axis.drives))
        ctrl = f"{', '.join(sent)}; actuators named constant_... need no ctrl."
        units = "Exported by symid. SI units; slides along x, hinges about x."
        return [units, ctrl, *(f"Lost: {loss}".replace("--", "- -") for loss in self.losses)]

    def _body(self, body: Body, depth: int) -> str:
        indent, mass = "  " * depth, self.machine.inertial(body)
        inertia = " ".join([_written(mass.inertia)] * 3)
        kind = "hinge" if body.turns else "slide"
        inner = [
            f'<joint name={quoteattr(body.name)} type="{kind}" axis="1 0 0"{self._properties(((body.name, 1.0),))}/>',
            f'<inertial pos="0 0 {_written(mass.height)}" mass="{_written(mass.mass)}" diaginertia="{inertia}"/>',
            f'<geom type="box" size="{_SITE} {_SITE} {_SITE}" mass="0" contype="0" conaffinity="0"/>',
            f'<site name={quoteattr(body.name)} size="0.01"/>',
        ]
        carried = [self._body(b, depth + 1) for b in self.machine.children(body)]
        lines = [f"{indent}<body name={quoteattr(body.name)}>", *(f"{indent}  {line}" for line in inner)]
        return "\n".join([*lines, *carried, f"{indent}</body>"])

    def _properties(self, path: Path) -> str:
        """Attributes of a joint or tendon."""
        properties = self.machine.paths.get(path)
        if properties is None:
            return ""
        words = {
            "armature": [properties.armature],
            "stiffness": [properties.stiffness, 0.0, properties.cubic]
            if properties.cubic
            else [properties.stiffness],
            "damping": [properties.damping, properties.drag] if properties.drag else [properties.damping],
            "frictionloss": [properties.frictionloss],
        }
        written = {
            name: " ".join(f"{_written(x)}" for x in numbers)
            for name, numbers in words.items()
            if any(numbers)
        }
        if properties.frictionloss:
            written["solreffriction"] = f"{2 * self.timestep:.3g} 1"
            written["solimpfriction"] = "0.99 0.9999 0.001"
        return "".join(f' {name}="{text}"' for name, text in written.items())

    def _tendon(self, path: Path) -> str:
        """Name of the tendon along a path, which is created if necessary."""
        return self.tendons.setdefault(path, "_".join([body for body, _ in path]) + f"_{len(self.tendons)}")

    def _tendons(self) -> str:
        for path in self.machine.paths:
            if not is_joint(path):
                self._tendon(path)
        lines = []
        for path, name in self.tendons.items():
            lines += _fixed(name, path, self._properties(path))
        for i, play in enumerate(self.machine.plays):
            edge = f"{_written(play.gap / 2)}"
            spring = f' stiffness="{_written(play.stiffness)}" springlength="-{edge} {edge}"'
            lines += _fixed(f"play_{i}", play.path, spring)
        return "\n".join(["  <tendon>", *lines, "  </tendon>\n"]) if lines else ""

    def _transmission(self, path: Path) -> tuple[str, float]:
        """Attribute of the joint or tendon along a path, and the ratio of the path to it."""
        if len(path) == 1:
            return f"joint={quoteattr(path[0][0])}", path[0][1]
        return f"tendon={quoteattr(self._tendon(path))}", 1.0

    def _motor(self, drive: Drive, path: Path, gain: float) -> str:
        axis, (where, ratio) = self.axis, self._transmission(path)
        name = quoteattr(drive.command or drive.signal)
        words = f'name={name} {where} gear="{_written(ratio * gain)}"'
        imperfections = axis.imperfections_of(drive)
        lags = [e.seconds for e in imperfections if isinstance(e, ActuatorLag)]
        limits = [e.force / abs(drive.factor) for e in imperfections if isinstance(e, ForceLimit)]
        delay = sum(e.seconds for e in imperfections if isinstance(e, ActuatorDelay))
        if limits:
            edge = _written(min(limits))
            words += f' ctrllimited="true" ctrlrange="-{edge} {edge}"'
        if delay:
            words += f' delay="{_written(delay)}" nsample="{math.ceil(delay / self.timestep) + 2}"'
        if lags:
            return f'<general {words} dyntype="filterexact" dynprm="{_written(max(lags))}"/>'
        return f"<motor {words}/>"

    def _constants(self) -> list[str]:
        """Constant forces, as actuators with a bias only."""
        lines = []
        for path, properties in self.machine.paths.items():
            if properties.constant:
                where, ratio = self._transmission(path)
                name = "constant_" + "_".join(body for body, _ in path)
                lines.append(
                    f'<general name={quoteattr(name)} {where} gear="{_written(ratio)}" gainprm="0" biastype="affine" '
                    f'biasprm="{_written(properties.constant)} 0 0"/>'
                )
        return lines

    def _sensor(self, sensor: Sensor) -> list[str]:
        settings = f' noise="{_written(sensor.noise)}"' if sensor.noise else ""
        if sensor.delay:
            samples = math.ceil(sensor.delay / self.timestep) + 2
            settings += f' delay="{_written(sensor.delay)}" nsample="{samples}"'
        if sensor.noise:
            self.losses.append(f"{sensor.signal}: MuJoCo notes its noise but does not add it.")
        if sensor.resolution:
            self.losses.append(f"{sensor.signal}: MuJoCo's sensors have no resolution.")
        if sensor.is_scaled:
            self.losses.append(
                f"{sensor.signal}: the {sensor.quantity}, without gain and offset of the sensor."
            )
        name = f"name={quoteattr(sensor.signal)}"
        if not isinstance(sensor, MotionSensor):
            return self._force(sensor, name, settings)
        if sensor.derivative == 2:
            return self._acceleration(sensor, settings)
        path = self.machine.readings[sensor.signal]
        quantity = ("pos", "vel")[sensor.derivative]
        if is_joint(path):
            return [f"<joint{quantity} {name} joint={quoteattr(path[0][0])}{settings}/>"]
        return [f"<tendon{quantity} {name} tendon={quoteattr(self._tendon(path))}{settings}/>"]

    def _force(self, sensor: Sensor, name: str, settings: str) -> list[str]:
        """Force of the actuator; MuJoCo has no sensor of a spring in a joint or tendon."""
        if isinstance(drive := sensor.element, Drive):
            return [f"<actuatorfrc {name} actuator={quoteattr(drive.command or drive.signal)}{settings}/>"]
        self.losses.append(f"{sensor.signal}: MuJoCo has no sensor of the force in a spring.")
        return []

    def _acceleration(self, sensor: MotionSensor, settings: str) -> list[str]:
        """Accelerations of sites are absolute and have three components."""
        kind = "frameangacc" if sensor.body.turns else "framelinacc"
        places = {sensor.signal: sensor.body}
        if isinstance(sensor.reference, Body):
            first, second = (f"{sensor.signal}_{body.name}" for body in (sensor.body, sensor.reference))
            places = {first: sensor.body, second: sensor.reference}
            self.losses.append(
                f"{sensor.signal}: MuJoCo has no relative acceleration; subtract {second} from {first}."
            )
        hidden = [body.name for body in places.values() if not self.machine.moves_freely(body)]
        if hidden:
            self.losses.append(f"{sensor.signal}: {', '.join(hidden)} is geared and has no frame in MuJoCo.")
            return []
        self.losses.append(
            f"{sensor.signal}: a sensor of three components, of which the first is the reading."
        )
        return [
            f'<{kind} name={quoteattr(name)} objtype="site" objname={quoteattr(body.name)}{settings}/>'
            for name, body in places.items()
        ]


def _written(number: float) -> str:
    """A number with all digits, without a trailing ".0".

    >>> _written(200.0), _written(0.1)
    ('200', '0.1')
    """
    return repr(float(number)).removesuffix(".0")


def _fixed(name: str, path: Path, properties: str) -> list[str]:
    joints = (f'      <joint joint={quoteattr(body)} coef="{_written(factor)}"/>' for body, factor in path)
    return [f"    <fixed name={quoteattr(name)}{properties}>", *joints, "    </fixed>"]


TARGET = TextTarget("mjcf", "MuJoCo", mjcf)
