"""Discrimination between two causes: what the sensors would read with either, and how well a motion parts them.

Each motion is taken as done: the axis with one cause says what the sensors would read, and the gain of the logarithm of
the likelihood is expected that this cause would have over the other, whose values are free. At first the other's
prediction is taken as linear in its values: half the square of what its columns leave of the difference. The few best
motions are then tried: readings with the noise of the log, and both causes fitted to them. Gains are tempered as in
`evidence`, and a motion is as good as the less favourable of both cases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.data import Log
from symid.diagnosis.effects import JointEffect, Key
from symid.diagnosis.experiment.candidates import Envelope, candidate_motions
from symid.diagnosis.fitting.applied import applied
from symid.diagnosis.fitting.fit import Fit, fitted
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.record import Record, record_of
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.priors import temperature
from symid.diagnosis.selection.step import Confirmed, SelectionStep
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import LogError
from symid.simulation import Trajectory

LEAST_LOG_ODDS = math.log(3.0)
"""Expected of a motion that is worth its time."""
_REHEARSED = 6
_GENTLER = (1.0, 0.7, 0.5, 0.3, 0.15)
_FORCE_MARGIN = 1.02
_LEAST_ROWS = 64
_ALIKE = 0.02
_ITERATIONS = 10
_Judge = Callable[[State, State, Weighting], float]


@dataclass(frozen=True, eq=False)
class Rivals:
    """Two causes that remain, the more probable one first."""

    step: SelectionStep  # of the search, in which they were found
    pair: tuple[Confirmed, Confirmed]  # both
    chance: float  # probability of the second, if one of the candidates is right

    @property
    def remains(self) -> bool:
        """Whether the log leaves doubt."""
        return self.chance >= THRESHOLDS.indistinguishable

    @property
    def record(self) -> Record:
        """The log so far."""
        return self.step.before.state.prediction.record

    @property
    def models(self) -> tuple[State, State]:
        """The axis with either."""
        return self.pair[0].fit.state, self.pair[1].fit.state

    @property
    def keys(self) -> tuple[Key, Key]:
        """Names of effects and places."""
        return self.pair[0].key, self.pair[1].key


@dataclass(frozen=True, eq=False)
class CandidateExperiment:
    """A motion, what the sensors would read with either cause, and the expected logarithm of the odds."""

    trajectory: Trajectory
    records: tuple[Record, ...]
    log_odds: float


def trials(rivals: Rivals, envelope: Envelope, forces: Mapping[str, float]) -> list[CandidateExperiment]:
    """Motions that stay within the forces, the most promising first; gentler where they need to be."""
    found: dict[int, CandidateExperiment] = {}
    for share in _GENTLER:
        for i, trajectory in enumerate(candidate_motions(envelope.gentler(share))):
            if i in found:
                continue
            try:
                records = tuple(reading(model, trajectory, rivals.record) for model in rivals.models)
            except LogError:  # too short
                continue
            needed = {name: max(np.abs(record.log[name]).max() for record in records) for name in forces}
            if all(needed[name] <= _FORCE_MARGIN * force for name, force in forces.items()):
                found[i] = CandidateExperiment(trajectory, records, _judged(rivals, records, _linear))
    return sorted(found.values(), key=lambda trial: -trial.log_odds)


@dataclass(frozen=True)
class Share:
    """How the position of a drive follows that of the first one: factor and offset."""

    factor: float = 1.0
    offset: float = 0.0

    def of(self, trajectory: Trajectory) -> Trajectory:
        """Reference of the drive to one of the first."""
        return replace(
            trajectory,
            position=self.factor * trajectory.position + self.offset,
            velocity=self.factor * trajectory.velocity,
            acceleration=self.factor * trajectory.acceleration,
        )


def shares_of(like: Record) -> tuple[Share, ...]:
    """How the drives of an axis move with the first one, as in the log: alike, mirrored, geared, or not at all.

    Factors near 1 or -1 are exact, so that a skew of the log is not an aim.
    """
    first, *others = (like.log[name] for name in like.driven)
    shares = [Share()]
    for other in others:
        factor = float(np.cov(first, other)[0, 1] / np.var(first, ddof=1))
        if abs(abs(factor) - 1.0) < _ALIKE:
            factor = math.copysign(1.0, factor)
        shares.append(Share(factor, float(np.mean(other) - factor * np.mean(first))))
    return tuple(shares)


def reading(model: State, trajectory: Trajectory, like: Record) -> Record:
    """Readings if an axis followed a trajectory with its driven joints, with the sensors and the noise of `like`."""
    rng, names = np.random.default_rng(0), (*like.driven, *like.outputs)
    levels = zip(names, like.noise, strict=True)
    noise = {name: level * rng.standard_normal(trajectory.n_samples) for name, level in levels}
    shares = zip(like.driven, shares_of(like), strict=True)
    paths = {name: share.of(trajectory).position for name, share in shares}
    exact = paths | {name: noise[name] for name in like.forces}
    first_seen = exact | {name: path + noise[name] for name, path in paths.items()}
    seen = record_of(like.dynamics, _log(first_seen, trajectory))
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


def _judged(rivals: Rivals, records: Sequence[Record], left: _Judge) -> float:
    """Logarithm of the odds expected for the right cause, the less favourable case."""
    found = []
    for right, record in enumerate(records):
        truth, weighting = applied(rivals.models[right], record)
        if weighting.kept.sum() < _LEAST_ROWS:
            return 0.0
        gains = [
            0.5
            * _rows(weighting)
            * min(left(start, truth, weighting) for start in _starts(model, truth, weighting))
            for model in (rivals.models[1 - right], rivals.step.before.state)
        ]
        found.append(_log_odds(rivals, right, *gains))
    return min(found)


@dataclass(frozen=True)
class Separation:
    """How well readings distinguish the cause with which they were made from the other.

    The logarithm of the likelihood ratio of both is Gaussian.
    """

    gain: float  # its mean, of models and noise
    # its deviation: deviations of the noise by which the predictions of both differ, the values of both fitted,
    # and what the noise, which either model lets through otherwise, adds
    distance: float

    @property
    def probability(self) -> float:
        """That the right one is the likelier.

        Predictions two deviations apart, of which one is exact.

        >>> round(Separation(gain=2.0, distance=2.0).probability, 4)
        0.8413
        """
        return float(scipy.special.ndtr(self.gain / self.distance)) if self.distance else 0.5


def separation(rivals: Rivals, right: int, noisy: Record, quiet: Record) -> Separation:
    """How well readings, made with cause `right` (0 or 1), with and without noise, distinguish two causes."""
    weighting = applied(rivals.models[right], noisy)[1]
    exact = applied(rivals.models[right], quiet)[0]
    own = fitted(exact.weighted(weighting), weighting, _ITERATIONS)
    other = rivals.models[1 - right]
    starts = (applied(other, quiet)[0], applied(exact, quiet, placed=other.placed)[0])
    fits = [fitted(start.weighted(weighting), weighting, _ITERATIONS) for start in starts]
    nearest = min(fits, key=lambda fit: fit.mean_square)
    kept, n = weighting.kept, _rows(weighting)
    apart = (nearest.left - own.left)[:, kept]
    (wrong, of_wrong), (correct, of_correct) = (_with_noise(fit, noisy) for fit in (nearest, own))
    gain = 0.5 * n * math.log(np.mean((wrong + of_wrong)[:, kept]) / np.mean((correct + of_correct)[:, kept]))
    uneven = 0.25 * n * float(np.var((of_wrong - of_correct)[:, kept]))
    return Separation(gain, math.sqrt(n * float(np.mean(apart**2)) + uneven))


def _with_noise(quiet: Fit, noisy: Record) -> tuple[FloatArray, FloatArray]:
    """Squares that a model fitted to readings without noise leaves of them, and of the noise, as in `Fit.squares`."""
    weighting = quiet.weighting
    state = applied(quiet.state, noisy)[0].weighted(weighting)
    noise = Fit(state, weighting).left - quiet.left
    floor = state.prediction.noise_through(weighting.density)[:, None]
    return quiet.left**2 / floor, noise**2 / floor


def _rows(weighting: Weighting) -> float:
    """Independent values in the rows that are kept."""
    return float(weighting.kept.sum() * len(weighting.density) * weighting.record.freedom)


def _starts(model: State, truth: State, weighting: Weighting) -> list[State]:
    """A model with its own values of the axis, and with those of the truth: a fit may end at either."""
    own = applied(model, weighting.record)[0]
    near = applied(truth, weighting.record, placed=model.placed)[0]
    return [state.weighted(weighting) for state in (own, near)]


def _linear(model: State, truth: State, weighting: Weighting) -> float:
    """Logarithm by which the mean square of noise grows with what the model's columns leave of the truth."""
    rows = weighting.rows(model.errors - truth.errors)
    return math.log1p(Fit(replace(model, rows=rows), weighting).mean_square)


def _fitted(model: State, truth: State, weighting: Weighting) -> float:
    """The same with both fitted to readings with noise."""
    model_left, truth_left = (
        fitted(state, weighting, _ITERATIONS).mean_square for state in (model, truth.weighted(weighting))
    )
    return math.log(model_left / truth_left)


def _log_odds(rivals: Rivals, right: int, over_other: float, over_none: float) -> float:
    own, other = (rivals.pair[i].placed.n_free for i in (right, 1 - right))
    return (over_other - THRESHOLDS.penalty * (own - other)) / temperature(
        over_none - THRESHOLDS.penalty * own
    )


def simulated_trials(rivals: Rivals, trials: Sequence[CandidateExperiment]) -> list[CandidateExperiment]:
    """Rehearsals, best first: of motions from which more is expected than a rehearsal has shown, at most a few."""
    found: list[CandidateExperiment] = []
    for trial in trials[:_REHEARSED]:
        if trial.log_odds > max([LEAST_LOG_ODDS, *(other.log_odds for other in found)]):
            shown = _judged(rivals, trial.records, _fitted)
            found.append(replace(trial, log_odds=min(trial.log_odds, shown)))
    return sorted(found, key=lambda trial: -trial.log_odds)
