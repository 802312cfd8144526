"""Expected errors of identified parameters for a setting, to first order: bias of clean rows, variance by noise.

With rows W, y of a noise-free log, weights S and the true minimal parameters X, the estimate is off by

    (W'S^2 W)^-1 W'S^2 (y - W X + e) = b + G e,

where e is the noise of the signals as it passes filters, differences and decimation: the row of an equation at one time
is a sum of convolutions of white noises. Its spectrum is known, and so is the covariance of G e, without a single draw.
Noise in W draws the estimate towards zero, which `identify` takes off where its share in a direction is not too large,
and what remains adds to the bias.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.identification import physical_estimates
from symid.identification.bias import MOST_TAKEN
from symid.identification.noise import noise_of_rows, response_of_rows
from symid.identification.observation import Observation

_HIGHEST_CONDITION = 1e10
"""Condition of the scaled normal matrix beyond which parameters are not determined."""


def expected_errors(
    model: GeneratedModel,
    log: Log,
    seen: Observation,
    parameters: Mapping[str, float],
    levels: Mapping[str, float],
) -> tuple[FloatArray, FloatArray] | None:
    """Relative bias and relative deviation of each physical parameter; None where they are not determined.

    Parameters
    ----------
    model : GeneratedModel
        The model observed.
    log : Log
        A noise-free log.
    seen : Observation
        Its rows, with friction beside the drive taken off as large as it is.
    parameters : mapping of str to float
        True physical parameters.
    levels : mapping of str to float
        One-sided power spectral density of the white noise of each signal, in the square of its unit by Hz.
    """
    true = np.array([parameters[name] for name in model.physical_units])
    X = np.asarray(model.minimal_parameters(*true), dtype=np.float64)
    W, rest = (np.where(seen.valid[..., None], x, 0.0) for x in (seen.W, (seen.y - seen.W @ X)[..., None]))
    rows = seen.valid.sum(axis=1)
    noise, error = noise_of_rows(model, log, seen.preparation, levels), np.append(X, -1.0)
    # Equations are weighted by the residual that the fit will leave: noise, and what rows of a setting are off.
    squares = np.einsum("a,jab,b->j", error, noise, error)
    squares += np.sum(rest[..., 0] ** 2, axis=1) / np.maximum(rows, 1)
    weights = 1.0 / np.maximum(squares, np.finfo(float).tiny)
    size = np.sqrt(np.einsum("j,jta,jta->a", weights, W, W))
    if rows.sum() <= X.size or not np.all(size > 0.0):
        return None
    W = W / size
    slopes = np.einsum("j,jta->ajt", weights, W).reshape(X.size, -1)
    by_noise = np.einsum("j,jab->ab", weights * rows, noise)[:-1] / size[:, None]
    directions, shares = _directions(slopes @ W.reshape(-1, X.size), by_noise[:, :-1] / size)
    if directions is None:
        return None
    # `identify` takes the bias by noise off where its share is not too large: there errors grow, elsewhere it stays.
    taken = shares < MOST_TAKEN
    growth = np.where(taken, 1.0 / (1.0 - np.where(taken, shares, 0.0)), 1.0)
    inverse = (directions * growth) @ directions.T / size[:, None]
    left = directions @ np.where(taken, 0.0, -directions.T @ (by_noise @ error)) / size
    bias = inverse @ (slopes @ rest.ravel()) + left
    # Products of the noise of W with that of y add as much variance again as the noise has a share in W.
    G = (directions * growth**1.5) @ directions.T / size[:, None] @ slopes
    covariance = _covariance(model, log, seen, G.reshape(X.size, *seen.y.shape), X, levels)
    found = physical_estimates(model, X + bias, covariance, parameters)
    if not found:
        return None
    counts = true != 0.0
    relative = (
        found[0].parameters[counts] / true[counts] - 1.0,
        found[0].standard_deviations[counts] / abs(true[counts]),
    )
    return relative if np.all(np.isfinite(relative)) else None


def _directions(normal: FloatArray, by_noise: FloatArray) -> tuple[FloatArray | None, FloatArray]:
    """Directions D with D'(W'S^2 W) D = 1 for noisy rows, and the share of noise in each; None for dependent rows."""
    # W'S^2 W of noisy rows is the clean one plus that of the noise. Two eigenvalue problems diagonalise both at once.
    values, vectors = np.linalg.eigh(normal + by_noise)
    if not values[0] > values[-1] / _HIGHEST_CONDITION:
        return None, values
    root = vectors / np.sqrt(values)
    shares, turned = np.linalg.eigh(root.T @ by_noise @ root)
    return root @ turned, shares


def _covariance(
    model: GeneratedModel,
    log: Log,
    seen: Observation,
    G: FloatArray,
    X: FloatArray,
    levels: Mapping[str, float],
) -> FloatArray:
    """Covariance of G e, with G of shape (n_parameters, n_equations, n_rows)."""
    factor, rate = seen.preparation.decimation or 1, log.sampling_frequency
    # One row is one sample of the log: between the rows that are kept, G is zero.
    n = scipy.fft.next_fast_len(2 * G.shape[2] * factor, real=True)
    spread = np.zeros((*G.shape[:2], G.shape[2], factor))
    spread[..., 0] = G
    frequency: FloatArray = np.linspace(0.0, rate * (n // 2) / n, n // 2 + 1)
    gains = np.fft.rfft(spread.reshape(*G.shape[:2], -1), n)
    covariance = np.zeros((X.size, X.size))
    for name, level in levels.items():
        response = response_of_rows(model, log, seen.preparation, name, np.append(X, -1.0), frequency)
        passed = np.einsum("ajf,jf->af", gains.conj(), response)
        covariance += level * rate / n * (passed @ passed.conj().T).real
    return covariance
