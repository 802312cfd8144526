"""The result of a diagnosis, from the models of the selection.

`comparison` evaluates the models on held-out data, and `held_out` drops effects that fail there. `faults`,
`force_sign`, `feedback` and `fit_faults` examine the recording. `conclusion` makes verdict, effects and values,
`location` maps the gap, and `wording` states them. `gap`, `found_effects`, `planned_experiment` and
`diagnosis_result` are the records of the result.
"""

from symid.diagnosis.findings.waterfall import Stage, waterfall

__all__ = [
    "Stage",
    "waterfall",
]
