"""The path from the logged forces to the acting ones: gains and limits take from them, delays and lags follow."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import ComplexArray


@dataclass(frozen=True, eq=False)
class ForcePath:
    """What effects of drives and readings make of the outputs, of shape (n_outputs, n_bins) each.

    An output is predicted as response * p + withheld, where p is the prediction without these effects: for a force,
    the one that acts.
    """

    response: ComplexArray  # of delays and lags
    withheld: ComplexArray  # what gains and limits take from the logged forces

    def acting(self, measured: ComplexArray) -> ComplexArray:
        """Outputs at the end of the path from the measured ones.

        >>> path = ForcePath(np.array([[2 + 0j]]), np.array([[1 + 0j]]))
        >>> path.acting(np.array([[7 + 0j]]))
        array([[3.+0.j]])
        """
        return np.asarray((measured - self.withheld) / self.response)
