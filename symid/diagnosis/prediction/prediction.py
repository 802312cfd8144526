"""The axis under a record at given parameters: motion of every joint, for forces of effects, and predicted outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import ComplexArray, FloatArray, add_outer
from symid.diagnosis.prediction.axis_motion import AxisMotion
from symid.diagnosis.prediction.hidden_motion import IntegratedEffects, integrated_motion
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.response import (
    ForcePath,
    Impedance,
    as_measured,
    axis_response,
    noise_weights,
)
from symid.simulation import Plant


@dataclass(frozen=True, eq=False)
class Prediction(AxisMotion):
    """Motion of every joint of an axis under a record, and its outputs, at given parameters."""

    forces: ComplexArray  # shape (n_bins, n_bodies): forces of effects on the bodies
    # shape (n_bins, n_bodies): forces of effects that were integrated with the hidden motion; `displacements` are then
    # the integrated ones, and the response has equivalent springs and dampers in place of these effects
    of_integrated: ComplexArray | None = None
    impedances: tuple[Impedance, ...] = ()  # further ones on the axis
    # errors of the model that the weights of the outputs allow for, see `noise_weights`; 1 each if empty
    levels: tuple[float, ...] = ()
    path: ForcePath | None = None  # of the logged forces, with effects of drives
    # entries of `Record.hidden_terms` that are integrated with the hidden motion
    integrated_terms: tuple[tuple[int, int], ...] = ()
    # whether the motion at which integrated laws act is observed with the measured force, see `hidden_motion`
    follows: bool = False
    # shape (n_outputs, n_bins): changes of the outputs by misreadings and other masses, which load the bearings too
    changes: ComplexArray | None = None

    def leveled(self, levels: Sequence[float]) -> Prediction:
        """The prediction with weights that allow for other errors of the model."""
        return replace(self, levels=tuple(levels))

    def released(self) -> Prediction:
        """The prediction without cached arrays, which are recomputed on demand."""
        return replace(self, response=self.response.released())

    @cached_property
    def density(self) -> FloatArray:
        """Weights of the outputs over frequency, of shape (n_outputs, n_bins)."""
        return noise_weights(self.record, self.response, self.levels, self.path)

    @cached_property
    def noise_density(self) -> FloatArray:
        """Weights of the outputs over frequency that allow for noise only."""
        return noise_weights(self.record, self.response, (), self.path) if self.levels else self.density

    def noise_through(self, density: FloatArray) -> FloatArray:
        """Mean square that noise alone leaves in the rows of each output under given weights, shape (n_outputs,)."""
        taper = self.record.taper**2
        return np.asarray((density / self.noise_density) ** 2 @ taper / np.sum(taper))

    @property
    def acting(self) -> ComplexArray:
        """Forces of the drives after gains, limits, lags and delays, from the logged ones; shape (n_drives, n_bins)."""
        measured = self.record.measured
        return (measured if self.path is None else self.path.acting(measured))[: self.record.n_drives]

    def passed_on(self, outputs: ComplexArray) -> ComplexArray:
        """Outputs, or small changes of them, after delays and lags, of shape (..., n_outputs, n_bins)."""
        return outputs if self.path is None else np.asarray(self.path.response * outputs)

    @cached_property
    def laws(self) -> tuple[tuple[FloatArray, tuple[ComplexArray, ...]], ...]:
        """Direction of each joint with nonlinear laws, and the spectra of their expressions."""
        found = []
        for direction, terms in self.record.dynamics.laws:
            joint = self.along(direction)
            found.append((direction, tuple(joint.law_force(term) for term in terms)))
        return tuple(found)

    @cached_property
    def law_forces(self) -> ComplexArray:
        """Forces of the laws and of constants on the bodies, of shape (n_bins, n_bodies)."""
        return self.law_forces_of(self.response.plant)

    def law_forces_of(self, plant: Plant) -> ComplexArray:
        """The same with the values of another plant, at this motion."""
        total = np.zeros((self.record.n_bins, len(plant.bodies)), dtype=complex)
        for i, ((direction, spectra), law) in enumerate(zip(self.laws, plant.laws, strict=True)):
            for k, (term, spectrum) in enumerate(zip(law.terms, spectra, strict=True)):
                if (i, k) not in self.integrated_terms:
                    add_outer(total, spectrum, -term.parameter * direction)
        total[0] += plant.constant * self.record.n_extended
        return total

    @cached_property
    def outputs(self) -> ComplexArray:
        """Drive forces and further readings without effects of drives and of sensors, shape (n_outputs, n_bins)."""
        if self.of_integrated is not None:
            found = self._from_motion(self.law_forces + self.forces + self.of_integrated)
        else:
            found = self.response.of_motions(self.record.motions)
            found = found + self.response.of_forces(self.law_forces + self.forces)
        # A force sensor reads the nonlinear laws of its spring too.
        for i, name in enumerate(self.record.readings, self.record.n_drives):
            reading = self.response.plant.sensors[name]
            if reading.law is not None:
                terms = self.response.plant.laws[reading.law].terms
                spectra = self.laws[reading.law][1]
                force = sum(term.parameter * x for term, x in zip(terms, spectra, strict=True))
                found[i] = found[i] + reading.per_force * force
        return found

    def _from_motion(self, forces: ComplexArray) -> ComplexArray:
        """Outputs computed from the displacements: the force from the equation of a driven body, and the readings."""
        plant, s = self.response.plant, 1j * self.record.omega
        body = min(np.flatnonzero(plant.drive), key=lambda i: abs(plant.stiffness[i, i]))
        rows = zip((plant.mass[body], plant.damping[body], plant.stiffness[body]), (2, 1, 0), strict=True)
        balance = sum(s**k * (row @ self.displacements) for row, k in rows) - forces[:, body]
        force = balance / plant.drive[body]
        readings = (plant.sensors[name] for name in self.record.readings)
        return np.stack(
            [force, *(np.sum(r.at(s) * self.displacements, 0) + r.drives[0] * force for r in readings)]
        )

    @cached_property
    def hidden(self) -> tuple[ComplexArray, ...]:
        """Outputs for forces along each of `free_directions`, of shape (n_outputs, n_bins) each."""
        return tuple(self.response.of_force(direction) for direction in self.free_directions)

    def column(self, joint: RecordedJoint, force: ComplexArray) -> ComplexArray:
        """Change of the predicted outputs by forces that oppose the motion of a joint, of shape (..., n_bins).

        A force sensor in a spring reads a force that acts in this spring.
        """
        change = -self.response.of_force(joint.direction) * force[..., None, :]
        for i, place in enumerate(self.record.springs_read, self.record.n_drives):
            if place == joint.name:
                change[..., i, :] += force
        return change


def prediction_of(
    record: Record,
    parameters: Mapping[str, float],
    *,
    before: Prediction | None = None,
    like: Prediction | None = None,
    forces: ComplexArray | None = None,
    impedances: Sequence[Impedance] = (),
    integrated: IntegratedEffects | None = None,
    follows: bool = False,
    changes: ComplexArray | None = None,
    path: ForcePath | None = None,
) -> Prediction:
    """The axis under a record at physical parameters, SI.

    The law forces of the prediction `before` move hidden joints; without it, only the linear part does. The response
    and impedances of the prediction `like` are reused. Effects add `forces`, (n_bins, n_bodies), and `impedances`; they
    may be `integrated` with the hidden motion, which `follows` the measured force or not. Other effects make `changes`
    of the outputs, or change the `path` of the forces.
    """
    declared_terms = record.hidden_terms if integrated else ()
    if before is not None and before.integrated_terms != declared_terms:
        before = replace(before, integrated_terms=declared_terms)
    if before is not None and before.parameters == parameters and not (impedances or before.impedances):
        like = before  # an implicit force iterates at the same parameters
    if like is not None:
        response, impedances = like.response, like.impedances
    else:
        response = axis_response(record, parameters, impedances)
    of_effects = np.zeros((record.n_bins, len(response.plant.bodies)), complex) if forces is None else forces
    of_integrated, misread = None, None
    if integrated:
        acting = of_effects if before is None else of_effects + before.law_forces_of(response.plant)
        moved, observed, law_forces = integrated_motion(record, response.plant, acting, integrated)
        of_integrated, misread = np.zeros_like(of_effects), integrated.misread
        for force, (direction, _) in zip(law_forces, integrated.laws, strict=True):
            add_outer(of_integrated, force, -direction)
    else:
        acting = of_effects if before is None else of_effects + before.law_forces
        moved = observed = response.displacements(record.motions, acting)
    return Prediction(
        record,
        parameters,
        response,
        displacements=moved,
        observed=as_measured(record, response, observed, misread),
        forces=of_effects,
        of_integrated=of_integrated,
        impedances=tuple(impedances),
        levels=() if before is None else before.levels,
        path=path,
        integrated_terms=declared_terms,
        follows=follows,
        changes=changes,
    )
