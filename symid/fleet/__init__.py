"""Many logs: batches that identify each log, joint estimates, spread between runs, and the review of a fleet."""

from symid.fleet.batch import Batch, Interrupted, identify_batch
from symid.fleet.batch_settings import BatchSettings
from symid.fleet.batch_summary import summary_of
from symid.fleet.control_chart import ControlChart, control_chart
from symid.fleet.joint_estimate import JointIdentification, LogFactors, identify_jointly, log_factors
from symid.fleet.journal import journal_file, read_journal
from symid.fleet.kept_factors import join_results
from symid.fleet.result_table import read_rows
from symid.fleet.results import UNITS, read_results, units_in
from symid.fleet.review import AxisReview, FleetReview, ParameterReview, review_fleet
from symid.fleet.segments import TrendChange, TrendSegment
from symid.fleet.spread import Spread, SpreadVerdict, judge_spread, spread_between

__all__ = [
    "UNITS",
    "AxisReview",
    "Batch",
    "BatchSettings",
    "ControlChart",
    "FleetReview",
    "Interrupted",
    "JointIdentification",
    "LogFactors",
    "ParameterReview",
    "Spread",
    "SpreadVerdict",
    "TrendChange",
    "TrendSegment",
    "control_chart",
    "identify_batch",
    "identify_jointly",
    "join_results",
    "journal_file",
    "judge_spread",
    "log_factors",
    "read_journal",
    "read_results",
    "read_rows",
    "review_fleet",
    "spread_between",
    "summary_of",
    "units_in",
]
