"""Physical parameters and effects from a record: weighted least squares of the outputs' errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symid.arrays import ComplexArray, FloatArray, norms_or_one
from symid.axis import Axis, Spring
from symid.diagnosis.fitting.cross_validation import Blocks, cross_validation_blocks, log_likelihood
from symid.diagnosis.fitting.sensitivity import initial_motion_jacobian, prediction_jacobian
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.weighting import Weighting
from symid.estimation import autoregression

_ALLOWED_ERROR = 0.1
"""Share of the remaining error that the weights allow for as error of the model."""
AR_ORDER = 6
"""Order of the autoregressive model of the errors that a fit leaves."""
_NULL = 1e-13
"""Relative eigenvalue of the normal matrix of unit columns below which it counts as 0."""
_TAKES_PART = 1e-3
"""Least component with which a value takes part in an undetermined combination."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a record."""

    state: State  # the model with its values
    weighting: Weighting  # of the errors
    # inertia that the drive moved with the values that the axis was first given; nan if these are not known
    initial_inertia: float = math.nan
    # values that the user gave; empty if there are none
    nominal: Mapping[str, float] = field(default_factory=dict)

    def after(self, other: Fit) -> Fit:
        """The fit with the initial inertia and nominal values of the fit that it continues."""
        return replace(self, initial_inertia=other.initial_inertia, nominal=other.nominal)

    def released(self) -> Fit:
        """The fit without its cached arrays, which are recomputed on demand: a search keeps many fits.

        Only `squares` stay cached, as every fit is asked for them.
        """
        weighting = self.weighting.released()
        kept = replace(self, state=self.state.released(weighting), weighting=weighting)
        vars(kept)["squares"] = self.squares
        return kept

    def with_weights(self, state: State, weighting: Weighting) -> Fit:
        """The same values with other weights; their derivatives stay."""
        found = Fit(state, weighting)
        if "jacobian" in vars(self):
            vars(found)["jacobian"] = self.jacobian
        return found

    @cached_property
    def jacobian(self) -> ComplexArray:
        """Derivatives of the prediction by all values, of shape (n_columns, n_outputs, n_bins)."""
        return prediction_jacobian(self.state)

    @cached_property
    def columns(self) -> FloatArray:
        """Weighted rows of these derivatives, of shape (n_columns, n_outputs, n_rows).

        They hold the derivatives of the motion from before the log too, see `initial_motion_jacobian`.
        """
        begun = initial_motion_jacobian(self.state)
        return self.weighting.rows(self.jacobian if begun is None else self.jacobian + begun)

    @cached_property
    def projected_columns(self) -> FloatArray:
        """Kept rows of these columns, less the part that unknown initial states explain; shape (n_columns, n)."""
        return self.weighting.projected(self.columns, self.state.beginning)

    @property
    def parameters(self) -> Mapping[str, float]:
        """Physical parameters, SI."""
        return self.state.prediction.parameters

    @cached_property
    def error(self) -> FloatArray:
        """Weighted errors in the kept rows, concatenated, less the part that unknown initial states explain.

        The part that the columns could still explain is included: with a value at its bound the fit is not perfect.
        """
        return self.weighting.projected(self.state.rows, self.state.beginning)

    @cached_property
    def cost(self) -> float:
        """Sum of squares of `error`."""
        return float(self.error @ self.error)

    @property
    def left(self) -> FloatArray:
        """`error` as rows, zero where a row is not kept; shape (n_outputs, n_rows)."""
        rows = np.zeros_like(self.state.rows)
        rows[:, self.weighting.kept] = self.error.reshape(len(rows), -1)
        return rows

    @cached_property
    def blocks(self) -> Blocks:
        """The model block by block, for cross-validation."""
        return cross_validation_blocks(self.state, self.weighting, self.projected_columns, self.error)

    @property
    def n_rows(self) -> float:
        """Number of independent rows of an output."""
        return float(self.weighting.kept.sum()) * self.state.prediction.record.freedom

    @property
    def predicted(self) -> float:
        """Log-likelihood of the blocks when they are left out, up to a constant."""
        return log_likelihood(self.blocks.squares, self.n_rows)

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of parameters and values of effects, in their units, of shape (n_columns,).

        The larger of two estimates counts: that for noise, with the errors as an autoregressive process, and that for
        errors of the model with any correlation, from the scatter of the gradients of blocks. A value is undetermined,
        and its deviation infinite, if it takes part in a combination that leaves the prediction unchanged, such as a
        mass and the force constant of its drive.
        """
        noise = autoregression(self.left, self.weighting.kept, AR_ORDER)
        columns = noise.apply(self.base)
        scale = norms_or_one(columns, axis=1)
        unit = columns / scale[:, None]
        # Variances from the eigenvectors that the rows determine; the null space marks the undetermined values.
        squares, directions = np.linalg.eigh(unit @ unit.T)
        seen = squares > _NULL * squares[-1]
        variances = directions[:, seen] ** 2 @ (1 / squares[seen])
        undetermined = (directions[:, ~seen] ** 2).sum(axis=1) > _TAKES_PART**2
        of_noise = np.where(undetermined, np.inf, np.sqrt(variances) / scale)[: len(self.columns)]
        of_blocks = np.sqrt(np.maximum(np.diag(self.blocks.covariance), 0.0))
        return np.asarray(np.maximum(of_noise, of_blocks))

    @property
    def base(self) -> FloatArray:
        """All columns, including those of unknown initial states, of shape (n, n_outputs, n_rows)."""
        return np.concatenate([self.columns, self.state.beginning, self.weighting.restarts])

    @cached_property
    def squares(self) -> FloatArray:
        """Mean square of the kept rows of each output, 1 if only noise is left; shape (n_outputs,)."""
        floor = self.state.prediction.noise_through(self.weighting.density)
        rows = self.error.reshape(len(self.state.rows), -1)
        return np.asarray(np.mean(rows**2, axis=1) / floor)

    def squares_as_weighted_by(self, other: Fit) -> FloatArray:
        """`squares` with the weights of another model, in multiples of its noise.

        Where values pass on more of the noise of the position, or where errors are allowed for, weights differ.
        """
        weighting = other.weighting
        same = self if weighting is self.weighting else Fit(self.state.weighted(weighting), weighting)
        own, of_other = (fit.state.prediction.noise_through(weighting.density) for fit in (self, other))
        return np.asarray(same.squares * own / of_other)

    @property
    def mean_square(self) -> float:
        """Mean of `squares`: 1 if only noise is left."""
        return float(np.mean(self.squares))

    @property
    def levels(self) -> tuple[float, ...]:
        """Errors of the outputs that the weights should allow for, in multiples of their noise.

        Where the error of the model exceeds the noise, weights by noise alone would fit only the few frequencies with
        the least noise, and one sensor would dominate the others.
        """
        excess = np.maximum(self.squares - 1, 0.0)
        return tuple(float(x) for x in np.sqrt(1 + _ALLOWED_ERROR**2 * excess))


def stiffnesses(axis: Axis) -> list[str]:
    """Unknown stiffnesses of the springs."""
    names = (element.named("stiffness") for element in axis.elements if isinstance(element, Spring))
    return [name for name in names if name in axis.physical_parameters]


def masses_and_stiffnesses(axis: Axis) -> list[str]:
    """Unknown masses and inertias of the free bodies, and unknown stiffnesses."""
    inertials = (body.inertial for body in axis.free_bodies)
    return [*(name for name in inertials if name in axis.physical_parameters), *stiffnesses(axis)]
