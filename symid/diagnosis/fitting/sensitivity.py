"""Derivatives of the prediction by the free values of a model: physical parameters, amplitudes, shapes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import numpy as np

from symid.arrays import ComplexArray, FloatArray, add_outer, least_squares
from symid.diagnosis.effects import JointEffect, LinearEffect, Placed, TransferEffect
from symid.diagnosis.fitting.acting_forces import errors_of_positions
from symid.diagnosis.fitting.state import State, as_read, free_forces, predicted
from symid.diagnosis.prediction.hidden_motion import acts_on_hidden
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.weighting import pulse_spectra

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
    if state.is_integrated:
        return _by_differences(state)
    prediction, placed = state.prediction, state.placed
    values = (_by_values(prediction, placed, item) for item in placed)
    if any(item.effect.varies_with_parameters(prediction, item.at) for item in placed):
        _, here = predicted(state, prediction.parameters, placed)
        of_parameters = _by_hidden_parameters(state, here, _RELATIVE_STEP, nearby=False)
    else:
        of_parameters = _by_parameters(prediction, placed)
    return np.concatenate([of_parameters, *values])


def initial_motion_jacobian(state: State) -> ComplexArray | None:
    """Derivatives by all values of the motion from before the log, shape as `prediction_jacobian`; None if negligible.

    The state in which a log begins is fitted along with the values. Where it rings from before the log, the course
    depends on the values (variable projection, in Kaufman's form: strengths of the pulses are held).
    """
    prediction, weighting, record = state.prediction, state.weighting, state.prediction.record
    if state.is_integrated or not len(state.beginning):
        return None
    begun, error = weighting.flat(state.beginning), weighting.flat(state.rows)
    strengths = least_squares(begun.T, error, _NEGLIGIBLE)
    explained = strengths @ begun
    if explained @ explained < _LEAST_SHARE * np.sum((error - explained) ** 2):
        return None
    pulses = pulse_spectra(record)
    motion = _InitialMotion(prediction, strengths.reshape(-1, len(pulses)) @ pulses, state.placed)
    return np.concatenate([motion.by_parameters(), *motion.by_values()])


@dataclass(frozen=True)
class _InitialMotion:
    """Motion after pulses of force of given spectra, (n_free, n_bins), see `free_forces`."""

    prediction: Prediction
    pulses: ComplexArray
    placed: tuple[Placed, ...]

    def by_parameters(self) -> ComplexArray:
        """Derivatives of its outputs by the physical parameters."""
        driven = self.prediction.response.of_forces(self._forces)[: self.prediction.record.n_drives]
        return _of_parameters(self.prediction, self._displacements, driven)

    def by_values(self) -> Iterator[ComplexArray]:
        """Derivatives of its outputs by each free value of the effects; all but elastic ones have no part in it."""
        response, omega = self.prediction.response, self.prediction.record.omega
        for at, item in enumerate(self.placed):
            for step, moved in _moved(item, _SHAPE_STEP):
                placed = (*self.placed[:at], moved, *self.placed[at + 1 :])
                change = self._forces_with(placed) - self._forces
                if isinstance(item.effect, LinearEffect):
                    direction = item.effect.joint(self.prediction, item.at).direction
                    stiffer = item.effect.impedance(omega, moved) - item.effect.impedance(omega, item)
                    add_outer(change, stiffer * (direction @ self._displacements), -direction)
                yield response.of_forces(change)[None] / step

    def _forces_with(self, placed: Sequence[Placed]) -> ComplexArray:
        """Forces on the bodies with effects at other values, (n_bins, n_bodies)."""
        directions, spectra = zip(*free_forces(self.prediction, placed), strict=True)
        return np.asarray((self.pulses * spectra).T @ np.array(directions))

    @cached_property
    def _forces(self) -> ComplexArray:
        return self._forces_with(self.placed)

    @cached_property
    def _displacements(self) -> ComplexArray:
        rests = np.zeros_like(self.prediction.record.motions)
        return self.prediction.response.displacements(rests, self._forces)


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
    return columns if item.effect.is_of_command else prediction.passed_on(columns)


def _by_hidden_parameters(state: State, here: ComplexArray, share: float, *, nearby: bool) -> ComplexArray:
    """Derivatives by the physical parameters, by differences where they act on hidden motion.

    `here` are the errors at the state's own values, evaluated as those after a step: each evaluation iterates an
    implicit force further. The step is a `share` of the value.
    """
    prediction, parameters, placed = state.prediction, state.prediction.parameters, state.placed
    columns, plant = _by_parameters(prediction, placed), prediction.response.plant
    loaded = _loads(placed)
    for k, name in enumerate(prediction.record.dynamics.parameters):
        step = share * (abs(parameters[name]) or 1.0)
        moved = dict(parameters) | {name: parameters[name] + step}
        if loaded or acts_on_hidden(plant, prediction.record.dynamics.at(moved), prediction.driven_rows[0]):
            columns[k] = (here - predicted(state, moved, placed, nearby=nearby)[1]) / step
    return columns


def _by_differences(state: State) -> ComplexArray:
    """Derivatives by finite differences where hidden motion is integrated: sticking has no frequency response."""
    prediction, parameters, placed = state.prediction, state.prediction.parameters, state.placed
    # Both sides of a difference start from the same state.
    _, here = predicted(state, parameters, placed, nearby=True)

    def column(step: float, placed: tuple[Placed, ...]) -> ComplexArray:
        _, errors = predicted(state, parameters, placed, nearby=True)
        return np.asarray((here - errors) / step)

    columns = list(_by_hidden_parameters(state, here, _INTEGRATED_STEP, nearby=True))
    for at, item in enumerate(placed):
        if not _moves_hidden(prediction, placed, item):
            columns.extend(_by_values(prediction, placed, item))
            continue
        for step, other in _moved(item, _INTEGRATED_STEP):
            columns.append(column(step, (*placed[:at], other, *placed[at + 1 :])))
    return np.stack(columns)


def _moves_hidden(prediction: Prediction, placed: Sequence[Placed], item: Placed) -> bool:
    """Whether an effect may move hidden bodies: a force on measured motion does not."""
    if _loads(placed):
        return True
    if isinstance(item.effect, JointEffect):
        return prediction.record.is_predicted(item.effect.joint(prediction, item.at).direction)
    return not (isinstance(item.effect, TransferEffect) or item.effect.is_of_command)


def _loads(placed: Sequence[Placed]) -> bool:
    """Whether friction is proportional to the drive force, so that all changes of this force move hidden bodies."""
    return any(item.effect.implicit for item in placed)


def _moved(item: Placed, share: float) -> Iterator[tuple[float, Placed]]:
    """For each free value of an effect: the size of a step, a share of the value, and the effect after this step."""
    for i, x in enumerate(item.free):
        step = share * (abs(x) or 1.0)
        yield step, item.with_free((*item.free[:i], x + step, *item.free[i + 1 :]))


def _by_parameters(prediction: Prediction, placed: Sequence[Placed]) -> ComplexArray:
    """Derivatives by the physical parameters, on which the contributions of effects depend too."""
    integrates = prediction.of_integrated is not None  # such motion has the errors of readings in it
    misread = None if integrates else errors_of_positions(prediction, placed)
    return prediction.passed_on(parameter_columns(prediction, misread))


def _shape_columns(
    prediction: Prediction, placed: Sequence[Placed], item: Placed, before: ComplexArray
) -> ComplexArray:
    """Derivatives by the shape of an effect; `before` are its derivatives by its amplitudes."""
    columns = [
        np.tensordot(item.amplitudes, _columns(prediction, placed, moved) - before, 1) / step
        for step, moved in islice(_moved(item, _SHAPE_STEP), item.n_free - len(item.shape), None)
    ]
    return np.reshape(columns, (len(item.shape), *prediction.record.measured.shape)).astype(complex)


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

    return _of_parameters(prediction, displacements, driven, prediction.laws, prediction.record.n_extended)


def _of_parameters(
    prediction: Prediction,
    displacements: ComplexArray,
    driven: ComplexArray,
    laws: Sequence[tuple[FloatArray, Sequence[ComplexArray]]] = (),
    constant: float = 0.0,
) -> ComplexArray:
    """Derivatives of outputs by the physical parameters, for `displacements` and forces `driven` of the drives.

    `laws` are directions and spectra of unit laws, `constant` the spectrum of a constant one at zero frequency.
    """
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
        for (direction, spectra), law in zip(laws, change.laws, strict=bool(laws)):
            for spectrum, term in zip(spectra, law.terms, strict=True):
                if term.parameter:
                    add_outer(forces, term.parameter * spectrum, -direction)
        if change.drives.any():
            forces += driven.T @ change.drives.T
        forces[0] += change.constant * constant
        columns[k] = prediction.response.of_forces(forces)
        for i, signal in enumerate(prediction.record.readings, prediction.record.n_drives):
            read = change.sensors[signal]
            if read.order is None:  # parameters stand in the reading itself
                step = _RELATIVE_STEP * (abs(prediction.parameters[name]) or 1.0)
                moved = dict(prediction.parameters) | {name: prediction.parameters[name] + step}
                changed = dynamics.reading(moved, signal)
                columns[k, i] += np.sum((changed.at(s) - read.at(s)) / step * displacements, axis=0)
                columns[k, i] += (changed.drives - read.drives) / step @ driven
    return columns
