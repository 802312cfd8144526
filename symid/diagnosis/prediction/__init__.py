"""Prediction of forces and readings from the motion that a log records, and the weights of their errors.

`preparation` makes logs that can be diagnosed. `record` holds the spectra of a log, `response` the frequency responses
of the axis, `prediction` the predicted outputs. `hidden_motion` integrates hidden motion in time where laws are strong.
`weighting` whitens the errors.
"""
