"""Derivatives of the prediction by the free values of a model: physical parameters, amplitudes, shapes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import ComplexArray, least_squares
from symid.diagnosis.effects import JointEffect, Placed, TransferEffect
from symid.diagnosis.fitting.state import State, as_read, free_outputs, passed_on, predicted
from symid.diagnosis.prediction.hidden_motion import acts_on_hidden
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.weighting import starting_pulses

_RELATIVE_STEP = 1e-4
_SHAPE_STEP = 1e-4
_NEGLIGIBLE = 1e-10
"""Relative singular value of unit courses from before the log below which a combination of them counts as none."""
_LEAST_SHARE = 0.05
"""Sum of squares from before the log, relative to the error left, from which it counts: not in logs from rest on."""
_INTEGRATED_STEP = 1e-3
"""Relative step where dry friction holds a body at times: the moments of release move in whole time steps."""


def prediction_jacobian(state: State) -> ComplexArray:
    """Derivatives of the prediction by physical parameters and the effects' values, (n_columns, n_outputs, n_bins)."""
    if _is_integrated(state):
        return _by_differences(state)
    prediction, placed = state.prediction, state.placed
    values = (_by_values(prediction, placed, item) for item in placed)
    return np.concatenate([_by_parameters(prediction, placed), *values])


def initial_motion_jacobian(state: State) -> ComplexArray | None:
    """Derivatives by all values of the motion from before the log, shape as `prediction_jacobian`; None if negligible.

    The state in which a log begins is fitted along with the values. Where it rings from before the log, the course
    depends on the values (variable projection, in Kaufman's form).
    """
    prediction, weighting, placed = state.prediction, state.weighting, state.placed
    if _is_integrated(state) or not len(state.beginning):
        return None
    begun, error = weighting.flat(state.beginning), weighting.flat(state.rows)
    strengths = least_squares(begun.T, error, _NEGLIGIBLE)
    explained = strengths @ begun
    if explained @ explained < _LEAST_SHARE * np.sum((error - explained) ** 2):
        return None

    def motion(prediction: Prediction, placed: Sequence[Placed]) -> ComplexArray:
        pulses = starting_pulses(prediction.record, free_outputs(prediction, placed))
        return np.tensordot(strengths, pulses, 1)

    here, columns = motion(prediction, placed), []
    for value, parameters, others in _each_moved(prediction.parameters, placed):
        there, _ = predicted(state, parameters, others)
        columns.append((motion(there, others) - here) / (_INTEGRATED_STEP * value))
    return np.stack(columns)


def _each_moved(
    parameters: Mapping[str, float], placed: tuple[Placed, ...]
) -> Iterator[tuple[float, Mapping[str, float], tuple[Placed, ...]]]:
    """For each free value its size (1 for zero), and all values with a small share of it added."""
    for name, x in parameters.items():
        value = abs(x) or 1.0
        yield value, dict(parameters) | {name: x + _INTEGRATED_STEP * value}, placed
    for at, item in enumerate(placed):
        for value, moved in _moved(item):
            yield value, parameters, (*placed[:at], moved, *placed[at + 1 :])


def _is_integrated(state: State) -> bool:
    """Whether hidden motion is integrated in time."""
    return bool(state.prediction.integrated_terms) or any(item.integrated for item in state.placed)


def _by_values(prediction: Prediction, placed: Sequence[Placed], item: Placed) -> ComplexArray:
    """Derivatives by the free values of an effect."""
    columns = _columns(prediction, placed, item)
    shapes = _shape_columns(prediction, placed, item, columns)
    return shapes if item.effect.fixed else np.concatenate([columns, shapes])


def _columns(prediction: Prediction, placed: Sequence[Placed], item: Placed) -> ComplexArray:
    """Derivatives by the amplitudes of an effect; its change passes through delays and lags unless it is one."""
    if isinstance(item.effect, TransferEffect):
        unit = replace(item, amplitudes=(1.0,))
        return item.effect.passed_on(prediction, unit, as_read(prediction, placed))[None]
    columns = item.effect.columns(prediction, item.at, item.shape)
    return columns if item.effect.is_of_command else passed_on(prediction, placed, columns)


def _by_differences(state: State) -> ComplexArray:
    """Derivatives by finite differences where hidden motion is integrated: sticking has no frequency response."""
    prediction, parameters, placed = state.prediction, state.prediction.parameters, state.placed
    # Both sides of a difference start from the same state, as each evaluation iterates an implicit force further.
    _, here = predicted(state, parameters, placed, nearby=True)

    def column(value: float, parameters: Mapping[str, float], placed: tuple[Placed, ...]) -> ComplexArray:
        _, errors = predicted(state, parameters, placed, nearby=True)
        return np.asarray((here - errors) / (_INTEGRATED_STEP * value))

    columns = list(_by_parameters(prediction, placed))
    for k, name in enumerate(prediction.record.dynamics.parameters):
        value = abs(parameters[name]) or 1.0
        moved = dict(parameters) | {name: parameters[name] + _INTEGRATED_STEP * value}
        if acts_on_hidden(
            prediction.response.plant, prediction.record.dynamics.at(moved), prediction.driven_rows[0]
        ):
            columns[k] = column(value, moved, placed)
    for at, item in enumerate(placed):
        if not _moves_hidden(prediction, placed, item):
            columns.extend(_by_values(prediction, placed, item))
            continue
        for value, other in _moved(item):
            columns.append(column(value, parameters, (*placed[:at], other, *placed[at + 1 :])))
    return np.stack(columns)


def _moves_hidden(prediction: Prediction, placed: Sequence[Placed], item: Placed) -> bool:
    """Whether an effect may move hidden bodies: a force on measured motion does not."""
    if any(each.effect.implicit and not each.integrated for each in placed):
        return True
    if isinstance(item.effect, JointEffect):
        return prediction.record.is_predicted(item.effect.joint(prediction, item.at).direction)
    return not (isinstance(item.effect, TransferEffect) or item.effect.is_of_command)


def _moved(item: Placed) -> Iterator[tuple[float, Placed]]:
    """For each free value of an effect: the value (1 for zero), and the effect with a step of this value."""
    for i, x in enumerate(() if item.effect.fixed else item.amplitudes):
        value = abs(x) or 1.0
        amplitudes = (*item.amplitudes[:i], x + _INTEGRATED_STEP * value, *item.amplitudes[i + 1 :])
        yield value, replace(item, amplitudes=amplitudes)
    for i, x in enumerate(item.shape):
        value = abs(x) or 1.0
        yield (
            value,
            replace(item, shape=(*item.shape[:i], x + _INTEGRATED_STEP * value, *item.shape[i + 1 :])),
        )


def _by_parameters(prediction: Prediction, placed: Sequence[Placed]) -> ComplexArray:
    """Derivatives by the physical parameters, on which the contributions of effects depend too."""
    misread = [e for item in placed if (e := item.effect.misreading(prediction, item)) is not None]
    columns = parameter_columns(prediction, np.sum(misread, axis=0) if misread else None)
    return passed_on(prediction, placed, columns)


def _shape_columns(
    prediction: Prediction, placed: Sequence[Placed], item: Placed, before: ComplexArray
) -> ComplexArray:
    """Derivatives by the shape of an effect; `before` are its derivatives by its amplitudes."""
    columns = np.zeros((len(item.shape), *prediction.record.measured.shape), dtype=complex)
    for i, value in enumerate(item.shape):
        step = _SHAPE_STEP * abs(value)
        moved = replace(item, shape=(*item.shape[:i], value + step, *item.shape[i + 1 :]))
        columns[i] = np.tensordot(item.amplitudes, _columns(prediction, placed, moved) - before, 1) / step
    return columns


def parameter_columns(prediction: Prediction, misread: ComplexArray | None = None) -> ComplexArray:
    """Derivatives of the predicted outputs by the physical parameters, of shape (n_parameters, n_outputs, n_bins).

    `misread`, (n_drives, n_bins), are reading errors of the driven positions, which the bodies do not follow.
    """
    n_drives = prediction.record.n_drives
    displacements, driven = prediction.displacements, prediction.outputs[:n_drives]
    if misread is not None:
        no_forces = np.zeros((prediction.record.n_bins, 0), dtype=complex)
        displacements = np.asarray(displacements - prediction.response.displacements(misread, no_forces))
        driven = driven - prediction.response.of_motions(misread)[:n_drives]
    dynamics, s = prediction.record.dynamics, 1j * prediction.record.omega
    kinds = (("mass", s**2), ("damping", s), ("stiffness", np.ones(1)))
    columns = np.zeros((len(dynamics.parameters), *prediction.record.measured.shape), dtype=complex)
    for k, name in enumerate(dynamics.parameters):
        change = dynamics.derivative(prediction.parameters, name)
        forces = np.zeros((s.size, len(change.bodies)), dtype=complex)
        for kind, rates in kinds:
            matrix = getattr(change, kind)
            if matrix.any():
                forces -= (rates * (matrix @ displacements)).T
        for (direction, spectra), law in zip(prediction.laws, change.laws, strict=True):
            for spectrum, term in zip(spectra, law.terms, strict=True):
                if term.parameter:
                    forces -= np.multiply.outer(term.parameter * spectrum, direction)
        if change.drives.any():
            forces += driven.T @ change.drives.T
        forces[0] += change.constant * prediction.record.n_extended
        columns[k] = prediction.response.of_forces(forces)
        for i, signal in enumerate(prediction.record.readings, n_drives):
            read = change.sensors[signal]
            if read.order is None:  # parameters stand in the reading itself
                step = _RELATIVE_STEP * (abs(prediction.parameters[name]) or 1.0)
                moved = dict(prediction.parameters) | {name: prediction.parameters[name] + step}
                changed = dynamics.reading(moved, signal)
                columns[k, i] += np.sum((changed.at(s) - read.at(s)) / step * displacements, axis=0)
                columns[k, i] += (changed.drives - read.drives) / step @ driven
    return columns
