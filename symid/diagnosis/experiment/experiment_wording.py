"""The next experiment in words."""

import math
from collections.abc import Mapping

from symid.diagnosis.effects import Key
from symid.diagnosis.experiment.discrimination import Rivals, drive_ratios
from symid.diagnosis.findings.planned_experiment import SimulatedExperiment
from symid.diagnosis.prediction.record import Record
from symid.simulation import Trajectory
from symid.text import spoken

_MOST_LOG_ODDS = math.log(1e6)


def odds_of(log_odds: float) -> float:
    """Odds of a log-odds, bounded so that they can be printed."""
    return math.exp(min(log_odds, _MOST_LOG_ODDS))


def words_of_motion(rivals: Rivals, trajectory: Trajectory, log_odds: float) -> str:
    """The aim of the experiment, its motion, and the odds expected after it."""
    one, other = (spoken(effect, place) for effect, place in rivals.keys)
    aim = f"To distinguish {one} from {other}" if rivals.remains else f"To confirm {one} against {other}"
    least = "more than 1e6" if log_odds >= _MOST_LOG_ODDS else f"{odds_of(log_odds):.3g}"
    return (
        f"{aim}: {trajectory.name}, {trajectory.duration:.3g} s in all; the odds expected after it are {least} to 1 "
        "for the right one, if the axis follows this reference."
    )


def words_of_drives(record: Record) -> str:
    """Motion of several drives in words; empty for one drive."""
    shares = zip(record.driven[1:], drive_ratios(record)[1:], strict=True)
    first = record.driven[0]
    unlike = [f"{name} {share.factor:.3g} times {first}" for name, share in shares if share.factor != 1.0]
    if record.n_drives == 1:
        return ""
    return f" All drives follow it as they did in the log{': ' + ', '.join(unlike) if unlike else ', alike'}."


def words_of_simulation(run: SimulatedExperiment | None, message: str) -> str:
    """Result of the simulation of a motion in words."""
    if run is None:
        return f" It could not be simulated: {message}."
    demand = run.demand
    return (
        f" Simulated with either cause under a controller, it distinguishes them with a probability of "
        f"{_per_cent(run.probability)} at the noise of the log, "
        f"and takes positions from {demand.lowest:.3g} to {demand.highest:.3g}, speeds to {demand.speed:.3g}, "
        f"accelerations to {demand.acceleration:.3g} and forces to {run.force:.3g} (SI)."
    )


def words_of_further(further: Mapping[Key, float]) -> str:
    """Discrimination against causes other than the strongest rival, in words."""
    against = [
        f"{spoken(*key)} ({'cannot be simulated' if math.isnan(p) else _per_cent(p)})"
        for key, p in further.items()
    ]
    return f" Against the other remaining causes: {', '.join(against)}." if against else ""


def _per_cent(probability: float) -> str:
    return f"{'more than ' * (probability > 0.999)}{100 * min(probability, 0.999):.3g} %"


def none_within_limits(rivals: Rivals, message: str) -> str:
    """Sentence where no motion that distinguishes the causes keeps its limits in simulation."""
    one, other = (spoken(*key) for key in rivals.keys)
    return (
        f"No motion that distinguishes {one} from {other} stays within the limits in simulation ({message}): "
        "wider limits are needed."
    )


def none_separates(rivals: Rivals) -> str:
    """Sentence where no motion within the limits distinguishes the causes, with the reason."""
    (one, _), (other, _) = rivals.keys
    record = rivals.record
    unused = [name for name in record.dynamics.sensors if name not in record.signals]
    further = f"record {' or '.join(unused)} too" if unused else "another sensor is needed"
    both = " from ".join(spoken(*key) for key in rivals.keys)
    none = f"No motion within these limits distinguishes {both}"
    if one == other:
        return f"{none}: the sensors used see both places alike; {further}."
    if {one, other} == {"offset_force", "asymmetric_friction"}:
        return (
            f"{none}: while it moves, both are a constant force; step the axis round or unload it, "
            "which changes an offset only."
        )
    return f"{none}: wider limits of speed, acceleration or force are needed, or {further}."
