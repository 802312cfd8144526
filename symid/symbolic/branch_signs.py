"""Second solutions of an inverse map, and whether they have the declared signs.

A quadratic step of the map has two solutions. Masses, stiffnesses and frictions are positive; the second solution
usually violates this. To decide, both are evaluated at parameters drawn over the whole range of machine axes.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

_DRAWS = 400
_RARE = 0.01
"""Share of the draws below which a second solution with the right signs does not matter in practice."""
_RANGES: Mapping[str, tuple[float, float]] = {
    "kg": (0.0, 3.5),
    "kg*m^2": (-4.0, 1.0),
    "N*s/m": (1.0, 4.0),
    "N*m*s/rad": (-4.0, 0.0),
    "N/m": (6.0, 9.0),
    "N*m/rad": (2.0, 5.0),
}
"""Range of the parameters of machine axes by unit, as powers of ten; 1 to 1000 for other units."""


def other_solutions_are_unphysical(
    minimal: Mapping[str, sp.Expr],
    inverse: Sequence[Mapping[str, sp.Expr]],
    units: Mapping[str, str],
    signed: Sequence[str],
) -> bool:
    """Whether almost no machine has a second solution in which all parameters have the required signs.

    `minimal` gives the minimal parameters in terms of the physical ones, `inverse` the physical ones of each solution
    in terms of the minimal ones. Parameters in `signed` may be negative.
    """
    names = list(units)
    generator = np.random.default_rng(0)
    truth = [10 ** generator.uniform(*_RANGES.get(unit, (0.0, 3.0)), _DRAWS) for unit in units.values()]
    forward = sp.lambdify(sp.symbols(names), list(minimal.values()), "numpy")
    values = [np.broadcast_to(np.asarray(x, dtype=complex), _DRAWS) for x in forward(*truth)]
    seconds = np.zeros(_DRAWS)
    for branch in inverse:
        known = [name for name in names if name in branch]
        solve = sp.lambdify(sp.symbols(list(minimal)), [branch[name] for name in known], "numpy")
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solved = [np.broadcast_to(np.asarray(x, dtype=complex), _DRAWS) for x in solve(*values)]
        admissible, same = np.ones((2, _DRAWS), dtype=bool)
        for name, value in zip(known, solved, strict=True):
            true = truth[names.index(name)]
            admissible &= (np.abs(value.imag) < 1e-6 * np.abs(true)) & ((value.real > 0) | (name in signed))
            same &= np.abs(value - true) < 1e-3 * np.abs(true)
        seconds += admissible & ~same
    return bool(np.mean(seconds > 0) < _RARE)
