"""The symbolic pipeline: from a declared axis to its minimal model and parameter map."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from symid.axis import Axis, of_any_axis
from symid.shown import Shown
from symid.symbolic.elimination import eliminate
from symid.symbolic.lagrange import inverse_dynamics
from symid.symbolic.minimal import MinimalModel, minimise
from symid.symbolic.parameter_map import ParameterMap, parameter_map


@dataclass(frozen=True, repr=False)
class DerivedModel(Shown):
    """Everything that follows from an axis and a set of sensors."""

    axis: Axis
    """The declaration."""
    measured: tuple[str, ...]
    """Signals of the sensors used, in the order of the declaration."""
    minimal: MinimalModel
    """Minimal model; its `source` leads back to the eliminated and to Lagrange's equations."""

    @property
    def headline(self) -> str:
        """Axis, sensors and size."""
        return f"{self.axis.name} from {', '.join(self.measured)}: {len(self.minimal.parameters)} minimal parameters"

    def __str__(self) -> str:
        """The minimal model, one equation per line."""
        heading = f"{self.axis.name} from {', '.join(self.measured)}"
        return "\n".join([heading, *(f"    {equation}" for equation in self.minimal.written)])

    @cached_property
    def parameter_map(self) -> ParameterMap:
        """Maps between minimal and physical parameters."""
        return parameter_map(self.minimal)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions made in the derivation."""
        return self.minimal.source.assumptions


@of_any_axis
def derive(axis: Axis, measured: Sequence[str] | None = None) -> DerivedModel:
    """Derive the minimal identification model of an axis.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    measured : sequence of str, optional
        Signals of the sensors to use; by default the required ones, which for one drive is the first sensor.

    Raises
    ------
    EliminationError
        If the sensors do not suffice; the message names the element and a sensor that would help.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> print(derive(load_axis("rigid_1m")))
    rigid_1m from q
        F = X1*(q_d2) + X2*(q_d1) + X3*(sign(q_d1))
    """
    sensors = axis.measured(measured)
    dynamics = inverse_dynamics(axis)
    eliminated = eliminate(dynamics, sensors)
    minimal = minimise(eliminated)
    return DerivedModel(axis, tuple(sensor.signal for sensor in sensors), minimal)
