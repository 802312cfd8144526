"""Discrimination between two causes: the expected log-odds of a motion for the true one.

For each motion, the axis with one cause predicts the readings; the other cause, with free values, is fitted to them.
The expected gain is that of the log-likelihood of the true cause over the other. A first estimate linearises the other
prediction in its values: half the square of the difference that its columns cannot explain. For the best few motions,
both causes are fitted to readings with the noise of the log. Gains are tempered as in `evidence`, and the smaller of
those with either cause as the true one counts.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.data import Log
from symid.diagnosis.effects import JointEffect, Key
from symid.diagnosis.experiment.candidates import Envelope, candidate_motions
from symid.diagnosis.findings.planned_experiment import Separation
from symid.diagnosis.fitting.applied import applied
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import State, with_errors
from symid.diagnosis.prediction.record import Record, record_of
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.priors import temperature
from symid.diagnosis.selection.step import Confirmed, SelectionStep
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import LogError
from symid.simulation import Trajectory

LEAST_LOG_ODDS = math.log(3.0)
"""Smallest expected log-odds of a useful motion."""
_MOST_SIMULATED = 6  # most promising motions
_GENTLER = (1.0, 0.7, 0.5, 0.3, 0.15)  # shares of the limits that are tried until the force suffices
_FORCE_MARGIN = 1.02  # of the largest force in the log
_LEAST_ROWS = 64  # with fewer, a motion separates nothing
_ALIKE = 0.02  # deviation of a ratio of two drives from 1 up to which it is 1
_ITERATIONS = 10  # of fits that begin at the truth or near it
_LeftBy = Callable[[State, State, Weighting], float]


@dataclass(frozen=True, eq=False)
class Rivals:
    """Two remaining causes, the more probable one first."""

    step: SelectionStep  # step of the search that found them
    pair: tuple[Confirmed, Confirmed]
    chance: float  # probability of the second, if one of the candidates is true

    @property
    def remains(self) -> bool:
        """Whether the second cause is still plausible."""
        return self.chance >= THRESHOLDS.indistinguishable

    @property
    def record(self) -> Record:
        """The log that was diagnosed."""
        return self.step.before.state.prediction.record

    @property
    def models(self) -> tuple[State, State]:
        """The axis with either cause."""
        return self.pair[0].fit.state, self.pair[1].fit.state

    @property
    def keys(self) -> tuple[Key, Key]:
        """Effect and place of either cause."""
        return self.pair[0].key, self.pair[1].key


@dataclass(frozen=True, eq=False)
class CandidateExperiment:
    """A motion, the expected readings with either cause, and the expected log-odds."""

    trajectory: Trajectory
    records: tuple[Record, ...]
    log_odds: float


def candidate_experiments(
    rivals: Rivals, envelope: Envelope, forces: Mapping[str, float]
) -> list[CandidateExperiment]:
    """Motions within the limits of the forces, reduced if necessary, the largest expected log-odds first."""
    found: dict[int, CandidateExperiment] = {}
    for share in _GENTLER:
        for i, trajectory in enumerate(candidate_motions(envelope.gentler(share))):
            if i in found:
                continue
            try:
                records = tuple(
                    simulated_readings(model, trajectory, rivals.record) for model in rivals.models
                )
            except LogError:  # too short
                continue
            needed = {name: max(np.abs(record.log[name]).max() for record in records) for name in forces}
            if all(needed[name] <= _FORCE_MARGIN * force for name, force in forces.items()):
                found[i] = CandidateExperiment(
                    trajectory, records, _expected_log_odds(rivals, records, _linear)
                )
    return sorted(found.values(), key=lambda trial: -trial.log_odds)


@dataclass(frozen=True)
class DriveRatio:
    """Position of a drive relative to that of the first one: factor and offset."""

    factor: float = 1.0
    offset: float = 0.0

    def of(self, trajectory: Trajectory) -> Trajectory:
        """Reference of the drive, from that of the first one."""
        return replace(
            trajectory,
            position=self.factor * trajectory.position + self.offset,
            velocity=self.factor * trajectory.velocity,
            acceleration=self.factor * trajectory.acceleration,
        )


def drive_ratios(like: Record) -> tuple[DriveRatio, ...]:
    """Motion of each drive relative to the first one, as in the log: equal, mirrored, geared, or at rest.

    Factors near 1 or -1 are set to these, so that a skew in the log is not commanded.
    """
    first, *others = (like.log[name] for name in like.driven)
    shares = [DriveRatio()]
    for other in others:
        factor = float(np.cov(first, other)[0, 1] / np.var(first, ddof=1))
        if abs(abs(factor) - 1.0) < _ALIKE:
            factor = math.copysign(1.0, factor)
        shares.append(DriveRatio(factor, float(np.mean(other) - factor * np.mean(first))))
    return tuple(shares)


def simulated_readings(model: State, trajectory: Trajectory, like: Record) -> Record:
    """Readings of an axis whose driven joints follow a trajectory, with the sensors and the noise of `like`."""
    rng, names = np.random.default_rng(0), (*like.driven, *like.outputs)
    levels = zip(names, like.noise, strict=True)
    noise = {name: level * rng.standard_normal(trajectory.n_samples) for name, level in levels}
    shares = zip(like.driven, drive_ratios(like), strict=True)
    paths = {name: share.of(trajectory).position for name, share in shares}
    exact = paths | {name: noise[name] for name in like.forces}
    first_seen = exact | {name: path + noise[name] for name, path in paths.items()}
    seen = record_of(like.dynamics, _log(first_seen, trajectory))
    # Forces and readings follow from the motion with the effects in joints; effects in drives and readings then act on
    # these predictions.
    moving = record_of(like.dynamics, _log(exact, trajectory), seen.motion_hz)
    of_joints = [item for item in model.placed if isinstance(item.effect, JointEffect)]
    prediction = applied(model, moving, placed=of_joints)[0].prediction
    for name, spectrum in zip(like.forces, prediction.outputs, strict=False):
        exact[name] = _samples(moving, spectrum)
    for name in like.readings:
        reading = prediction.response.plant.sensors[name]
        of_motion = np.sum(reading.at(1j * moving.omega) * prediction.displacements, axis=0)
        exact[name] = _samples(moving, of_motion + reading.drives @ prediction.outputs[: moving.n_drives])
    record = record_of(like.dynamics, _log(exact, trajectory), seen.motion_hz)
    predicted = record.measured - applied(model, record)[0].errors
    for name, spectrum in zip(like.outputs, predicted, strict=True):
        exact[name] = _samples(record, spectrum)
    noisy = {name: values + noise[name] for name, values in exact.items()}
    return record_of(like.dynamics, _log(noisy, trajectory), seen.motion_hz)


def _log(signals: Mapping[str, FloatArray], trajectory: Trajectory) -> Log:
    return Log.from_arrays(signals, sampling_period=trajectory.sampling_period, source=trajectory.name)


def _samples(record: Record, spectrum: ComplexArray) -> FloatArray:
    """A signal at the samples of the log."""
    padded = np.zeros(record.n_extended // 2 + 1, dtype=complex)
    padded[: record.n_bins] = spectrum
    return np.asarray(scipy.fft.irfft(padded, record.n_extended))[: record.log.n_samples]


def _expected_log_odds(rivals: Rivals, records: Sequence[Record], left: _LeftBy) -> float:
    """Expected log-odds for the true cause, in the less favourable case."""
    found = []
    for right, record in enumerate(records):
        truth, weighting = applied(rivals.models[right], record)
        if weighting.kept.sum() < _LEAST_ROWS:
            return 0.0
        gains = []
        for model in (rivals.models[1 - right], rivals.step.before.state):
            # A fit may end near the model's own values of the axis, or near those of the truth: both are tried.
            starts = (applied(model, record)[0], applied(truth, record, placed=model.placed)[0])
            least = min(left(start.weighted(weighting), truth, weighting) for start in starts)
            gains.append(0.5 * _rows(weighting) * least)
        over_other, over_none = gains
        own, other = (rivals.pair[i].placed.n_free for i in (right, 1 - right))
        tempered = temperature(over_none - THRESHOLDS.penalty * own)
        found.append((over_other - THRESHOLDS.penalty * (own - other)) / tempered)
    return min(found)


def separation(rivals: Rivals, right: int, noisy: Record, quiet: Record) -> Separation:
    """Separation of two causes by readings with cause `right` (0 or 1), with and without noise."""
    truth, weighting = applied(rivals.models[right], noisy)
    exact = applied(rivals.models[right], quiet)[0]
    own = fitted(exact.weighted(weighting), weighting, _ITERATIONS)
    other = rivals.models[1 - right]
    starts = (applied(other, quiet)[0], applied(exact, quiet, placed=other.placed)[0])
    fits = [fitted(start.weighted(weighting), weighting, _ITERATIONS) for start in starts]
    nearest = min(fits, key=lambda fit: fit.cost)
    kept, n = weighting.kept, _rows(weighting)
    apart = (nearest.left - own.left)[:, kept]
    floor = truth.prediction.noise_through(weighting.density)[:, None]
    (wrong, of_wrong), (correct, of_correct) = (_with_noise(fit, noisy, floor) for fit in (nearest, own))
    gain = 0.5 * n * math.log(np.mean((wrong + of_wrong)[:, kept]) / np.mean((correct + of_correct)[:, kept]))
    uneven = 0.25 * n * float(np.var((of_wrong - of_correct)[:, kept]))
    return Separation(gain, math.sqrt(n * float(np.mean(apart**2)) + uneven))


def _with_noise(quiet: Fit, noisy: Record, floor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Squared residuals of a model fitted to noiseless readings, and those of the noise alone, relative to a floor."""
    weighting = quiet.weighting
    state = applied(quiet.state, noisy)[0].weighted(weighting)
    noise = Fit(state, weighting).left - quiet.left
    return quiet.left**2 / floor, noise**2 / floor


def _rows(weighting: Weighting) -> float:
    """Number of independent values in the rows that are kept."""
    return float(weighting.kept.sum() * len(weighting.density) * weighting.record.freedom)


def _linear(model: State, truth: State, weighting: Weighting) -> float:
    """Logarithm of the increase of the noise's mean square by the part of the truth outside the model's columns."""
    apart = with_errors(model.weighted(weighting), model.errors - truth.errors)
    return math.log1p(Fit(apart, weighting).mean_square)


def _fitted(model: State, truth: State, weighting: Weighting) -> float:
    """Logarithm of the ratio of the mean squares of both, fitted to readings with noise."""
    model_left, truth_left = (
        fitted(state, weighting, _ITERATIONS).cost for state in (model, truth.weighted(weighting))
    )
    return math.log(model_left / truth_left)


def refined_by_fits(rivals: Rivals, trials: Sequence[CandidateExperiment]) -> list[CandidateExperiment]:
    """The best few motions with the log-odds of fits to noisy readings, best first.

    A motion is skipped if its linear estimate is below the result of another one.
    """
    found: list[CandidateExperiment] = []
    for trial in trials[:_MOST_SIMULATED]:
        if trial.log_odds > max([LEAST_LOG_ODDS, *(other.log_odds for other in found)]):
            fitted_odds = _expected_log_odds(rivals, trial.records, _fitted)
            found.append(replace(trial, log_odds=min(trial.log_odds, fitted_odds)))
    return sorted(found, key=lambda trial: -trial.log_odds)
