"""Preparation of a log for the estimation, and the differences that make rows of its signals."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.errors import SettingError
from symid.signal_processing import LowPass, central_difference, difference_factors, sparse_derivatives

DIFFERENCE_ORDER = 10
"""Order of accuracy of differences. Those of order 2, the paper's, lose 3 % of a fourth derivative at 0.028 of the
sampling frequency, and the loss differs between the columns; those of order 10 lose as much at 0.18 of it (measured on
nine axes: an error of Ms of 6 % against 0.00 %)."""
SHARPER = 4
"""Increment of the difference order in the sharper rows that rows are compared with."""
_SHARPER_WIDENING = 4.0
"""Widening of the motion in the nonlinear laws of these rows."""
LOW_PASSED = 0.5
"""Cutoff, over the Nyquist frequency of the rows, up to which rows of filtered signals need no filter of their own:
above that frequency the low-pass leaves a 256th. A sharp filter at the cutoff lets jumps of friction at rest ring for
ten rows (direct_2m1s with moves: 20 of 30 logs got a status for it)."""


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


@dataclass(frozen=True)
class Preparation:
    """Filter, differences, decimation and choice of rows. A setting that is None is chosen from the log.

    Parameters
    ----------
    cutoff_hz : float, optional
        Cutoff frequency of one pass of the zero-phase Butterworth filter.
    order : int
        Order of one pass.
    filter_force : bool
        Whether the force passes the same filter as the motion. False is the published recipe of EMPS; it biases
        flexible models, whose regressor holds derivatives of the force.
    decimation : int, optional
        Number of samples for each row. Rows pass MATLAB's filter first, unless all signals have passed a low-pass below
        half of the new Nyquist frequency, as they have where it is chosen.
    trim : tuple of int, optional
        Samples left out at the beginning and at the end.
    standstill : float, optional
        Speed below which rows do not enter equations with a law that jumps at standstill; 0 keeps all rows.
    late : mapping of str to float
        Seconds by which signals were recorded later than the others; they are moved back by it. A force that acts
        later than it is recorded has a negative value. Delays that the axis declares of its sensors need not be given.
    held : bool, optional
        Whether the force is held from sample to sample, so that it acts half a sample later than it is recorded, as
        its mean over a sample; as the axis declares it if not given.
    hold : float
        Seconds for which forces are held, over which they are averaged, without the half of it in `late`; it follows
        from `held`.
    difference_order : int
        Order of accuracy of the differences that take the place of derivatives, an even number; 2 is the paper's.
    coulomb : tuple of float, optional
        Coulomb friction beside the drive that is taken off the force before it is differentiated, in the force's unit,
        one for each of the model's `coulomb_at_drive`; found by iteration if not given. The empty tuple takes
        derivatives of friction as zero, as the paper does.
    widening : float, optional
        Times the cutoff up to which motion enters nonlinear laws, which are filtered at the cutoff afterwards: the
        reversals of friction then stay where they are. 1, as in the paper, filters both alike; if not given 2, and up
        to 4 as noise allows, where the force is filtered.
    """

    cutoff_hz: float | None = None
    order: int = 4
    filter_force: bool = True
    decimation: int | None = None
    trim: tuple[int, int] | None = None
    standstill: float | None = None
    late: Mapping[str, float] = field(default_factory=dict)
    held: bool | None = None
    hold: float = 0.0
    difference_order: int = DIFFERENCE_ORDER
    coulomb: tuple[float, ...] | None = None
    widening: float | None = None

    def __post_init__(self) -> None:
        if self.cutoff_hz is not None:
            LowPass(self.cutoff_hz, self.order)
        difference_factors(self.difference_order)
        for name, value, least in (
            ("decimation", self.decimation, 1),
            ("standstill", self.standstill, 0.0),
            ("widening", self.widening, 1.0),
        ):
            if value is not None and not (math.isfinite(value) and value >= least):
                raise SettingError(f"{name} is {value}: it must be at least {least:g}")
        if self.trim is not None and min(self.trim) < 0:
            raise SettingError(f"trim is {self.trim}: both numbers of samples must be 0 or more")

    def filtered_decimation(self, sampling_period: float) -> int:
        """Samples for each row if the decimation filter is needed, 1 if not."""
        assert self.cutoff_hz is not None
        factor = self.decimation or 1
        is_low_passed = self.filter_force and 2 * self.cutoff_hz * sampling_period * factor <= LOW_PASSED
        return 1 if is_low_passed else factor

    def is_held(self, model: GeneratedModel) -> bool:
        """Whether forces are held: as given, else as declared."""
        return model.held if self.held is None else self.held

    def with_hold(self, model: GeneratedModel, sampling_period: float) -> dict[str, float]:
        """Seconds by which the signals of a log were recorded late: as given, else as declared; a hold included."""
        late = {**model.delays, **self.late}
        half = sampling_period / 2 if self.is_held(model) else 0.0
        # a held force acts, on average, half the time of its hold after it is recorded
        return late | {force: late.get(force, 0.0) - half for force in model.forces if half}


def notes_on_declared(
    declared: Mapping[str, float],
    late: Mapping[str, float],
    passed_over: Sequence[str] = (),
    hold: float = 0.0,
) -> tuple[str, ...]:
    """Notes on declared delays that were compensated, and on imperfections that were ignored.

    A held force acts another `hold` seconds later.

    >>> notes_on_declared({"q": 3e-3, "F": -1e-3}, {"q": 3e-3, "F": -2e-3})
    ('q is read 3 ms late, as the axis declares: this is taken off',)
    >>> notes_on_declared({"F": -1e-3}, {"F": -1e-3})
    ('F acts 1 ms late, as the axis declares: this is taken off',)
    >>> notes_on_declared({}, {}, ["ForceLimit"])[0][:50]
    'ForceLimit is declared, but this method passes it '
    """
    notes = [
        f"{name} {'is read' if delay > 0 else 'acts'} {1e3 * abs(delay):.4g} ms late, as the axis declares: "
        "this is taken off"
        for name, delay in declared.items()
        if late.get(name) in (delay, delay - hold)
    ]
    if passed_over:
        one = len(passed_over) == 1
        notes.append(
            f"{' and '.join(passed_over)} {'is' if one else 'are'} declared, but this method passes "
            f"{'it' if one else 'them'} over: take `method=oe` with `controller`, which simulates "
            f"{'it' if one else 'them'}"
        )
    return tuple(notes)
