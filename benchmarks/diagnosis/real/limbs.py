"""The cases of joints that move with all others of a robot: an industrial one, and the arm of a service robot.

The other joints change inertia and weight of each, so that no law of the joint alone explains all of its force. Nothing
is published of these joints; what a plain script finds on the logs of the training holds on the one held out.
"""

from collections.abc import Iterator, Sequence

from symid import Axis, OffsetForce

from . import recordings
from .case import Case
from .joints import rigid
from .plain import Script
from .recordings import Recording

_WEIGHT = (("weight", "body"), ("offset_force", "body"))
_COULOMB = (("coulomb_friction", "body"),)


def axes() -> Iterator[Case]:
    """Axes 2 to 6 of the industrial robot, in units of the torque of the motor."""
    for axis, hangs, right, added in (
        (2, False, _WEIGHT, "offset"),
        (2, True, _COULOMB, "coulomb"),
        (3, False, _WEIGHT, "offset"),
        (4, False, _COULOMB, "coulomb"),
        (5, False, _WEIGHT, "offset"),
        (6, False, _COULOMB, "coulomb"),
    ):
        runs = [recordings.robot(which, axis) for which in "ACB"]
        yield _case(f"axes-{axis}", "tau", "qm", hangs, right, added, runs, 20.0)


def arm() -> Iterator[Case]:
    """Joints 1 and 2 of the service robot's arm, in units of the effort of the motor."""
    for joint, hangs, right, added in ((1, False, _COULOMB, "coulomb"), (2, True, _WEIGHT, "coulomb")):
        run = recordings.tiago(f"arm_{joint}_joint")
        parts = [run.between(10.0, 48.0), run.between(48.0, 67.0)]
        yield _case(f"arm-{joint}", "F", "q", hangs, right, added, parts, 3.0)


def _case(
    name: str,
    force: str,
    position: str,
    hangs: bool,
    right: tuple[tuple[str, str], ...],
    added: str,
    runs: Sequence[Recording],
    band_hz: float,
) -> Case:
    """A body with viscous friction, and a constant force if it `hangs`; the last run is held out."""
    plain = rigid("limb", (force, "N*m"), position, hangs=False)
    constant = (OffsetForce(plain.bodies[0], "OF"),) if hangs else ()
    axis = Axis("limb", (*plain.elements, *constant), plain.drive, plain.sensors)
    *training, held_out = runs
    base = ("inertia", "viscous", *(("offset",) if hangs else ()))
    return Case(
        name=f"{name}-{'hanging' if hangs else 'viscous'}",
        model=f"inertia, viscous friction{' and a constant force' if hangs else ''}",
        published="nothing; the plain script finds weight, as a constant force, and Coulomb friction",
        right=right,
        axis=axis,
        training=tuple(training),
        held_out=held_out,
        script=Script(force, position, base, (added,)),
        band_hz=band_hz,
    )
