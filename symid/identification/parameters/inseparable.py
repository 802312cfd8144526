"""Parameters that a log determines only in combinations, separated by priors.

A prior is a measurement of its parameter: with the means of as few priors as the structure leaves open appended to the
minimal parameters, the map has a single solution, whose covariance holds the variances of these priors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.identification.parameters.constraints import Constraints
from symid.identification.parameters.physical import (
    PhysicalEstimate,
    Restricted,
    open_by_structure,
    physical_estimates,
)


def estimates_by_priors(
    model: GeneratedModel,
    minimal: FloatArray,
    covariance: FloatArray,
    constraints: Constraints,
    start: Mapping[str, float] | None = None,
) -> tuple[PhysicalEstimate, ...]:
    """Physical parameters that the log determines with priors of inseparable ones.

    It serves where `physical_estimates` finds no solution. As few priors are used as determine all parameters. Empty if
    they leave parameters undetermined.
    """
    used: list[str] = []
    for name in open_by_structure(model):
        if name in constraints.prior and name in open_by_structure(_with_measured(model, used)):
            used.append(name)
    extended = _with_measured(model, used)
    if not used or open_by_structure(extended):
        return ()
    means, deviations = np.array([constraints.prior[name] for name in used]).T
    n = minimal.size
    wider = np.zeros((n + means.size, n + means.size))
    wider[:n, :n], wider[n:, n:] = covariance, np.diag(deviations**2)
    found = physical_estimates(extended, np.append(minimal, means), wider, start)
    return tuple(_of_log(one, n, deviations) for one in found)


def _with_measured(model: GeneratedModel, names: Sequence[str]) -> GeneratedModel:
    """The model with some physical parameters among its minimal ones."""
    places = [list(model.physical_units).index(name) for name in names]

    def minimal_parameters(*physical: FloatArray) -> FloatArray:
        return np.append(model.minimal_parameters(*physical), [physical[i] for i in places])

    units = {f"prior of {name}": model.physical_units[name] for name in names}
    return replace(
        model,
        minimal_units={**model.minimal_units, **units},
        minimal_parameters=minimal_parameters,
        physical_parameters=None,
        branches=0,
    )


def _of_log(found: PhysicalEstimate, n: int, deviations: FloatArray) -> PhysicalEstimate:
    """The estimate as one of n minimal parameters, to whose covariance priors add."""
    by_prior = found.sensitivity[:, n:] * deviations
    return replace(
        found,
        sensitivity=found.sensitivity[:, :n],
        restricted=Restricted(free=found, by_prior=by_prior @ by_prior.T, held={}),
    )
