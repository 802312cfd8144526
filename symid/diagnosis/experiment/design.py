"""Design of the next experiment: the motion that best distinguishes two remaining causes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.diagnosis.effects import Key
from symid.diagnosis.experiment.candidates import Envelope
from symid.diagnosis.experiment.discrimination import (
    LEAST_LOG_ODDS,
    CandidateExperiment,
    Rivals,
    candidate_experiments,
    drive_ratios,
    refined_by_fits,
)
from symid.diagnosis.experiment.experiment_wording import (
    none_separates,
    none_within_limits,
    odds_of,
    words_of_drives,
    words_of_further,
    words_of_motion,
    words_of_simulation,
)
from symid.diagnosis.experiment.simulated import simulated_experiment
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.planned_experiment import Experiment, SimulatedExperiment
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.selection.evidence import probabilities
from symid.errors import SettingError, SymidError
from symid.simulation import Limits, Trajectory

_SMOOTH = 20.0  # 1/s: jerk over acceleration, if no limit of the jerk is given
_HIGHEST_HZ = 100.0  # of a motion
_LEAST_CHANCE = 0.01  # probability from which on the motion is also simulated with a further candidate
_MOST_FURTHER = 3  # causes other than the strongest rival


def next_experiment_of(
    found: Diagnosis,
    *,
    lowest: float | None = None,
    highest: float | None = None,
    speed: float | None = None,
    acceleration: float | None = None,
    jerk: float | None = None,
    force: float | None = None,
    seconds: float | None = None,
) -> Experiment:
    """The motion that best distinguishes the first effect found from its strongest rival.

    Parameters
    ----------
    found : Diagnosis
        Result of `diagnose`, with its search.
    lowest, highest : float, optional
        Travel of the driven joint, m or rad. The defaults of all limits are the extremes in the log.
    speed, acceleration : float, optional
        Largest speed and acceleration of the driven joint, SI.
    jerk : float, optional
        Largest jerk of the reference, SI; by default that of moves is 20 times the acceleration, and that of a
        multisine is not limited.
    force : float, optional
        Largest force of every drive, SI.
    seconds : float, optional
        Duration, s.

    Returns
    -------
    Experiment
        Without a trajectory if only one cause remains, or no motion distinguishes two.

    Raises
    ------
    SettingError
        If a limit is not positive.

    Examples
    --------
    A delay and a first-order lag have similar effects while the force changes slowly.

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
    for value, what in ((force, "largest force"), (seconds, "duration"), (jerk, "jerk")):
        if value is not None and not value > 0:
            raise SettingError(f"{what} of the next experiment is {value:g}: give a positive number")
    rivals = rivals_of(found)
    if rivals is None:
        return Experiment(found.next_experiment)
    record = rivals.record
    seen = limits_seen(record)
    ends = (seen.travel[0] if lowest is None else lowest, seen.travel[1] if highest is None else highest)
    limits = Limits(ends, speed or seen.speed, acceleration or seen.acceleration)
    envelope = _envelope(record, limits, seconds or record.duration, jerk)
    forces = {name: force or float(np.abs(record.log[name]).max()) for name in record.forces}
    # Candidates are ranked by the log-odds expected of the linear prediction. The best that can decide is simulated
    # with its controller, since limits must hold there.
    best = refined_by_fits(rivals, candidate_experiments(rivals, envelope, forces))
    decisive = [trial for trial in best if trial.log_odds >= LEAST_LOG_ODDS]
    if not decisive:
        return Experiment(none_separates(rivals), rivals.keys)
    chosen, run, message = _best_within_limits(rivals, decisive, limits, forces)
    if chosen is None:
        return Experiment(none_within_limits(rivals, message), rivals.keys, message=message)
    further = _against_further(rivals, chosen.trajectory) if run else {}
    reference = words_of_motion(rivals, chosen.trajectory, chosen.log_odds) + words_of_drives(record)
    return Experiment(
        text=reference + words_of_simulation(run, message) + words_of_further(further),
        causes=rivals.keys,
        trajectory=chosen.trajectory,
        odds=odds_of(chosen.log_odds),
        simulated=run,
        message=message,
        further=further,
        paths=tuple(share.of(chosen.trajectory) for share in drive_ratios(record)),
    )


def _against_further(rivals: Rivals, trajectory: Trajectory) -> dict[Key, float]:
    """Probability that a motion distinguishes the first cause from the most probable further ones of the same step."""
    first, step = rivals.pair[0], rivals.step
    confirmed = {c.key: c for c in step.confirmed}
    chances = probabilities(step)
    keys = [k for k in chances if k in confirmed and k not in rivals.keys and chances[k] >= _LEAST_CHANCE]
    found = {}
    for key in keys[:_MOST_FURTHER]:
        try:
            pair = Rivals(step, (first, confirmed[key]), chances[key])
            found[key] = simulated_experiment(pair, trajectory).probability
        except (SymidError, np.linalg.LinAlgError, OverflowError):
            found[key] = math.nan
    return found


def _best_within_limits(
    rivals: Rivals, decisive: Sequence[CandidateExperiment], limits: Limits, forces: Mapping[str, float]
) -> tuple[CandidateExperiment | None, SimulatedExperiment | None, str]:
    """The best motion with which the simulated axis keeps its limits, or the best one if simulation is not possible."""
    excesses: list[str] = []
    for trial in decisive:
        try:
            run = simulated_experiment(rivals, trial.trajectory)
        except (SymidError, np.linalg.LinAlgError, OverflowError) as error:
            return trial, None, str(error)
        if not (excess := run.exceeds(limits, forces)):
            return trial, run, "; ".join(excesses)
        excesses.append(f"{trial.trajectory.name}: {excess}")
    return None, None, "; ".join(excesses)


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


def _envelope(record: Record, limits: Limits, seconds: float, jerk: float | None) -> Envelope:
    unit = record.dynamics.axis.signal_units[record.signals[0]]
    return Envelope(
        limits=replace(limits, jerk=jerk or _SMOOTH * limits.acceleration),
        seconds=seconds,
        highest_hz=min(_HIGHEST_HZ, 0.1 * record.log.sampling_frequency),
        sampling_period=record.log.sampling_period,
        unit=str(unit),
        hardest=jerk or math.inf,
    )


def rivals_of(found: Diagnosis) -> Rivals | None:
    """The two most probable candidates of the first step that is in doubt, or of the first step if none is."""
    if found.verdict not in ("effect", "partly", "unexplained"):
        return None
    ranked = []
    for step in found.search:
        confirmed = {c.key: c for c in step.confirmed}
        chance = probabilities(step) if confirmed else {}
        keys = [key for key in chance if key in confirmed][:2]
        if len(keys) == 2:
            ranked.append(Rivals(step, (confirmed[keys[0]], confirmed[keys[1]]), chance[keys[1]]))
    doubtful = [rivals for rivals in ranked if rivals.remains]
    return next(iter((*doubtful, *ranked)), None)
