"""Identification: observation of logs, estimation, physical parameters.

`identify` is the table of contents. `signals` finds the signals of an axis in a log, `rows` makes the observation of
them, `parameters` maps minimal to physical parameters; `delays` and `deviations` examine the estimate, `results` holds
it with its status, and `faults` finds what contradicts it.
"""

from symid.identification.criteria import CRITERIA
from symid.identification.cutoff import Estimation
from symid.identification.delays.timing import Timing, delays_of
from symid.identification.deviations.bias import Bias
from symid.identification.force_steps import identify_with_steps, logs_with_steps
from symid.identification.identify import found_from, identify_by_least_squares, with_checks
from symid.identification.known_per_log import identify_with_known, known_of_logs
from symid.identification.parameters.constraints import Constraints
from symid.identification.parameters.physical import PhysicalEstimate, physical_estimates
from symid.identification.results.contradiction import with_constraint_check, with_fixed
from symid.identification.results.identification_result import Identification, predict
from symid.identification.results.predicted_output import OutputPrediction
from symid.identification.results.residuals import EquationResidual
from symid.identification.results.result_protocol import IdentificationResult
from symid.identification.results.shared_identification import SharedIdentification
from symid.identification.rows.excerpts import excerpts
from symid.identification.rows.observation import Observation, observe
from symid.identification.rows.row_blocks import Run
from symid.identification.rows.settings import Preparation
from symid.identification.signals.axis_logs import measured_signals, open_axis_log, read_axis_log
from symid.identification.signals.guessed_mapping import guessed_mapping
from symid.identification.signals.mapping import LogMapping, read_mapping
from symid.identification.signals.stated_period import stated_period

__all__ = [
    "CRITERIA",
    "Bias",
    "Constraints",
    "EquationResidual",
    "Estimation",
    "Identification",
    "IdentificationResult",
    "LogMapping",
    "Observation",
    "OutputPrediction",
    "PhysicalEstimate",
    "Preparation",
    "Run",
    "SharedIdentification",
    "Timing",
    "delays_of",
    "excerpts",
    "found_from",
    "guessed_mapping",
    "identify_by_least_squares",
    "identify_with_known",
    "identify_with_steps",
    "known_of_logs",
    "logs_with_steps",
    "measured_signals",
    "observe",
    "open_axis_log",
    "physical_estimates",
    "predict",
    "read_axis_log",
    "read_mapping",
    "stated_period",
    "with_checks",
    "with_constraint_check",
    "with_fixed",
]
