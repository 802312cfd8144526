"""An axis as URDF: links with masses, prismatic and continuous joints with damping and friction.

URDF has no springs, drives or sensors; these become losses.
"""

from collections.abc import Iterator, Mapping
from xml.sax.saxutils import quoteattr

from symid.axis import Axis, Body
from symid.export.exported import Exported, TextTarget, losses_of_imperfections, losses_of_signals
from symid.export.mechanism import Mechanism, is_joint, mechanism

_WIDE = "1e9"  # limits that URDF requires of a prismatic joint
_HELD = ("damping", "frictionloss")
_LOST = ("stiffness", "cubic", "drag", "constant", "armature")


def urdf(axis: Axis, values: Mapping[str, float]) -> Exported:
    """URDF of an axis: slides along x, hinges about x, SI units.

    Parameters
    ----------
    axis : Axis
        The axis; parts that URDF cannot express become losses.
    values : mapping of str to float
        Physical parameters, SI.

    Raises
    ------
    SettingError
        If a parameter is missing, or no machine has the values.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> exported = urdf(load_axis("rigid_1m"), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> '<dynamics damping="200.0" friction="20.0"/>' in exported.text
    True
    """
    machine = mechanism(axis, values)
    losses = (*machine.losses, *losses_of_signals(axis), *_losses(axis, machine))
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(axis.name)}>"]
    lines.append("  <!-- Exported by symid. SI units; slides along x, hinges about x. -->")
    lines += [f"  <!-- Lost: {loss.replace('--', '- -')} -->" for loss in losses]
    lines += ['  <link name="ground"/>']
    for body in machine.roots:
        lines += _linked(machine, "ground", body)
    return Exported({".urdf": "\n".join([*lines, "</robot>", ""])}, losses)


def _linked(machine: Mechanism, parent: str, body: Body) -> Iterator[str]:
    """Link and joint of a body, then those of the bodies that it carries."""
    mass, height, inner = machine.inertial(body)
    properties = machine.paths.get(((body.name, 1.0),))
    damping, friction = (properties.damping, properties.frictionloss) if properties else (0.0, 0.0)
    yield f"  <link name={quoteattr(body.name)}>"
    yield f'    <inertial><origin xyz="0 0 {height!r}"/><mass value="{mass!r}"/>'
    yield f'      <inertia ixx="{inner!r}" iyy="{inner!r}" izz="{inner!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
    yield "  </link>"
    kind = "continuous" if body.turns else "prismatic"
    yield f'  <joint name={quoteattr(f"{body.name}_joint")} type="{kind}">'
    yield f'    <parent link={quoteattr(parent)}/><child link={quoteattr(body.name)}/><axis xyz="1 0 0"/>'
    if not body.turns:
        yield f'    <limit lower="-{_WIDE}" upper="{_WIDE}" effort="{_WIDE}" velocity="{_WIDE}"/>'
    yield f'    <dynamics damping="{damping!r}" friction="{friction!r}"/>'
    yield "  </joint>"
    for carried in machine.children(body):
        yield from _linked(machine, body.name, carried)


def _losses(axis: Axis, machine: Mechanism) -> Iterator[str]:
    """Parts of an axis that URDF cannot express."""
    yield f"{', '.join(d.signal for d in axis.drives)}: URDF has no drives; force acts on the joints."
    yield f"{', '.join(s.signal for s in axis.sensors)}: URDF has no sensors."
    for path, properties in machine.paths.items():
        held, among = (_LOST, "") if is_joint(path) else ((*_LOST, *_HELD), " between joints")
        where = " and ".join(body for body, _ in path)
        for name in held:
            if value := getattr(properties, name):
                yield f"{name} {value:.6g} of {where}, SI: URDF has none{among}."
    for play in machine.plays:
        yield f"play of {play.gap:.6g} m or rad: URDF has none."
    yield from losses_of_imperfections(axis, "URDF")


TARGET = TextTarget("urdf", "URDF", urdf)
