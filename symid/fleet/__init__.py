"""Many logs: batches that identify each log, joint estimates, spread between runs, and the review of a fleet."""

from symid.fleet.batch import Batch, Interrupted, identify_batch
from symid.fleet.batch_settings import BatchSettings
from symid.fleet.batch_summary import summary_of
from symid.fleet.control_chart import ControlChart
from symid.fleet.factors import log_factors
from symid.fleet.joint_estimate import JointIdentification, identify_jointly
from symid.fleet.kept_factors import join_results
from symid.fleet.results import numbers_in, parameter_names, read_results, units_in, without_repeats
from symid.fleet.review import review_fleet
from symid.fleet.review_records import AxisReview, FleetReview, ParameterReview
from symid.fleet.segments import TrendChange
from symid.fleet.spread import Spread, robust_deviation
from symid.fleet.worker_limits import MOST_SECONDS

__all__ = [
    "MOST_SECONDS",
    "AxisReview",
    "Batch",
    "BatchSettings",
    "ControlChart",
    "FleetReview",
    "Interrupted",
    "JointIdentification",
    "ParameterReview",
    "Spread",
    "TrendChange",
    "identify_batch",
    "identify_jointly",
    "join_results",
    "log_factors",
    "numbers_in",
    "parameter_names",
    "read_results",
    "review_fleet",
    "robust_deviation",
    "summary_of",
    "units_in",
    "without_repeats",
]
