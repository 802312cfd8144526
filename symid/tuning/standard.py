"""The standard model [5]: the equations of motion, linear in the physical parameters, with all motions known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen.lowering import code
from symid.symbolic.expressions import is_smooth, parameter_symbol
from symid.symbolic.lagrange import Kinematics, inverse_dynamics

_Column = Callable[..., FloatArray]


@dataclass(frozen=True, eq=False)
class StandardModel:
    """yS = DS XS [5]-[8], one equation for each free body, before anything is eliminated.

    Parameters
    ----------
    parameters : tuple of str
        Physical parameters, the columns of DS.
    signals : tuple of str
        Coordinates of the free bodies and their derivatives, such as ``q_motor_d2``, and what the drives record.
    outputs : tuple of callable
        For each equation, yS of the signals.
    columns : tuple of tuple of callable
        For each equation and parameter, the column of DS of the signals.
    law_columns : tuple of tuple of int
        Equation and parameter of the columns that hold values of nonlinear laws.
    jumps : tuple of callable
        Velocities at whose zeros a law jumps.
    per_log : tuple of str
        Parameters that belong to a log and not to the axis.
    """

    parameters: tuple[str, ...]
    signals: tuple[str, ...]
    outputs: tuple[_Column, ...]
    columns: tuple[tuple[_Column, ...], ...]
    law_columns: tuple[tuple[int, int], ...]
    jumps: tuple[_Column, ...]
    per_log: tuple[str, ...]

    def sample(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Observation W of shape (n_equations, n_samples, n_parameters) and y of shape (n_equations, n_samples)."""
        arguments = [values[name] for name in self.signals]
        W = np.empty((len(self.columns), arguments[0].size, len(self.parameters)))
        y = np.empty(W.shape[:2])
        for j, row in enumerate(self.columns):
            y[j] = self.outputs[j](*arguments)
            for i, column in enumerate(row):
                W[j, :, i] = column(*arguments)
        return W, y

    def sliding(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, ...]:
        """Velocities at whose zeros a law jumps."""
        return tuple(jump(*(values[name] for name in self.signals)) for jump in self.jumps)


def standard_model(axis: Axis) -> StandardModel:
    """Standard model of an axis: the balances of `inverse_dynamics`, differentiated by the parameters.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> model = standard_model(load_axis("rigid_1m"))
    >>> model.parameters, model.signals
    (('M', 'Fv', 'Fs'), ('q_motor', 'q_motor_d1', 'q_motor_d2', 'F'))
    """
    dynamics, kinematics = inverse_dynamics(axis), Kinematics(axis)
    symbols = [kinematics.symbol(body, order) for body in axis.free_bodies for order in range(3)]
    symbols += [sp.Symbol(drive.signal) for drive in axis.drives]
    parameters = tuple(
        name for name in axis.parameter_units if name in dynamics.known or name in axis.physical_parameters
    )
    constants = {sp.Symbol(name): value for name, value in dynamics.constants.items()}
    laws, jumps = {}, {}
    for entry in dynamics.inputs:
        place = kinematics.displacement(entry.joint)
        speed = kinematics.rate(place, 1)
        laws[entry.symbol] = entry.expression.xreplace({sp.Symbol("q"): place, sp.Symbol("v"): speed})
        if not is_smooth(entry.expression):
            jumps[speed] = _function(speed.xreplace(constants), symbols)
    outputs, columns, law_columns = [], [], []
    absent = {parameter_symbol(name): sp.Integer(0) for name in parameters}
    for j, balance in enumerate(dynamics.balances):
        by_parameter = [sp.diff(balance, parameter_symbol(name)) for name in parameters]
        law_columns += [(j, i) for i, column in enumerate(by_parameter) if column.free_symbols & laws.keys()]
        written = [column.xreplace(laws).xreplace(constants) for column in by_parameter]
        columns.append(tuple(_function(column, symbols) for column in written))
        outputs.append(_function(-balance.xreplace(absent).xreplace(constants), symbols))
    return StandardModel(
        parameters,
        tuple(map(str, symbols)),
        tuple(outputs),
        tuple(columns),
        tuple(law_columns),
        tuple(jumps.values()),
        axis.log_parameters,
    )


def _function(expression: sp.Expr, symbols: list[sp.Symbol]) -> _Column:
    text = f"lambda {', '.join(map(str, symbols))}: {code(expression)}"
    return eval(text, {"np": np})  # type: ignore[no-any-return]  # eval is untyped
