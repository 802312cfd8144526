"""Prediction of forces and readings from the motion that a log records, and the weights of their errors.

`preparation` repairs and converts logs and axis. `record` holds the spectra of a log, `response` the frequency responses
of the axis, `prediction` the predicted outputs. `hidden_motion` integrates hidden motion in time where laws are strong.
`weighting` whitens the errors.
"""
