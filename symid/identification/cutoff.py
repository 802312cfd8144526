"""Choice of the cutoff: the given one, the one that the log suggests, or a better one nearby.

A cutoff is first chosen from spectra (`settings`). It is replaced where the estimate itself says more: by a lower one
where the model does not describe the band, by a higher one where reversals leave too few rows, and by that of the
smallest printed deviations where these are large. Too low a cutoff hides what distinguishes parameters, too high a one
lets noise into W.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import AnyLog
from symid.errors import SettingError
from symid.estimation import LeastSquares, Method, TriangularFactor, estimate, refine_blocks
from symid.identification.criteria import CRITERIA
from symid.identification.deviations.discrepancy import Discrepancy
from symid.identification.faults.poor_fit import unexplained
from symid.identification.results.identification_result import Identification
from symid.identification.results.status import poorly_fitted
from symid.identification.rows.bands import cutoff_range
from symid.identification.rows.coulomb import factors_without
from symid.identification.rows.excerpts import Excerpt, excerpts
from symid.identification.rows.observation import Observation
from symid.identification.rows.row_blocks import Run, blocks_of_runs
from symid.identification.rows.settings import Preparation

_SEARCHED = ("ok", "not_physical")
"""Statuses with which other cutoffs are tried: far below a mode its mass is lost, and comes out negative by chance."""
_MOST_COULOMB_ROUNDS = 6
"""Most rounds. The later ones extrapolate by secants: three or four suffice where the plain iteration halves its error
or diverges."""
_FLATTEST = 0.1
"""Slope of the secant between two rounds below which it is not extrapolated, because the step would be uncertain."""
_COULOMB_SETTLED = 0.005
"""Relative change of the friction that ends the rounds: the rest in the derivatives is below one per cent of the terms
that the paper drops."""
_CONDITION_THAT_COSTS_DIGITS = 1e4
_WINDOWS, _CUTOFFS = 64, 4
"""Windows of long logs, and cutoffs with the rows of these, that are kept."""
_MANY_ROWS = 1_000_000
"""Parameters are refined in extended precision where that costs no time, or where rounding has cost digits."""


@dataclass(frozen=True, eq=False)
class CutoffTrial:
    """Rows of each log, and the estimate from all of them."""

    runs: tuple[Run, ...]
    fit: LeastSquares


@dataclass(frozen=True, eq=False)
class Estimation:
    """The model to estimate, its logs and the method; parameters as in `identify`."""

    model: GeneratedModel
    logs: tuple[AnyLog, ...]
    preparation: Preparation
    method: Method
    ddof: int | None

    def trial(self) -> CutoffTrial:
        """Rows and estimate; where the cutoff is left open and the model does not describe the band, a lower one."""
        first = self._at([self.preparation] * len(self.logs))
        if not self.model.is_flexible or self.preparation.cutoff_hz is not None:
            return first
        if self.left(first) < CRITERIA.cutoff_fit and not self._is_drowned(first):
            return first
        tried, lefts = [first], [math.inf if self._is_drowned(first) else self.left(first)]
        for k in range(1, CRITERIA.lower_cutoffs + 1):
            found = self.scaled(first, CRITERIA.cutoff_step**-k)
            if found is None:
                break
            tried.append(found)
            lefts.append(math.inf if self._is_drowned(found) else self.left(found))
        if min(lefts) > CRITERIA.cutoff_fit:  # no cutoff helps: something else is wrong
            return first
        good = CRITERIA.little_more * min(lefts)
        return next(one for one, left in zip(tried, lefts, strict=True) if left <= good)

    def scaled(self, first: CutoffTrial, factor: float) -> CutoffTrial | None:
        """Rows and estimate at a multiple of the cutoffs of a trial; None where lower ones leave too few rows."""
        cutoffs = [factor * _cutoff(run) for run in first.runs]
        try:
            found = self._at([replace(self.preparation, cutoff_hz=float(f"{x:.3g}")) for x in cutoffs])
        except SettingError:
            return None
        least = CRITERIA.rows_left * found.fit.solution.size if factor < 1.0 else 0
        return found if min(found.fit.rows) >= least else None

    def widest(self, first: CutoffTrial) -> CutoffTrial:
        """Rows and estimate at the cutoff that leaves most rows: half a period of it is lost at each reversal."""
        if self.preparation.cutoff_hz is not None:
            return first
        others = [self.scaled(first, factor) for factor in _upward(self.highest(first, is_coherent=False))]
        return max([first, *filter(None, others)], key=lambda one: sum(one.fit.rows))

    def left(self, found: CutoffTrial) -> float:
        """Largest residual of an equation as part of its output, beyond noise; inf without all parameters."""
        if found.fit.status != "ok":
            return math.inf
        parts = self.parts_of(tuple(run.observation for run in found.runs))
        return float(np.max(unexplained(self.model, parts, found.fit)))

    @cached_property
    def parts_of(self) -> Callable[[tuple[Observation, ...]], tuple[Excerpt, ...]]:
        """Excerpts of the logs with their observations at some cutoff, which share their windows with other cutoffs."""
        window = lru_cache(maxsize=_WINDOWS)(lambda log, start, stop: log.window(start, stop))
        return lru_cache(maxsize=_CUTOFFS)(lambda seen: excerpts(self.model, self.logs, seen, window))

    def _is_drowned(self, found: CutoffTrial) -> bool:
        """Whether the residual of an equation is too large for any estimate at this cutoff, even if it is noise."""
        return found.fit.status == "ok" and bool(poorly_fitted(self.model, found.fit))

    def highest(self, first: CutoffTrial, *, is_coherent: bool = True) -> float:
        """Largest multiple of a trial's cutoffs that the logs allow, with forces and motion coherent or not."""
        order, place = self.preparation.difference_order, 1 if is_coherent else 2
        return min(
            cutoff_range(log, self.model, order)[place] / _cutoff(run)
            for log, run in zip(self.logs, first.runs, strict=True)
        )

    def _at(self, preparations: Sequence[Preparation]) -> CutoffTrial:
        """Rows and estimate; friction beside a differentiated force is subtracted from it, and found by secants."""
        model = self.model
        is_open = bool(model.coulomb_at_drive) and self.preparation.coulomb is None
        runs = tuple(
            Run.of(model, log, one, friction=is_open)
            for log, one in zip(self.logs, preparations, strict=True)
        )
        factors = [factor for run in runs for factor in run.factors()]
        if is_open:
            levels = self._levels(factors)
            factors = factors_without(model, factors, levels)
            runs = tuple(run.without(levels) for run in runs) if any(levels) else runs
        fit = estimate(factors, self.method, self.ddof)
        many = sum(fit.rows) >= _MANY_ROWS and fit.condition_number_scaled <= _CONDITION_THAT_COSTS_DIGITS
        if len(runs) == 1 and fit.status == "ok" and not many:
            fit = refine_blocks(blocks_of_runs(runs), fit)
        return CutoffTrial(runs, fit)

    def _levels(self, factors: Sequence[TriangularFactor]) -> tuple[float, ...]:
        """Levels of the friction beside drives, found by secants from the factors of rows with columns of it."""
        places = [parameter for _, parameter in self.model.coulomb_at_drive]
        # The level taken off a differentiated force must be the one that the estimate then finds: a fixed point, sought
        # by secants. Each evaluation is one small factorisation; the rows are not read again.
        taken, slope, before = np.zeros(len(places)), np.ones(len(places)), None
        for _ in range(_MOST_COULOMB_ROUNDS + 1):
            fit = estimate(factors_without(self.model, factors, taken.tolist()), self.method, self.ddof)
            levels = fit.solution[places]
            if before is not None:
                moved, risen = taken - before[0], levels - before[1]
                slope = 1.0 - np.divide(risen, moved, out=np.zeros_like(moved), where=moved != 0.0)
                slope = np.where(np.abs(slope) < _FLATTEST, np.copysign(_FLATTEST, slope), slope)
            better = np.maximum(taken + (levels - taken) / slope, 0.0)
            if fit.status != "ok" or np.all(np.abs(better - taken) <= _COULOMB_SETTLED * better):
                break
            before, taken = (taken, levels), better
        return tuple(map(float, taken))


def least_uncertain(
    estimation: Estimation, first: CutoffTrial, widened: Callable[[CutoffTrial], Identification]
) -> tuple[Identification, list[Identification]]:
    """Identification of a trial, or of one at another cutoff where that determines the parameters better.

    `widened` is the identification of a trial with all that widens its deviations. Those of all trials that describe
    the band are returned as well.
    """
    best = widened(first)
    tried = [best]
    few = sum(log.n_samples for log in estimation.logs) <= _MANY_ROWS
    is_open = estimation.preparation.cutoff_hz is None and few
    if is_open and best.status == "too_few_rows":  # half a period of the cutoff is lost at each reversal
        others = (estimation.scaled(first, f) for f in _upward(estimation.highest(first, is_coherent=False)))
        enough = ((one, widened(one)) for one in others if one is not None)
        first, best = next((pair for pair in enough if pair[1].status != "too_few_rows"), (first, best))
        tried = [best]
    is_precise = np.max(_relative_deviations(best), initial=0.0) <= CRITERIA.precise
    if not is_open or best.status not in _SEARCHED or is_precise:
        return best, tried
    # Higher cutoffs first; lower ones only if no higher one is better. A cutoff at which the model fits worse than at
    # the first does not count: its small deviations would hold for a wrong model.
    most_left = max(estimation.left(first), CRITERIA.cutoff_fit)
    for factors in (
        _upward(estimation.highest(first)),
        [CRITERIA.cutoff_step**-k for k in range(1, CRITERIA.lower_cutoffs + 1)],
    ):
        failed, before = 0, best
        for factor in factors:
            other = estimation.scaled(first, factor) if failed < CRITERIA.cutoff_failures else None
            if other is None:
                break
            failed += 1
            if estimation.left(other) > most_left:
                continue
            found = widened(other)
            tried.append(found)
            if _is_better(found, best):
                best, failed = found, 0
        if best is not before:
            break
    return best, tried


def _is_better(found: Identification, best: Identification) -> bool:
    """Whether deviations are clearly smaller than those of another cutoff, in their geometric or their arithmetic mean.

    The largest decide the arithmetic mean: by that, no known parameter is given up for one hardly known.
    """
    if found.status != "ok" or not best.physical:
        return False
    new, old = (np.maximum(_relative_deviations(one), CRITERIA.known_well) for one in (found, best))
    is_lower = _cutoff(found) < _cutoff(best)
    worth = CRITERIA.worth_a_lower_cutoff if is_lower else CRITERIA.worth_another_cutoff
    gives_up = np.any(new > CRITERIA.little_more * old)
    on_the_whole = np.exp(np.log(new).mean() - np.log(old).mean())
    return bool(
        on_the_whole < CRITERIA.worth_another_cutoff or (not gives_up and new.mean() < worth * old.mean())
    )


def disagreements_of(found: Identification, tried: Sequence[Identification]) -> tuple[Discrepancy, ...]:
    """Differences of the parameters at the next lower and higher cutoff that were tried, where one is certain.

    Estimates from more and from less of the same band agree where the model is right (J. A. Hausman, Econometrica 46,
    1978). What a controller makes of the encoder's noise, a filter of one signal or a missing mode make a bias that
    changes with the cutoff.
    """
    if not found.physical:
        return ()
    own = _cutoff(found)
    others = [one for one in tried if one.physical and _cutoff(one) != own]
    lower = max((one for one in others if _cutoff(one) < own), key=_cutoff, default=None)
    higher = min((one for one in others if _cutoff(one) > own), key=_cutoff, default=None)
    values, deviations = found.physical[0].parameters, found.physical_deviations
    seen = []
    for other in filter(None, (lower, higher)):
        change = np.abs(other.physical[0].parameters - values)
        certain = change > CRITERIA.cutoff_certain * np.maximum(deviations, other.physical_deviations)
        if np.any(certain & (change > CRITERIA.cutoff_change * np.abs(values)) & (deviations > 0.0)):
            minimal = (other.fit.solution - found.fit.solution)[None]
            seen.append(
                Discrepancy(
                    f"other values at {_cutoff(other):.3g} Hz", minimal, np.zeros((minimal.size,) * 2)
                )
            )
    return tuple(seen)


def _upward(highest: float) -> list[float]:
    """Factors of the cutoff, in equal ratios, up to the highest one.

    >>> _upward(3.0), _upward(0.9)
    ([1.6, 3.0], [])
    """
    steps = max(0, math.ceil(math.log(highest, CRITERIA.cutoff_step) - 0.5))
    return [min(CRITERIA.cutoff_step**k, highest) if k < steps else highest for k in range(1, steps + 1)]


def _relative_deviations(found: Identification) -> FloatArray:
    """Printed deviations of physical parameters relative to their values, at most 1, except for those that may be 0."""
    units, values = found.model.physical_units, np.array(list(found.physical_parameters.values()))
    counts = np.array([name not in found.model.signed for name in units], dtype=bool)[: values.size]
    counts &= np.isfinite(values)
    deviations, positive = found.physical_deviations[counts], np.maximum(values[counts], 0.0)
    sizes = np.divide(deviations, positive, out=np.ones_like(positive), where=deviations < positive)
    return np.asarray(sizes)


def _cutoff(found: Run | Identification) -> float:
    seen = found.observation if isinstance(found, Run) else found.observations[0]
    assert seen.preparation.cutoff_hz is not None
    return seen.preparation.cutoff_hz
