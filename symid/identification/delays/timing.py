"""Delay of a signal against the others: the one that leaves the least residual.

The rows W and y of a log depend on the force F linearly, so that those of F(t + tau) follow from those of F alone, and
so with every sensor that no friction law depends on. The delay tau and the parameters X minimise the weighted residual
of y(tau) - W(tau) X together, by Gauss-Newton steps: the derivative by tau is one more column, and the rows are
computed again for every tau, since a first-order term is not a shift. The last step's regression gives the deviation
of tau as that of any parameter, corrected for the correlation of the residual.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import delayed_together, scan
from symid.identification.delays.refined_delay import Delay, Shifting, beyond_feedback, refined
from symid.identification.parameters.physical import negative_parameters
from symid.identification.rows.excerpts import Excerpt


@dataclass(frozen=True, eq=False)
class Timing:
    """Estimated delay of a signal against the others."""

    signal: str
    """Name of the force, or of a sensor."""
    late: float
    """Seconds by which it seems recorded later than the motion, beyond what the preparation takes out; negative for
    a force that acts after it is recorded."""
    deviation: float
    """Standard deviation of `late`, s, corrected for the correlation of the residual; nan if not determined."""
    sampling_period: float
    """Time between two samples, s."""
    declared: float
    """Seconds of the same sign that the preparation has taken out already."""
    remaining: float
    """Residual with the delay taken out, as part of that without."""
    parameters: FloatArray
    """Minimal parameters with the delay taken out; shape (n_parameters,)."""
    moved: tuple[str, ...]
    """Signals that were moved to find it: this one, or all others."""
    is_force: bool = True
    """Whether the signal is the force, which may be held from sample to sample."""

    @property
    def samples(self) -> float:
        """Delay in samples, as `late`."""
        return self.late / self.sampling_period

    @property
    def is_significant(self) -> bool:
        """Whether there is a delay that noise does not explain."""
        return bool(abs(self.late) > CRITERIA.delay_certain * self.deviation and self.remaining < 1.0)

    @property
    def is_small(self) -> bool:
        """Whether the delay is a small part of a sample."""
        return abs(self.samples) <= CRITERIA.delay_noticeable

    @property
    def seems_held(self) -> bool:
        """Whether the delay is the half sample of a force that is held from sample to sample."""
        return self.is_force and self.declared == 0.0 and abs(self.samples + 0.5) < CRITERIA.delay_held

    @property
    def suggested(self) -> float:
        """`late` as whole or half samples, which are what clocks and holds make, unless it differs by 3 deviations."""
        round_number = round(2 * self.samples) * self.sampling_period / 2
        return (
            round_number
            if abs(self.late - round_number) < CRITERIA.delay_round * self.deviation
            else self.late
        )

    @property
    def may_be_clock(self) -> bool:
        """Whether a clock or a hold may be the cause: beyond what holds and lags do, it then leaves little."""
        least = (
            CRITERIA.delay_leaves if abs(self.late) < CRITERIA.delay_long else CRITERIA.delay_all_but_noise
        )
        return abs(self.samples) <= CRITERIA.delay_natural or self.remaining**2 < least

    @property
    def remedy(self) -> str:
        """The setting that removes the delay."""
        if self.seems_held:
            return f"`held` {self.signal}"
        return f"`late` {self.signal}={_microseconds(self.declared + self.suggested, 4)}us"

    @property
    def statement(self) -> str:
        """Statement of the delay, of what it may be, and its cure where it explains as much as a clock does."""
        when = "before it was" if self.late > 0 else "after it was"
        instead = " in place of the given value" if self.declared else ""
        others = (
            "a lag of the drive, a flexibility, friction that builds up after reversals and errors of a gear"
            if self.is_force
            else "a flexibility and play"
        )
        cause = (
            f"if clocks or a hold are the cause, give {self.remedy}{instead}; {others} can look alike"
            if self.may_be_clock
            else f"a late clock would leave less; {others} can look alike: run `symid diagnose`"
        )
        return (
            f"{self.signal} acts as if {abs(self.samples):.2f} samples ({_microseconds(abs(self.late), 4)} us, "
            f"standard deviation {_microseconds(self.deviation, 2)} us) {when} recorded, which biases all parameters "
            f"(without it, {100 * self.remaining:.3g} % of the residual remain): {cause}"
        )


def _microseconds(seconds: float, digits: int) -> str:
    """Microseconds without a power of ten.

    >>> _microseconds(-0.035, 4), _microseconds(1.23456e-4, 4)
    ('-35000', '123.5')
    """
    return np.format_float_positional(1e6 * seconds, digits, unique=False, fractional=False, trim="-")


def delays_of(model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> tuple[Timing, ...]:
    """Estimate the delay of the force, and of each sensor that can be moved, from the logs that were identified from.

    Every signal is first moved by up to a second, row by row; from where the residual is least, the delay is refined.

    Parameters
    ----------
    model : GeneratedModel
        The model identified.
    parts : sequence of Excerpt
        Logs or parts of them, with their observations.
    fit : LeastSquares
        The parameters, all determined.

    Returns
    -------
    tuple of Timing
        Those that the rows determine.
    """
    found = []
    for names in delayed_together(model):  # all others early is the one late that laws depend on
        signal = names[0] if len(names) == 1 else next(name for name in model.measured if name not in names)
        timing = _timing_of(model, parts, fit, names, signal)
        if timing:
            found.append(timing)
    return tuple(found)


def likeliest(delays: Sequence[Timing]) -> Timing | None:
    """The delay that explains most; that of the force if none is significant, None if that is not determined."""
    found = [
        timing for timing in delays if len(timing.moved) == 1 or timing.remaining < CRITERIA.delay_together
    ]
    certain = [timing for timing in found if timing.is_significant]
    of_force = [timing for timing in found if timing.is_force]
    if certain:
        # the force is what usually is late: a sensor must explain clearly more
        return min(certain, key=lambda t: t.remaining * (1.0 if t.is_force else CRITERIA.delay_preference))
    return of_force[0] if of_force else None


def _timing_of(
    model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares, names: tuple[str, ...], signal: str
) -> Timing | None:
    """Delay of a signal: of itself, or of all others, which are then early by it."""
    scanned = scan(parts, fit, names)
    late, left, there = scanned.best
    shifting = [Shifting(part, names) for part in parts]
    near = refined(parts, shifting, fit, 0.0)
    found: Delay | None
    # motion that repeats itself fits as well a period later: a delay near zero that explains as much comes first
    if left >= CRITERIA.delay_leaves or (
        near is not None and near.remaining**2 <= CRITERIA.delay_as_much * left
    ):
        found = near
    else:  # to a row, where it cannot be refined
        chosen = parts[0].observation.preparation
        row = parts[0].log.sampling_period * (chosen.decimation or 1)
        found = refined(parts, shifting, fit, late) or Delay(
            late, row / CRITERIA.rows_a_deviation, float(np.sqrt(left)), there
        )
    found = next((one for one in (found, near) if one and _keeps_signs(model, one.parameters, fit)), None)
    if found is None:
        return None
    if names[0] in model.forces and abs(found.late) > CRITERIA.delay_certain * found.deviation:
        found = beyond_feedback(parts, fit, names, found)
    return Timing(
        signal=signal,
        late=found.late if signal in names else -found.late,
        deviation=found.deviation,
        sampling_period=parts[0].log.sampling_period,
        declared=parts[0].observation.preparation.late.get(signal, 0.0),
        remaining=found.remaining,
        parameters=found.parameters,
        moved=names,
        is_force=signal in model.forces,
    )


def _keeps_signs(model: GeneratedModel, minimal: FloatArray, fit: LeastSquares) -> bool:
    """Whether no parameter that is positive without a delay is negative with it.

    Half a period late, a periodic motion is explained as well by an inertia or friction of the opposite sign.
    """
    return _least_negative(model, minimal) <= _least_negative(model, fit.solution)


def _least_negative(model: GeneratedModel, minimal: FloatArray) -> int:
    """Number of negative physical parameters in the best branch; 0 without a closed inverse map."""
    if model.physical_parameters is None:
        return 0
    with np.errstate(all="ignore"):
        branches = [model.physical_parameters(*minimal, branch=b) for b in range(model.branches)]
    return min(len(negative_parameters(model, physical)) for physical in branches)
