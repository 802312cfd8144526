"""The minimal parameters of groups of logs with different known values, as one map of the parameters they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.identification.constraints import Constraints, constrained_estimates
from symid.identification.identification_result import Identification
from symid.identification.inseparable import estimates_by_priors
from symid.identification.physical import (
    PhysicalEstimate,
    correlation_root,
    jacobian,
    open_by_structure,
    open_directions,
)


class Stacked:
    """The minimal parameters of all groups as one vector."""

    def __init__(self, groups: Sequence[Identification]) -> None:
        self.models: list[GeneratedModel] = [group.model for group in groups]
        self.minimal = np.concatenate([group.fit.parameters for group in groups])
        blocks = [group.covariance for group in groups]
        self.covariance_of_minimal = np.asarray(scipy.linalg.block_diag(*blocks))
        self.spread, root = correlation_root(self.minimal, self.covariance_of_minimal)
        assert root is not None  # a ridge is added
        self.root = root

    def forward(self, physical: FloatArray) -> FloatArray:
        """Minimal parameters of all groups."""
        return np.concatenate([model.minimal_parameters(*physical) for model in self.models])

    def whitened(self, rows: FloatArray) -> FloatArray:
        """Rows in deviations, uncorrelated."""
        scaled = rows / self.spread.reshape(-1, *[1] * (rows.ndim - 1))
        return np.asarray(np.linalg.solve(self.root, scaled))

    def slope(self, physical: FloatArray) -> FloatArray:
        """Derivatives of the whitened minimal parameters by the physical ones, each relative to its size."""
        columns = np.vstack([jacobian(model, physical) for model in self.models])
        return self.whitened(columns * scale_of(physical))

    def constrained(
        self, parameters: FloatArray, covariance: FloatArray, constraints: Constraints
    ) -> PhysicalEstimate | None:
        """The likeliest parameters within bounds and with priors; None where these do not determine them.

        `parameters` and `covariance` are those of the logs alone, nan where they leave them open.
        """
        names = [
            f"{name} of group {i}" for i, model in enumerate(self.models) for name in model.minimal_units
        ]
        model = replace(
            self.models[0],
            minimal_units=dict.fromkeys(names, ""),
            minimal_parameters=lambda *physical: self.forward(np.array(physical)),
            physical_parameters=None,
            branches=0,
        )
        data = self.minimal, self.covariance_of_minimal
        if np.all(np.isfinite(parameters)):
            nothing = np.zeros((parameters.size, self.minimal.size))
            free: tuple[PhysicalEstimate, ...] = (
                PhysicalEstimate(parameters, nothing, covariance, 0, np.nan),
            )
        else:
            free = estimates_by_priors(model, *data, constraints)
        found = constrained_estimates(model, *data, free, constraints)
        return found[0] if found else None

    def fitted(self, guess: FloatArray) -> tuple[FloatArray, float] | None:
        """Parameters fitted from a start, and chi-square."""
        scale = scale_of(guess)

        def weighted_residuals(relative: FloatArray) -> FloatArray:
            return self.whitened(self.forward(relative * scale) - self.minimal)

        with np.errstate(all="ignore"):
            if not np.isfinite(self.slope(guess)).all():
                return None
            found = scipy.optimize.least_squares(weighted_residuals, guess / scale, x_scale="jac")
        return found.x * scale, 2.0 * float(found.cost)

    def covariance(self, physical: FloatArray, names: list[str]) -> tuple[FloatArray, list[str]]:
        """Covariance of the parameters, nan for those that are not determined, and the names of these."""
        scale = scale_of(physical)
        # the structural rank, at a generic point, and the rank at the estimate, which may be lower
        axes, lost = open_directions(self.slope(physical))
        loose = lost | np.isin(names, open_by_structure(*self.models))
        covariance = np.asarray((axes.T @ axes) * np.outer(scale, scale))
        covariance[loose, :] = covariance[:, loose] = np.nan
        return covariance, [name for name, is_loose in zip(names, loose, strict=True) if is_loose]


def scale_of(physical: FloatArray) -> FloatArray:
    """Sizes of parameters, 1 of those that are zero."""
    return np.where(physical == 0, 1.0, np.abs(physical))
