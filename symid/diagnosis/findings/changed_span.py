"""A span of the log in which the parameters are others than in the rest."""

from __future__ import annotations

import numpy as np

from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.thresholds import THRESHOLDS
from symid.identification.deviations.stability import greatest_change


def changed_span(fit: Fit, of: str) -> str:
    """Sentence if separate parameters for a span of the log explain most of the error of a model; empty otherwise.

    Two machines in one log, or a gain that is another from some time on, are not effects of one machine. The log is
    called `of`.
    """
    record, names = fit.state.prediction.record, list(fit.parameters)
    segments, root = fit.blocks.segments(record.row_time[fit.weighting.kept])
    values = np.concatenate([list(fit.parameters.values()), np.zeros(len(root) - len(names))])
    change = greatest_change(segments, values, root)
    if change is None or change.explained < THRESHOLDS.changed_span:
        return ""
    i = change.most_certain(np.arange(values.size) < len(names))
    unit = record.dynamics.axis.physical_parameters[names[i]]
    return (
        f"Look at what changed: in a part of {of} from {change.begins + record.log.start:.4g} s on {names[i]} is "
        f"{change.inside[i]:.4g} {unit}, elsewhere {change.outside[i]:.4g}. This explains "
        f"{100 * change.explained:.0f} % of the error: another payload, gain or machine. Diagnose the parts apart "
        "(`trim`)."
    )
