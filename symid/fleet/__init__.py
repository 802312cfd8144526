"""A fleet of axes: joint identification of many logs, spread between runs, control charts, and their review."""

from symid.fleet.control_chart import ControlChart, control_chart
from symid.fleet.joint import JointIdentification, LogFactors, identify_jointly, log_factors
from symid.fleet.review import AxisReview, FleetReview, ParameterReview, review_fleet
from symid.fleet.segments import Change, Segment
from symid.fleet.spread import Spread, SpreadVerdict, judge_spread, spread_between

__all__ = [
    "AxisReview",
    "Change",
    "ControlChart",
    "FleetReview",
    "JointIdentification",
    "LogFactors",
    "ParameterReview",
    "Segment",
    "Spread",
    "SpreadVerdict",
    "control_chart",
    "identify_jointly",
    "judge_spread",
    "log_factors",
    "review_fleet",
    "spread_between",
]
