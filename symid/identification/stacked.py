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
from symid.identification.results.identification_result import Identification, with_deviations


class Stacked:
    """The minimal parameters of all groups as one vector."""

    def __init__(self, groups: Sequence[Identification]) -> None:
        self.groups = tuple(groups)
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
        self.covariance_of_minimal = np.asarray(
            scipy.linalg.block_diag(*(group.widened_covariance for group in groups))
        )
        white = WhitenedMap.of(model, minimal, self.covariance_of_minimal)
        assert white is not None  # a ridge is added
        self.white = white

    def slope(self, physical: FloatArray) -> FloatArray:
        """Derivatives of the whitened minimal parameters by the physical ones, each relative to its size."""
        return self.white.slope(physical) * scale_of(physical)

    def constrained(self, alone: PhysicalEstimate, constraints: Constraints) -> PhysicalEstimate | None:
        """The likeliest parameters within bounds and with priors; None where these do not determine them.

        `alone` is the estimate of the logs alone.
        """
        model, minimal, wide = self.white.model, self.white.minimal, self.covariance_of_minimal
        determined = np.all(np.isfinite(alone.parameters))
        free = (alone,) if determined else estimates_by_priors(model, minimal, wide, constraints)
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

    def estimate(self, physical: FloatArray, disagreement: float) -> PhysicalEstimate:
        """Estimate at fitted parameters, nan for those that are not determined."""
        scale, slope, names = scale_of(physical), self.slope(physical), list(self.models[0].physical_units)
        # the structural rank, at a generic point, and the rank at the estimate, which may be lower
        axes, lost = open_directions(slope)
        loose = lost | np.isin(names, open_by_structure(*self.models))
        sensitivity = scale[:, None] * (axes.T @ axes @ slope.T @ self.white.whitening)
        sensitivity[loose] = np.nan
        covariance = sensitivity @ self.covariance_of_minimal @ sensitivity.T
        parameters = np.where(loose, np.nan, physical)
        relations = self.white.minimal.size - physical.size
        return PhysicalEstimate(parameters, sensitivity, covariance, relations, disagreement)

    def covariance(self, estimate: PhysicalEstimate) -> FloatArray:
        """Covariance of an estimate, with what priors add and all that widens the deviations of the groups.

        The noise of the groups is independent. What is systematic is that of one machine, so that it adds up.
        """
        ends = np.cumsum([len(model.minimal_units) for model in self.models])[:-1]
        parts = list(zip(self.groups, np.split(estimate.sensitivity, ends, axis=1), strict=True))
        noise = np.sum([group.by_noise(part) for group, part in parts], axis=0)
        systematic = np.sum([np.sqrt(group.systematic(part)) for group, part in parts], axis=0)
        by_prior = np.diag(estimate.restricted.by_prior) if estimate.restricted else 0.0
        return with_deviations(estimate.covariance, np.sqrt(noise + np.square(systematic) + by_prior))


def scale_of(physical: FloatArray) -> FloatArray:
    """Sizes of parameters, 1 of those that are zero."""
    return np.where(physical == 0, 1.0, np.abs(physical))
