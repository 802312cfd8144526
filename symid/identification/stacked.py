"""The minimal parameters of groups of logs with different known values, as one map of the parameters they share."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.identification.parameters.constrained import constrained_estimates
from symid.identification.parameters.constraints import Constraints
from symid.identification.parameters.inseparable import estimates_by_priors
from symid.identification.parameters.physical import (
    PhysicalEstimate,
    WhitenedMap,
    open_by_structure,
    open_directions,
)
from symid.identification.results.identification_result import Identification


class Stacked:
    """The minimal parameters of all groups as one vector."""

    def __init__(self, groups: Sequence[Identification]) -> None:
        self.models: list[GeneratedModel] = [group.model for group in groups]
        names = [f"{n} of group {i}" for i, model in enumerate(self.models) for n in model.minimal_units]
        model = replace(
            self.models[0],
            minimal_units=dict.fromkeys(names, ""),
            minimal_parameters=lambda *p: np.concatenate([one.minimal_parameters(*p) for one in self.models]),
            physical_parameters=None,
            branches=0,
        )
        minimal = np.concatenate([group.fit.parameters for group in groups])
        self.covariance_of_minimal = np.asarray(scipy.linalg.block_diag(*(g.covariance for g in groups)))
        white = WhitenedMap.of(model, minimal, self.covariance_of_minimal)
        assert white is not None  # a ridge is added
        self.white = white

    def slope(self, physical: FloatArray) -> FloatArray:
        """Derivatives of the whitened minimal parameters by the physical ones, each relative to its size."""
        return self.white.slope(physical) * scale_of(physical)

    def constrained(
        self, parameters: FloatArray, covariance: FloatArray, constraints: Constraints
    ) -> PhysicalEstimate | None:
        """The likeliest parameters within bounds and with priors; None where these do not determine them.

        `parameters` and `covariance` are those of the logs alone, nan where they leave them open.
        """
        model, minimal, wide = self.white.model, self.white.minimal, self.covariance_of_minimal
        if np.all(np.isfinite(parameters)):
            nothing = np.zeros((parameters.size, minimal.size))
            free: tuple[PhysicalEstimate, ...] = (
                PhysicalEstimate(parameters, nothing, covariance, 0, np.nan),
            )
        else:
            free = estimates_by_priors(model, minimal, wide, constraints)
        found = constrained_estimates(model, minimal, wide, free, constraints)
        return found[0] if found else None

    def fitted(self, guess: FloatArray) -> tuple[FloatArray, float] | None:
        """Parameters fitted from a start, and chi-square."""
        scale = scale_of(guess)

        def weighted_residuals(relative: FloatArray) -> FloatArray:
            return self.white.residual(relative * scale)

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
