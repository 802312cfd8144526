"""The machines, each with its cases."""

from collections.abc import Callable, Iterable, Iterator

from .case import Case
from .joints import lift, motor, robot, servo, shoulder
from .limbs import arm, axes
from .rigs import bench, emps, pendulum

MACHINES: dict[str, Callable[[], Iterator[Case]]] = {
    "emps": emps,
    "bench": bench,
    "pendulum": pendulum,
    "robot": robot,
    "servo": servo,
    "motor": motor,
    "shoulder": shoulder,
    "lift": lift,
    "axes": axes,
    "arm": arm,
}


def cases(wanted: Iterable[str] = ()) -> Iterator[Case]:
    """Cases whose names begin with one of those wanted; all if none is.

    Raises
    ------
    SystemExit
        If no case begins with a name.
    """
    names = tuple(wanted)
    unknown = [name for name in names if name.split("-")[0] not in MACHINES]
    if unknown:
        raise SystemExit(f"no case begins with {unknown[0]!r}; machines: {', '.join(MACHINES)}")
    for machine, declared in MACHINES.items():
        if not names or any(name.startswith(machine) for name in names):
            yield from (case for case in declared() if not names or case.name.startswith(names))
