"""The next experiment that a diagnosis plans, with its simulation: records of the result."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import scipy

from symid.diagnosis.effects import Key
from symid.diagnosis.prediction.record import Record
from symid.simulation import Extremes, Limits, Trajectory

_MARGIN = 0.02  # relative excess over a limit that controller and noise may cause


@dataclass(frozen=True)
class Separation:
    """Gaussian log-likelihood ratio of the cause that made the readings to the other cause."""

    gain: float  # mean, from models and noise
    # standard deviation: the difference of both fitted predictions in standard deviations of the noise, and the
    # scatter due to the noise that the models pass differently
    distance: float

    @property
    def probability(self) -> float:
        """Probability that the true cause has the larger likelihood.

        For predictions two standard deviations apart, one of them exact:

        >>> round(Separation(gain=2.0, distance=2.0).probability, 4)
        0.8413
        """
        return float(scipy.special.ndtr(self.gain / self.distance)) if self.distance else 0.5


@dataclass(frozen=True, eq=False)
class SimulatedExperiment:
    """Result of a simulated experiment, for the less favourable of both causes."""

    separations: tuple[Separation, ...]  # of both causes by the readings with each of them
    demand: (
        Extremes  # motion of the driven joints, in terms of the first one; the jerk is that of the reference
    )
    forces: Mapping[str, float]  # largest force of each drive, in its unit
    records: tuple[Record, ...] = field(repr=False)  # readings with each cause

    @property
    def probability(self) -> float:
        """Probability that the experiment identifies the true cause."""
        return min(found.probability for found in self.separations)

    @property
    def force(self) -> float:
        """Largest force of all drives."""
        return max(self.forces.values())

    def exceeds(self, limits: Limits, forces: Mapping[str, float]) -> str:
        """The first limit that is exceeded, in words; empty if none is."""
        low, high = limits.travel
        beyond = max(low - self.demand.lowest, self.demand.highest - high)
        if beyond > _MARGIN * (high - low):
            return f"travel is exceeded by {beyond:.3g}"
        pairs = {
            "speed": (self.demand.speed, limits.speed),
            "acceleration": (self.demand.acceleration, limits.acceleration),
        }
        label = "force" if len(forces) == 1 else "force {}"
        pairs |= {label.format(name): (self.forces[name], limit) for name, limit in forces.items()}
        for what, (value, limit) in pairs.items():
            if value > (1 + _MARGIN) * limit:
                return f"{what} reaches {value:.3g} instead of {limit:.3g}"
        return ""


@dataclass(frozen=True, eq=False)
class Experiment:
    """The next experiment."""

    text: str
    """Description in words."""
    causes: tuple[Key, ...] = ()
    """Remaining effects and places; empty if none remain."""
    trajectory: Trajectory | None = None
    """Reference of the first drive that best distinguishes the causes; None if no motion does."""
    odds: float = math.nan
    """Expected odds for the true cause after the experiment, without the evidence so far; nan without trajectory."""
    simulated: SimulatedExperiment | None = None
    """Simulation of the motion with either cause; None if it is not possible."""
    message: str = ""
    """Why it is not possible, or which motions were rejected because the simulated axis exceeds a limit."""
    further: Mapping[Key, float] = field(default_factory=dict)
    """Probability that the motion distinguishes the first cause from each further one; nan if that cannot be
    simulated."""
    paths: tuple[Trajectory, ...] = ()
    """Reference of each drive; the others follow the first one as in the log."""

    @property
    def probability(self) -> float:
        """Probability that it identifies the true cause with the noise of the log; nan if it was not simulated."""
        return math.nan if self.simulated is None else self.simulated.probability
