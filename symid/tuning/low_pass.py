"""Errors caused by the low-pass filter alone: exact derivatives in the standard model, as in [35]."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
import sympy as sp

from symid.arrays import BoolArray, FloatArray
from symid.axis import Axis
from symid.codegen.generation import numpy_code
from symid.estimation import estimate, triangular_factors
from symid.signal_processing import LowPass
from symid.symbolic import Kinematics, inverse_dynamics, is_smooth, parameter_symbol
from symid.tuning.exact_run import ExactRun

_Column = Callable[..., FloatArray]


@dataclass(frozen=True, eq=False)
class StandardModel:
    """yS = DS XS [5]-[8], one equation for each free body, before anything is eliminated."""

    parameters: tuple[str, ...]  # physical parameters, the columns of DS
    # coordinates of the free bodies and their derivatives, such as ``q_motor_d2``, and what the drives record
    signals: tuple[str, ...]
    outputs: tuple[_Column, ...]  # for each equation, yS of the signals
    # for each equation and parameter, the column of DS of the signals
    columns: tuple[tuple[_Column, ...], ...]
    # equation and parameter of the columns that hold values of nonlinear laws
    law_columns: tuple[tuple[int, int], ...]
    jumps: tuple[_Column, ...]  # velocities at whose zeros a law jumps
    per_log: tuple[str, ...]  # parameters that belong to a log and not to the axis

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
    text = f"lambda {', '.join(map(str, symbols))}: {numpy_code(expression)}"
    return eval(text, {"np": np})  # type: ignore[no-any-return]  # eval is untyped


_LOWEST_SHARE, _HIGHEST_SHARE = 1 / 2000, 0.4
"""Cutoffs scanned, as shares of the sampling frequency."""
_STANDSTILL_SHARE = 0.01  # of the top speed
_EDGE_PERIODS = 3  # of the cutoff that are left out at each end


@dataclass(frozen=True, eq=False)
class LowPassErrors:
    """Relative errors of the physical parameters by cutoff frequency."""

    model: StandardModel  # the standard model [5]
    run: ExactRun  # where its signals come from
    parameters: Mapping[str, float]  # true values
    # sampling frequency of the data, Hz; `rate` is the nearest one of which that of the run is a multiple
    sampling_hz: float
    order: int  # order of one pass of the filter
    filter_force: bool  # whether the force, and with it the values of nonlinear laws, pass the filter too

    @property
    def _every(self) -> int:
        return max(1, round(self.run.rate / self.sampling_hz))

    @property
    def rate(self) -> float:
        """Sampling frequency in use, Hz."""
        return self.run.rate / self._every

    @cached_property
    def _exact(self) -> dict[str, FloatArray]:
        return self.run.exact_signals(self._every)

    @property
    def _n_samples(self) -> int:
        return next(iter(self._exact.values())).size

    def scan(self, points: int) -> list[float]:
        """Cutoff frequencies to be scanned, Hz, from that which trims a quarter of the data."""
        duration = self._n_samples / self.rate
        lowest = max(_LOWEST_SHARE * self.rate, 8 * _EDGE_PERIODS / duration)
        return [float(f) for f in np.geomspace(lowest, _HIGHEST_SHARE * self.rate, points)]

    def errors(self, cutoff_hz: float) -> dict[str, float]:
        """Error of each physical parameter in percent; nan if its true value is 0 or not determined."""
        low_pass = LowPass(cutoff_hz, self.order)
        kept_as_is = () if self.filter_force else self.run.forces
        filtered = {
            name: values if name in kept_as_is else low_pass.apply(values, self.rate)
            for name, values in self._exact.items()
        }
        # Exact derivatives are filtered, so that neither differences nor noise play a part: the error of the filter
        # remains, which nonlinear laws of filtered motion do not commute with.
        W, y = self.model.sample(filtered)
        if self.filter_force:
            for equation, column in self.model.law_columns:
                W[equation, :, column] = low_pass.apply(W[equation, :, column], self.rate)
        kept = self._kept(filtered, cutoff_hz)
        known = self.run.axis.known_parameters
        sought = [i for i, name in enumerate(self.model.parameters) if name not in known]
        for i, name in enumerate(self.model.parameters):
            y -= known.get(name, 0.0) * W[:, :, i]
        fit = estimate(triangular_factors(W[:, kept][:, :, sought], y[:, kept]), "ols")
        found = zip((self.model.parameters[i] for i in sought), map(float, fit.parameters), strict=True)
        return {
            name: 100.0 * (value / self.parameters[name] - 1.0) if self.parameters[name] else math.nan
            for name, value in found
            if name not in self.model.per_log
        }

    def _kept(self, filtered: Mapping[str, FloatArray], cutoff_hz: float) -> BoolArray:
        """Rows that are used: not near the ends, and not near zeros of velocities at which a law jumps."""
        n_samples = self._n_samples
        kept = np.ones(n_samples, dtype=bool)
        edge = math.ceil(_EDGE_PERIODS * self.rate / cutoff_hz)
        kept[:edge] = kept[n_samples - edge :] = False
        margin = math.ceil(0.5 * self.rate / cutoff_hz)
        for velocity in self.model.sliding(filtered):
            slow = np.abs(velocity) < _STANDSTILL_SHARE * np.abs(velocity).max()
            slow[1:] |= np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
            kept &= ~scipy.ndimage.maximum_filter1d(slow, 2 * margin + 1)
        return kept
