"""`tune_total`: cutoff and decimation with the smallest total error of the parameters, from bias and noise.

A bound on the systematic error alone asks for a high cutoff, and lets the noise in. Here the axis is simulated once
without noise, the noise of the log is added to it several times over, and each setting is judged by the mean square
error of the parameters that `identify` finds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Preparation
from symid.shown import Shown
from symid.tuning.bound import Track
from symid.tuning.exact_run import ExactRun
from symid.tuning.total_errors import TotalErrors

TotalStatus = Literal["ok", "not_determined"]

_CUTOFFS = 32
_MOST_EVALUATIONS = 8
_CANDIDATES = 5
"""Settings of the scan whose expected errors are confirmed by drawn noise."""
_MUCH_MORE = 1.5
"""Ratio of the drawn to the expected error that is rejected: 12 draws of one parameter scatter by 20 %."""
_HOPELESS = 0.8
"""A parameter whose error exceeds this at every cutoff does not decide."""


@dataclass(frozen=True, eq=False, repr=False)
class TotalTuning(Shown):
    """Settings with the smallest total error."""

    axis: str
    """Name of the axis."""
    measured: tuple[str, ...]
    """Signals of the sensors."""
    sampling_hz: float
    """Sampling frequency of the log."""
    preparation: Preparation
    """For `identify` of that log."""
    noise: Mapping[str, float]
    """Standard deviation of each signal's noise, SI."""
    systematic: Mapping[str, float]
    """Error of each parameter without noise, with its sign, percent."""
    total: Mapping[str, float]
    """Root mean square error of each parameter with noise, percent."""
    decisive: tuple[str, ...]
    """Parameters that decided: not lost (beyond 80 %) at every cutoff."""
    cutoffs_hz: FloatArray
    """Cutoffs of the scan; shape (n_points,)."""
    totals: FloatArray
    """Root mean square of the expected errors of the decisive parameters with the best decimation, percent; shape
    (n_points,)."""
    recommended_sampling_hz: float
    """Lowest sampling frequency at which, at the chosen cutoff, systematic errors are below half of the total
    error; nan if none is up to eight times that of the log."""
    status: TotalStatus
    """Either "ok", or "not_determined" where a parameter is lost."""
    message: str
    """Meaning of the status; empty for "ok"."""

    @property
    def headline(self) -> str:
        """Status, cutoff and total error."""
        settings = f"cutoff {self.preparation.cutoff_hz:.4g} Hz, total error {self.total_percent:.3g} %"
        return f"{self.axis} from {', '.join(self.measured)}, {self.status}: {settings}"

    @property
    def total_percent(self) -> float:
        """Root mean square of the total errors of the decisive parameters, percent."""
        return _rms([self.total[name] for name in self.decisive])


def tune_total(
    axis: Axis,
    model: GeneratedModel,
    parameters: Mapping[str, float],
    runs: Sequence[ExactRun],
    sampling_hz: float,
    noise: Mapping[str, float],
    *,
    preparation: Preparation | None = None,
    draws: int = 12,
    track: Track = iter,
) -> TotalTuning:
    """Cutoff and decimation that minimise the total error of the physical parameters.

    The measure is the root mean square, over parameters, of relative errors; those beyond 100 % count as 100 %, and
    parameters lost at every cutoff do not count. Cutoffs and decimations (1, and half, once and twice the usual one)
    are scanned with the errors expected to first order in the noise. The cutoffs of the best settings are refined by
    Nelder-Mead; the first of them whose errors on drawn noise agree with the expected ones is taken.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel
        Its model for the sensors.
    parameters : mapping of str to float
        Physical parameters with which the run was simulated, SI.
    runs : sequence of ExactRun
        Noise-free runs of the axis along the trajectory of the log. Errors at the reversals of friction depend
        on the smallest details of a motion; several runs that differ in them keep luck from looking like an optimum.
    sampling_hz : float
        Sampling frequency of the log.
    noise : mapping of str to float
        Standard deviation of the noise of each signal, as `noise_deviations` reads from a log.
    preparation : Preparation, optional
        Settings other than cutoff and decimation.
    draws : int
        Draws of noise for each setting that is confirmed.
    track : callable, optional
        Is given the cutoffs of the scan and passes them on, to show progress.

    Raises
    ------
    SettingError
        If a signal's noise is not given, or negative.

    Examples
    --------
    >>> from symid import load_axis, load_generated
    >>> from symid.simulation import chirp, plant_of, tuned_cascade
    >>> from symid.tuning import exact_run
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 30.0, "Fs": 4.0}
    >>> reference = chirp(0.5, 10.0, 2.0, 0.05, sampling_period=5e-4, quantity="velocity")
    >>> run = exact_run(axis, values, reference, tuned_cascade(plant_of(axis, values), "q"))
    >>> tuned = tune_total(axis, load_generated(axis), values, [run], 1000.0, {"q": 1e-7, "F": 1.0}, draws=4)
    >>> tuned.status, 10 < tuned.preparation.cutoff_hz < 400
    ('ok', True)
    """
    levels = _checked(model, noise)
    logs = tuple(run.log(sampling_hz, model.measured) for run in runs)
    errors = TotalErrors(model, logs, levels, parameters, draws)
    base = preparation or Preparation()
    # No signal of the noise-free run is late.
    plain = replace(base, late=dict.fromkeys(model.delays, 0.0), held=False)
    scan = _scan(errors, plain, track)
    decisive = np.min([rms for _, rms in scan], axis=0) < _HOPELESS
    counted = decisive if decisive.any() else np.ones_like(decisive)
    settings, total = _confirmed(errors, _ranked(scan, counted), counted)
    lost = [name for name, kept in zip(errors.names, decisive & (total < _HOPELESS), strict=True) if not kept]
    cutoffs = np.unique([setting.cutoff_hz for setting, _ in scan])
    best = [min(_rms(rms[counted]) for s, rms in scan if s.cutoff_hz == cutoff) for cutoff in cutoffs]
    return TotalTuning(
        axis=axis.name,
        measured=model.measured,
        sampling_hz=sampling_hz,
        preparation=replace(settings, late=base.late, held=base.held),
        noise=levels,
        systematic=_percent(errors.names, errors.relative(errors.clean, settings)),
        total=_percent(errors.names, total),
        decisive=tuple(name for name, counts in zip(errors.names, counted, strict=True) if counts),
        cutoffs_hz=cutoffs,
        totals=100.0 * np.array(best),
        recommended_sampling_hz=_recommended(errors, runs[0], settings, 0.5 * _rms(total[counted]), counted),
        status="not_determined" if lost else "ok",
        message=f"errors beyond 80 %, lost in noise or bias: {', '.join(lost)}" if lost else "",
    )


def _scan(errors: TotalErrors, plain: Preparation, track: Track) -> list[tuple[Preparation, FloatArray]]:
    """Expected errors of the parameters over cutoffs and decimations."""
    cutoffs = [float(f) for f in _cutoffs(errors.clean)]
    found = []
    for cutoff in track(cutoffs):
        usual = max(1, int(0.4 * errors.clean.sampling_frequency / cutoff))
        for factor in sorted({1, max(1, usual // 2), usual, 2 * usual}):
            settings = replace(plain, cutoff_hz=cutoff, decimation=factor)
            found.append((settings, errors.expected(settings)))
    return found


def _confirmed(
    errors: TotalErrors, candidates: Sequence[Preparation], counted: FloatArray
) -> tuple[Preparation, FloatArray]:
    """The first refined candidate whose drawn errors agree with the expected ones, and these; else the best one.

    The expected errors are of first order in the noise. Where noise decides which rows are near a reversal, errors are
    larger.
    """
    tried: list[tuple[Preparation, FloatArray]] = []
    for candidate in candidates:
        settings = _refined(errors, candidate, counted)
        tried.append((settings, errors.rms(settings)))
        if _rms(tried[-1][1][counted]) <= _MUCH_MORE * _rms(errors.expected(settings)[counted]):
            return tried[-1]
    return min(tried, key=lambda one: _rms(one[1][counted]))


def _ranked(scan: Sequence[tuple[Preparation, FloatArray]], counted: FloatArray) -> list[Preparation]:
    """Settings by total error, the best decimation of each cutoff; errors are averaged over adjacent cutoffs.

    A narrow dip between two high neighbours is the luck of rows that fall well before a reversal of friction, not an
    optimum: a cutoff is judged with the best of the next lower and of the next higher one, a quarter of weight each.
    """
    squares = np.array([_rms(rms[counted]) ** 2 for _, rms in scan])
    cutoffs, place = np.unique([setting.cutoff_hz for setting, _ in scan], return_inverse=True)
    best = np.array([squares[place == k].min() for k in range(cutoffs.size)])
    beside = np.pad(best, 1, mode="edge")
    total = 0.5 * squares + 0.25 * (beside[:-2] + beside[2:])[place]
    ranked = [scan[i][0] for i in np.argsort(total)]
    of_cutoff = {setting.cutoff_hz: setting for setting in reversed(ranked)}
    return [setting for setting in ranked if of_cutoff[setting.cutoff_hz] is setting][:_CANDIDATES]


def _checked(model: GeneratedModel, noise: Mapping[str, float]) -> dict[str, float]:
    needed = tuple(model.highest_derivatives)
    for name in needed:
        if name not in noise or not (math.isfinite(noise[name]) and noise[name] >= 0.0):
            raise SettingError(
                f"noise of {name} is {noise.get(name, 'not given')}: give a standard deviation of 0 or more for each "
                f"of {', '.join(needed)}"
            )
    return {name: noise[name] for name in needed}


def _cutoffs(clean: Log) -> FloatArray:
    """Cutoffs of the scan: from the one that trims a quarter of the data to 0.4 of the sampling frequency."""
    duration = clean.n_samples * clean.sampling_period
    highest = 0.4 * clean.sampling_frequency
    return np.geomspace(min(max(24.0 / duration, highest / 200), highest / 2), highest, _CUTOFFS)


def _refined(errors: TotalErrors, start: Preparation, counted: FloatArray) -> Preparation:
    """The best setting of the scan with its cutoff refined by Nelder-Mead as far as the next cutoffs of the scan."""
    assert start.cutoff_hz is not None
    first, cutoffs = start.cutoff_hz, _cutoffs(errors.clean)
    span = math.log(cutoffs[1] / cutoffs[0])
    seen: dict[float, float] = {}

    def total(offset: FloatArray) -> float:
        cutoff = min(first * math.exp(np.clip(offset[0], -span, span)), cutoffs[-1])
        if cutoff not in seen:
            seen[cutoff] = _rms(errors.expected(replace(start, cutoff_hz=cutoff))[counted])
        return seen[cutoff]

    scipy.optimize.minimize(
        total,
        np.zeros(1),
        method="Nelder-Mead",
        options={"initial_simplex": [[0.0], [0.5 * span]], "maxfev": _MOST_EVALUATIONS},
    )
    return replace(start, cutoff_hz=min(seen, key=seen.__getitem__))


def _recommended(
    errors: TotalErrors, run: ExactRun, settings: Preparation, allowed: float, counted: FloatArray
) -> float:
    """Lowest sampling frequency at which the systematic errors stay below half of the total errors."""
    assert settings.cutoff_hz is not None
    rates = np.geomspace(2.5 * settings.cutoff_hz, 8 * errors.clean.sampling_frequency, 12)
    plain = replace(settings, decimation=None)
    for rate in map(float, rates):
        systematic = errors.relative(run.log(rate, errors.model.measured), plain)
        if _rms(systematic[counted]) <= allowed:
            return rate
    return math.nan


def _rms(errors: Sequence[float] | FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def _percent(names: Sequence[str], errors: FloatArray) -> dict[str, float]:
    return {name: 100.0 * float(error) for name, error in zip(names, errors, strict=True)}
