"""Weighted least squares of a model: physical parameters and effects.

`state` evaluates a model with values on a record, `sensitivity` its derivatives. `gauss_newton` fits the values, from
initial values of `start`, `hidden_starts` and `moments`. `fit` and `cross_validation` judge the result, and `applied`
evaluates it on another record.
"""
