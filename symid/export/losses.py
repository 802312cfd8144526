"""What no export can carry, whatever its format."""

from __future__ import annotations

from collections.abc import Iterator

from symid.axis import Axis


def losses_of_signals(axis: Axis) -> Iterator[str]:
    """Values that belong to a log and not to the axis, and noise of the recorded force.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> list(losses_of_signals(load_axis("motor_bench")))
    ['Pt: it differs from log to log; give 0 for an axis whose zeros are known.']
    """
    for name in axis.log_parameters:
        yield f"{name}: it differs from log to log; give 0 for an axis whose zeros are known."
    if axis.only_drive.noise or axis.only_drive.resolution:
        yield f"{axis.only_drive.signal}: noise and resolution of the recorded force are left out."
