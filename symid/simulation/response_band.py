"""The band of a frequency response whose parameters are uncertain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import FloatArray, IntArray
from symid.axis import Axis
from symid.estimation.correlation import correlation_matrix
from symid.simulation.forward_dynamics import forward_dynamics
from symid.simulation.frequency_response import FrequencyResponse, plant_response

_DRAWS, _SEED = 200, 0
_MOST_PLACES = 300
_WIDEST = 5.0
"""Largest relative deviation of a drawn parameter: an undetermined one varies over decades."""
_SIDES = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class ResponseBand:
    """Band of 95 % of a frequency response, each array of shape (n,)."""

    frequency: FloatArray  # Hz
    # lowest, highest: magnitude
    lowest: FloatArray
    highest: FloatArray
    # latest, earliest: phase relative to that of the response, rad
    latest: FloatArray
    earliest: FloatArray


def response_band(
    axis: Axis,
    values: Mapping[str, float],
    deviations: FloatArray,
    covariance: FloatArray,
    of: FrequencyResponse,
) -> ResponseBand:
    """Quantiles of the responses of parameters drawn around those identified.

    At a sharp resonance a response is not linear in its parameters: the peak moves by more than its width. Parameters
    are drawn log-normally, so that a mass stays positive; the draws are the same each time.

    Parameters
    ----------
    axis : Axis
        The identified axis.
    values : mapping of str to float
        Its physical parameters, SI.
    deviations : array of shape (n_parameters,)
        Their standard deviations; infinite or nan where undetermined.
    covariance : array of shape (n_parameters, n_parameters)
        Covariance from which the correlations are taken.
    of : FrequencyResponse
        The response of these values.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation.frequency_response import identified_response
    >>> axis, values = load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 1.0}
    >>> f, none = np.array([1.0]), np.zeros(1)
    >>> identified = identified_response(axis, values, "q", f, 1)
    >>> of = FrequencyResponse("F", "q", "velocity", "", f, none + 0j, none, identified)
    >>> band = response_band(axis, values, np.array([0.02, 0.0, 0.0]), np.diag([4e-4, 0.0, 0.0]), of)
    >>> bool(0.95 < np.log(band.highest / band.lowest)[0] / (2 * 1.96 * 0.01) < 1.05)
    True
    """
    places = _places(of)
    frequency, centre = of.frequency[places], of.identified[places]
    value = np.array(list(values.values()))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(value != 0, np.fmin(deviations / np.abs(value), _WIDEST), 0.0)
        correlations = np.nan_to_num(correlation_matrix(covariance))
    alone = np.where((value == 0) & np.isfinite(deviations), deviations, 0.0)
    factor = _root(correlations)
    # a Latin hypercube: each parameter has the quantiles of a normal one, in an order of its own
    order = np.random.default_rng(_SEED).permuted(np.tile(np.arange(_DRAWS), (value.size, 1)), axis=1).T
    normal = scipy.special.ndtri((order + 0.5) / _DRAWS) @ factor.T
    drawn = value * np.exp(relative * normal) + alone * normal
    dynamics = forward_dynamics(axis)
    plants = (dynamics.at(dict(zip(values, one, strict=True))) for one in drawn.tolist())
    ratios = np.array([plant_response(plant, of.signal, frequency, of.order) / centre for plant in plants])
    low, high = np.quantile(np.abs(ratios), _SIDES, axis=0, method="hazen")
    late, early = np.quantile(np.angle(ratios), _SIDES, axis=0, method="hazen")
    size = np.abs(centre)
    return ResponseBand(frequency, size * low, size * high, late, early)


def _root(correlations: FloatArray) -> FloatArray:
    """A factor of correlations, whose rows keep their length though rounding made them indefinite."""
    np.fill_diagonal(correlations, 1.0)
    spread, directions = np.linalg.eigh(correlations)
    factor = directions * np.sqrt(np.maximum(spread, 0.0))
    return np.asarray(factor / np.linalg.norm(factor, axis=1, keepdims=True))


def _places(of: FrequencyResponse) -> IntArray:
    """Frequencies of a band: evenly over the octaves, and every peak and notch with what is beside it."""
    f, size = np.log(of.frequency), np.abs(of.identified)
    even = np.searchsorted(f, np.linspace(f[0], f[-1], _MOST_PLACES))
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(size))))
    beside = (turns[:, None] + np.arange(-3, 4)).ravel()
    return np.unique(np.clip(np.concatenate([even, beside]), 0, f.size - 1))
