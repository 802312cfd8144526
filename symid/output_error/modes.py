"""Natural frequencies of an axis: a sampled log tells those below half its sampling frequency from their aliases."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symid.simulation import ForwardDynamics


def natural_frequencies(dynamics: ForwardDynamics, parameters: Mapping[str, float]) -> list[float]:
    """Undamped natural frequencies in Hz, without the rigid motions.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import forward_dynamics
    >>> paper = {"Ms": 3899.0, "Fvs": 0.0, "Ks": 1e9, "Mm": 362.58, "Fvm": 0.0, "Fsm": 0.0}
    >>> [round(f, 1) for f in natural_frequencies(forward_dynamics(load_axis("direct_2m1s")), paper)]
    [80.6]
    """
    plant = dynamics.at(parameters)
    squares = np.linalg.eigvals(np.linalg.solve(plant.mass, plant.stiffness)).real
    floor = 1e-9 * max(squares.max(initial=0.0), 1e-12)
    return sorted(float(np.sqrt(w) / (2 * np.pi)) for w in squares if w > floor)


def highest_mode(dynamics: ForwardDynamics, parameters: Mapping[str, float]) -> float:
    """Highest natural frequency, Hz; 0 without springs."""
    return max(natural_frequencies(dynamics, parameters), default=0.0)
