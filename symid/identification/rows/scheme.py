"""Differences that make rows of recorded signals, and sharper ones for comparison."""

from __future__ import annotations

from dataclasses import dataclass

from symid.arrays import FloatArray
from symid.data import central_difference, sparse_derivatives

DIFFERENCE_ORDER = 10
"""Order of accuracy of differences. Those of order 2, the paper's, lose 3 % of a fourth derivative at 0.028 of the
sampling frequency, and the loss differs between the columns; those of order 10 lose as much at 0.18 of it (measured on
nine axes: an error of Ms of 6 % against 0.00 %)."""
SHARPER = 4
"""Increment of the difference order in the sharper rows that rows are compared with."""
_SHARPER_WIDENING = 4.0
"""Widening of the motion in the nonlinear laws of these rows."""


@dataclass(frozen=True)
class Scheme:
    """Scheme of derivatives and of the values of nonlinear laws."""

    # order of accuracy of the central differences; higher derivatives are taken one after the other
    order: int
    # multiple of the cutoff at which motion is filtered before nonlinear laws are evaluated, which are filtered
    # at the cutoff afterwards. Beyond 1, reversals stay where they were in the laws that jump there
    widening: float = 1.0

    @property
    def reach(self) -> int:
        """Samples on either side that a difference needs."""
        return self.order // 2

    def difference(self, x: FloatArray, sampling_period: float) -> FloatArray:
        """First derivative of a vector of samples at each of them."""
        return central_difference(x, sampling_period, order=self.order)

    def derivatives_at(self, x: FloatArray, period: float, highest: int, kept: slice) -> list[FloatArray]:
        """Derivatives of the orders 0 to `highest` at kept samples of a vector."""
        return sparse_derivatives(x, period, highest, kept, accuracy=self.order)


def sharper(order: int) -> Scheme:
    """Scheme with which rows of differences of an order are compared."""
    return Scheme(max(order + SHARPER, DIFFERENCE_ORDER), _SHARPER_WIDENING)
