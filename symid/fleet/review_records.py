"""Records of the review of a fleet."""

from collections.abc import Mapping
from dataclasses import dataclass

import polars as pl

from symid.fleet.control_chart import ControlChart
from symid.fleet.results import EffectCount
from symid.fleet.spread import Spread, SpreadVerdict


@dataclass(frozen=True)
class Outlier:
    """A log of which a parameter is far from those of the other logs.

    It is z robust standard deviations off their `level`: the median, or that of its segment where the parameter steps
    or drifts, so that a change is one finding and not an outlier for each later log.
    """

    log: str
    value: float
    level: float
    z: float


@dataclass(frozen=True, eq=False)
class ParameterReview:
    """One parameter of one axis over its logs."""

    name: str
    """Name of the parameter."""
    logs: tuple[str, ...]
    """Logs that are used, in the order of the table."""
    median: float
    """Median of their values."""
    spread: Spread
    """Spread between runs compared with their intervals, without isolated outliers."""
    within: float
    """Standard deviation between runs within the segments of the chart."""
    chart: ControlChart
    """The parameter over time."""
    outliers: tuple[Outlier, ...]
    """Outliers, the farthest first."""
    unit: str = ""
    """Unit of the parameter; empty if unknown."""


@dataclass(frozen=True, eq=False)
class AxisReview:
    """One axis over its logs."""

    name: str
    """Name of the axis, with its sensors or its folder if there are several."""
    axis: str
    """The declared axis."""
    logs: int
    """Number of logs."""
    trusted: int
    """Number of those whose parameters are used."""
    statuses: Mapping[str, int]
    """Number of logs by status."""
    parameters: tuple[ParameterReview, ...]
    """Parameters of at least one log."""
    verdict: SpreadVerdict
    """Whether the axis differs from run to run."""


@dataclass(frozen=True, eq=False)
class FleetReview:
    """A fleet over all its logs."""

    table: pl.DataFrame
    """The results."""
    axes: tuple[AxisReview, ...]
    """Reviews of the axes, by name."""
    statuses: Mapping[str, int]
    """Number of logs by status."""
    verdicts: Mapping[str, int]
    """Number of logs by verdict of the diagnosis; empty without diagnoses."""
    effects: tuple[EffectCount, ...]
    """Effects found, the most frequent first."""
    sentence: str
    """Summary."""
