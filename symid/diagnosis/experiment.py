"""The next experiment: where two causes remain, the motion that tells them apart best.

Each motion of `manoeuvres` is taken as done: the axis with one cause says what the sensors would read, and the gain of
the logarithm of the likelihood is expected that this cause would have over the other, whose values are free. At first
the other's prediction is taken as linear in its values: half the square of what its columns leave of the difference.
The few best motions are then rehearsed: readings with the noise of the log, and both causes fitted to them. Gains are
tempered as in `evidence`, and a motion is as good as the less favourable of both cases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import ComplexArray, FloatArray
from symid.data import Log
from symid.diagnosis.comparison import applied
from symid.diagnosis.diagnose import driven
from symid.diagnosis.effects import JointEffect
from symid.diagnosis.evidence import INDISTINGUISHABLE, Key, odds, temperature
from symid.diagnosis.fit import State, fitted, unfitted
from symid.diagnosis.manoeuvres import Room, manoeuvres
from symid.diagnosis.record import Record, record_of
from symid.diagnosis.result import Diagnosis
from symid.diagnosis.screening import PRICE
from symid.diagnosis.search import Confirmed, Turn
from symid.diagnosis.weighting import Weighting
from symid.diagnosis.wording import spoken
from symid.errors import LogError, SettingError
from symid.simulation import Limits, Trajectory

_REHEARSED = 6
_GENTLER = (1.0, 0.7, 0.5, 0.3, 0.15)
_FORCE_MARGIN = 1.02
_SMOOTH = 20.0
_HIGHEST_HZ = 100.0
_LEAST_ROWS = 64
_LEAST_LOG_ODDS = math.log(3.0)
_MOST_LOG_ODDS = math.log(1e6)
_ITERATIONS = 10
_Left = Callable[[State, State, Weighting], float]


@dataclass(frozen=True, eq=False)
class Experiment:
    """What to do next.

    Parameters
    ----------
    text : str
        In words.
    causes : tuple of (str, str)
        Effects and places that remain; empty if none do.
    trajectory : Trajectory or None
        Reference that tells them apart best; None if no motion does.
    odds : float
        Expected odds of the right one against the other after it, without the log so far; nan without trajectory.
    considered : mapping of str to float
        Expected odds after each motion that was rehearsed, best first.
    """

    text: str
    causes: tuple[Key, ...] = ()
    trajectory: Trajectory | None = None
    odds: float = math.nan
    considered: Mapping[str, float] | None = None


@dataclass(frozen=True, eq=False)
class Rivals:
    """Two causes that remain, the more probable one first.

    Parameters
    ----------
    turn : Turn
        Of the search, in which they were found.
    pair : tuple of Confirmed
        Both.
    chance : float
        Probability of the second, if one of the candidates is right.
    """

    turn: Turn
    pair: tuple[Confirmed, Confirmed]
    chance: float

    @property
    def remains(self) -> bool:
        """Whether the log leaves doubt."""
        return self.chance >= INDISTINGUISHABLE

    @property
    def record(self) -> Record:
        """The log so far."""
        return self.turn.before.state.scene.record

    @property
    def models(self) -> tuple[State, State]:
        """The axis with either."""
        return self.pair[0].fit.state, self.pair[1].fit.state

    @property
    def keys(self) -> tuple[Key, Key]:
        """Names of effects and places."""
        return self.pair[0].key, self.pair[1].key


def next_experiment_of(
    found: Diagnosis,
    *,
    lowest: float | None = None,
    highest: float | None = None,
    speed: float | None = None,
    acceleration: float | None = None,
    force: float | None = None,
    seconds: float | None = None,
) -> Experiment:
    """The motion that tells the first effect found from its strongest rival.

    Parameters
    ----------
    found : Diagnosis
        With its search, as `diagnose` returns it.
    lowest, highest : float, optional
        Travel of the driven joint, m or rad; that of the log by default, as all limits are.
    speed, acceleration : float, optional
        Of the driven joint, SI.
    force : float, optional
        Largest drive force, SI.
    seconds : float, optional
        Duration, s.

    Returns
    -------
    Experiment
        Without a trajectory where nothing is left to tell apart, or where no motion does it.

    Raises
    ------
    SettingError
        If a limit is not positive.

    Examples
    --------
    A delay and a first-order lag act alike where the force changes slowly.

    >>> from symid.axis import load_axis
    >>> from symid.diagnosis import diagnose
    >>> from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    >>> late = axis.with_signal("q", noise=2e-9, delay=1e-3).with_signal("F", noise=2.0)
    >>> reference = trapezoids([0.1, 0.06], [0.15, 0.2], acceleration=2.0, jerk=20.0, sampling_period=1e-3)
    >>> log = simulate(late, values, reference, tuned_cascade(plant_of(axis, values), "q")).log
    >>> planned = next_experiment_of(diagnose(axis, log), acceleration=3.0, seconds=4.0)
    >>> planned.causes, planned.trajectory.name
    ((('delay', 'actuator'), ('actuator_lag', 'actuator')), 'multisine of 3 to 100 Hz about one place')
    """
    for value, what in ((force, "largest force"), (seconds, "duration")):
        if value is not None and not value > 0:
            raise SettingError(f"{what} of the next experiment is {value:g}: give a positive number")
    rivals = _rivals(found)
    if rivals is None:
        return Experiment(found.next_experiment)
    record = rivals.record
    seen = limits_seen(record)
    ends = (seen.travel[0] if lowest is None else lowest, seen.travel[1] if highest is None else highest)
    limits = Limits(ends, speed or seen.speed, acceleration or seen.acceleration)
    drive = record.log[record.dynamics.axis.drive.signal]
    room = _room(record, limits, seconds or record.duration)
    rehearsed = _best(rivals, _trials(rivals, room, force or float(np.abs(drive).max())))
    considered = {trial.trajectory.name: _odds(trial.log_odds) for trial in rehearsed}
    if not rehearsed or rehearsed[0].log_odds < _LEAST_LOG_ODDS:
        return Experiment(_none_separates(rivals), rivals.keys, considered=considered)
    best, value = rehearsed[0].trajectory, rehearsed[0].log_odds
    return Experiment(_words(rivals, best, value), rivals.keys, best, _odds(value), considered)


def limits_seen(record: Record) -> Limits:
    """Travel, speed and acceleration of the driven joint in a log."""
    s, inside = 1j * record.omega, record.in_log
    position = record.fine(record.motion)[inside]
    velocity = record.fine(s * record.motion * record.taper)[inside]
    acceleration = record.fine(s**2 * record.motion * record.taper)[inside]
    return Limits(
        travel=(float(position.min()), float(position.max())),
        speed=float(np.abs(velocity).max()),
        acceleration=float(np.quantile(np.abs(acceleration), 0.995)),
    )


def _room(record: Record, limits: Limits, seconds: float) -> Room:
    unit = record.dynamics.axis.signal_units[record.signals[0]]
    return Room(
        limits=replace(limits, jerk=_SMOOTH * limits.acceleration),
        seconds=seconds,
        highest_hz=min(_HIGHEST_HZ, 0.1 * record.log.sampling_frequency),
        sampling_period=record.log.sampling_period,
        unit=str(unit),
    )


def _rivals(found: Diagnosis) -> Rivals | None:
    """The two most probable candidates of the first turn that leaves doubt, else of the first turn."""
    if found.verdict not in ("effect", "unexplained"):
        return None
    ranked = []
    for turn in found.search:
        confirmed = {c.key: c for c in turn.confirmed}
        chance = odds(turn, driven(turn.before.state.scene.record)) if confirmed else {}
        keys = [key for key in chance if key in confirmed][:2]
        if len(keys) == 2:
            ranked.append(Rivals(turn, (confirmed[keys[0]], confirmed[keys[1]]), chance[keys[1]]))
    doubtful = [rivals for rivals in ranked if rivals.remains]
    return next(iter((*doubtful, *ranked)), None)


@dataclass(frozen=True, eq=False)
class _Trial:
    """A motion, what the sensors would read with either cause, and the expected logarithm of the odds."""

    trajectory: Trajectory
    records: tuple[Record, ...]
    log_odds: float


def _trials(rivals: Rivals, room: Room, force: float) -> list[_Trial]:
    """Motions that stay within the force, the most promising first; gentler where they need to be."""
    found: dict[int, _Trial] = {}
    drive = rivals.record.dynamics.axis.drive.signal
    for share in _GENTLER:
        for i, trajectory in enumerate(manoeuvres(room.gentler(share))):
            if i in found:
                continue
            try:
                records = tuple(reading(model, trajectory, rivals.record) for model in rivals.models)
            except LogError:  # too short
                continue
            if max(np.abs(record.log[drive]).max() for record in records) <= _FORCE_MARGIN * force:
                found[i] = _Trial(trajectory, records, _judged(rivals, records, _linear))
    return sorted(found.values(), key=lambda trial: -trial.log_odds)


def reading(model: State, trajectory: Trajectory, like: Record) -> Record:
    """What the sensors would read if an axis followed a trajectory.

    Parameters
    ----------
    model : State
        The axis with its values, under any record.
    trajectory : Trajectory
        Taken as the motion of the driven joint.
    like : Record
        With the sensors and the noise.
    """
    rng, (first, drive) = np.random.default_rng(0), (like.signals[0], like.dynamics.axis.drive.signal)
    names = (first, drive, *like.signals[1:])
    levels = zip(names, like.noise, strict=True)
    noise = {name: level * rng.standard_normal(trajectory.n_samples) for name, level in levels}
    exact = {first: trajectory.position, drive: noise[drive]}
    seen = record_of(like.dynamics, _log(exact | {first: exact[first] + noise[first]}, trajectory))
    moving = record_of(like.dynamics, _log(exact, trajectory), seen.motion_hz)
    of_joints = [item for item in model.placed if isinstance(item.effect, JointEffect)]
    scene = applied(model, moving, placed=of_joints)[0].scene
    exact[drive] = _samples(moving, scene.predicted[0])
    for name in names[2:]:
        row, order = scene.response.plant.sensors[name]
        exact[name] = _samples(moving, (1j * moving.omega) ** order * (row @ scene.displacements))
    record = record_of(like.dynamics, _log(exact, trajectory), seen.motion_hz)
    predicted = record.measured - applied(model, record)[0].errors
    for name, spectrum in zip(names[1:], predicted, strict=True):
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


def _judged(rivals: Rivals, records: Sequence[Record], left: _Left) -> float:
    """Logarithm of the odds expected for the right cause, the less favourable case."""
    found = []
    for right, record in enumerate(records):
        truth, weighting = applied(rivals.models[right], record)
        if weighting.kept.sum() < _LEAST_ROWS:
            return 0.0
        n = weighting.kept.sum() * len(weighting.density) * record.freedom
        gains = [
            0.5 * n * min(left(start, truth, weighting) for start in _starts(model, truth, weighting))
            for model in (rivals.models[1 - right], rivals.turn.before.state)
        ]
        found.append(_log_odds(rivals, right, *gains))
    return min(found)


def _starts(model: State, truth: State, weighting: Weighting) -> list[State]:
    """A model with its own values of the axis, and with those of the truth: a fit may end at either."""
    own = applied(model, weighting.record)[0]
    near = applied(truth, weighting.record, placed=model.placed)[0]
    return [state.weighted(weighting) for state in (own, near)]


def _linear(model: State, truth: State, weighting: Weighting) -> float:
    """Logarithm by which the mean square of noise grows with what the model's columns leave of the truth."""
    rows = weighting.rows(model.errors - truth.errors)
    return math.log1p(unfitted(replace(model, rows=rows), weighting).mean_square)


def _fitted(model: State, truth: State, weighting: Weighting) -> float:
    """The same with both fitted to readings with noise."""
    model_left, truth_left = (
        fitted(state, weighting, _ITERATIONS).mean_square for state in (model, truth.weighted(weighting))
    )
    return math.log(model_left / truth_left)


def _log_odds(rivals: Rivals, right: int, over_other: float, over_none: float) -> float:
    own, other = (rivals.pair[i].fit.state.placed[-1].n_free for i in (right, 1 - right))
    return (over_other - PRICE * (own - other)) / temperature(over_none - PRICE * own)


def _best(rivals: Rivals, trials: Sequence[_Trial]) -> list[_Trial]:
    """Rehearsals, best first: of motions from which more is expected than a rehearsal has shown, at most a few."""
    found: list[_Trial] = []
    for trial in trials[:_REHEARSED]:
        if trial.log_odds > max([_LEAST_LOG_ODDS, *(other.log_odds for other in found)]):
            rehearsed = _judged(rivals, trial.records, _fitted)
            found.append(replace(trial, log_odds=min(trial.log_odds, rehearsed)))
    return sorted(found, key=lambda trial: -trial.log_odds)


def _odds(log_odds: float) -> float:
    return math.exp(min(log_odds, _MOST_LOG_ODDS))


def _words(rivals: Rivals, trajectory: Trajectory, log_odds: float) -> str:
    one, other = (spoken(effect, place) for effect, place in rivals.keys)
    aim = f"To tell {one} from {other}" if rivals.remains else f"To confirm {one} against {other}"
    least = "more than 1e6" if log_odds >= _MOST_LOG_ODDS else f"{_odds(log_odds):.3g}"
    return (
        f"{aim}: {trajectory.name}, {trajectory.duration:.3g} s in all; the odds expected after it are {least} to 1 "
        "for the right one, if the axis follows this reference."
    )


def _none_separates(rivals: Rivals) -> str:
    (one, at), (other, place) = rivals.keys
    record = rivals.record
    unused = [name for name in record.dynamics.sensors if name not in record.signals]
    further = f"record {' or '.join(unused)} too" if unused else "another sensor is needed"
    none = f"No motion within these limits tells {one} at {at} from {other} at {place}"
    if one == other:
        return f"{none}: the sensors used see both places alike; {further}."
    if {one, other} == {"offset_force", "asymmetric_friction"}:
        return (
            f"{none}: while it moves, both are a constant force; turn the axis round or unload it, "
            "which changes an offset only."
        )
    return f"{none}: wider limits of speed, acceleration or force are needed, or {further}."
