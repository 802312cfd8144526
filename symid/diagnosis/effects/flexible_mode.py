"""The effect of one more mass on a spring."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import ComplexArray, FloatArray, norms_or_one
from symid.diagnosis.effects.effect import (
    FreeForce,
    LinearEffect,
    MatchedFilter,
    Placed,
    Shape,
    best_peaks,
    joint_units,
)
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.record import Record
from symid.units import Unit

_PERIODS_SOUGHT = 3.0  # in the log, of the lowest mode from which a fit starts
_PERIODS_FITTED = 2.0
"""Periods in the log below which a fitted mode may be any slow course: a bare motor that turned to and fro once,
without the Coulomb friction of its model, had one of 1.5 periods (LAAS, real)."""
_LOWEST_MODES = (0.5, 3.0)
"""Range of the lowest frequency sought, Hz: below it, a mode looks like a weight or a spring."""
_SHARE_OF_MOTION = 0.9
_MODES_APART = 1.5
"""Steps of the frequency of a mode, relative to its damping ratio: half the width of its resonance is 2."""
_MODES_TRIED = 6  # for each damping ratio, with the neighbours of each
_LEAST_LEFT = 1e-3  # of the square of a mode that inertia, damping and stiffness leave: less is not resolved
_MOST_DAMPING = 0.3  # damping ratio from which on a mode, beside a delay, looks like a lag
# Half of the squared acceleration must be more than 25 % off the mode, as a single sine does not separate the mode
# from inertia.
_NEAR_MODE, _AT_MODE = 0.25, 0.5
_MOST_OF_MASS = 0.95
_INSIDE = 0.99
_DAMPINGS = (0.01, 0.05, 0.2)
_NEARBY, _LIGHT = (0.8, 1.0, 1.25), 0.1
"""Frequencies, relative to that of a mode at another body, and mass, relative to that of the body, of a fit's start."""


class FlexibleModeEffect(LinearEffect):
    """An additional mass m on a spring, attached to a body, with natural frequency f and damping ratio D.

    Its dynamic stiffness is m s^2 (2 D wa s + wa^2) / (s^2 + 2 D wa s + wa^2) with wa = 2 pi f. The effect is the
    difference from m s^2, so that the declared mass remains the total mass.
    """

    name = "flexible_mode"
    amplitudes = ("m",)
    shape_names = ("f", "D")
    positive = True
    may_be_zero = ("D",)

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        """It is lighter than its body, and swings more than twice in the log.

        Before, a friction that turns with the motion does the same.
        """
        periods = placed.shape[0] * prediction.record.duration
        lighter = placed.amplitudes[0] < _whole_mass(prediction, placed.at)
        return super().is_possible(prediction, placed) and periods > _PERIODS_FITTED and lighter

    def is_plausible(self, prediction: Prediction, placed: Placed) -> bool:
        """Its mass is part of that of the body, and the axis moves at its frequency and at others."""
        record, whole = prediction.record, _whole_mass(prediction, placed.at)
        (mass,), (frequency, damping) = placed.amplitudes, placed.shape
        _, highest = _modes_seen(record)
        if not (mass < _MOST_OF_MASS * whole and frequency < _INSIDE * highest and damping < _MOST_DAMPING):
            return False
        omega = record.omega
        power = np.abs(omega**2 * prediction.bodies[placed.at].modelled) ** 2
        near = np.abs(omega - 2 * math.pi * frequency) < _NEAR_MODE * omega
        return bool(power[near].sum() < _AT_MODE * power.sum())

    def joint(self, prediction: Prediction, place: str) -> RecordedJoint:
        return prediction.bodies[place]

    def places(self, prediction: Prediction) -> Iterable[str]:
        return tuple(prediction.bodies)

    def shapes(self, prediction: Prediction, place: str, matched_filter: MatchedFilter) -> Iterable[Shape]:
        lowest, highest = _modes_seen(prediction.record)
        octaves = max(math.log(highest / lowest), 0.0)
        found = []
        for damping in _DAMPINGS:
            hertz = np.geomspace(lowest, highest, 1 + math.ceil(octaves / (_MODES_APART * damping)))
            score = self._scores(prediction, place, matched_filter, [(float(f), damping) for f in hertz])
            peaks = best_peaks(np.pad(score, 1), np.pad(hertz, 1, "edge"), _MODES_TRIED)
            apart = np.abs(np.log(np.divide.outer(hertz, peaks))).min(axis=1)
            found += [(float(f), damping) for f in hertz[apart < 1.01 * _MODES_APART * damping]]
        return found

    def _scores(
        self, prediction: Prediction, place: str, matched_filter: MatchedFilter, shapes: Sequence[Shape]
    ) -> FloatArray:
        """Square of the residual that each mode explains, as if the weights acted on frequencies alone."""
        body, record = prediction.bodies[place], prediction.record
        response = -prediction.response.of_force(body.direction)
        weighted = response * prediction.density * record.taper * body.modelled
        amplitude = np.linalg.norm(weighted, axis=0)
        # Apart from the inertia, damping and stiffness that the axis has: projection on 1, s and s^2.
        plain = np.stack([(1j * record.omega) ** k for k in range(3)]) * amplitude
        plain = (plain / norms_or_one(plain, axis=1)[:, None]).conj()
        gram = np.linalg.pinv((plain @ plain.conj().T).real, rcond=1e-10, hermitian=True)
        wanted = record.from_grid(matched_filter(response)).conj() * body.modelled
        scores = np.zeros(len(shapes))
        for i, shape in enumerate(shapes):
            mode = self.stiffness(record.omega, shape)
            explained = max(float((mode @ wanted).real), 0.0)
            mode *= amplitude
            taken, whole = (plain @ mode).real, float(np.vdot(mode, mode).real)
            if whole > 0:
                scores[i] = explained**2 / max(whole - taken @ gram @ taken, _LEAST_LEFT * whole)
        return scores

    def elsewhere(self, prediction: Prediction, placed: Placed) -> Iterable[Placed]:
        """A heavy mode of a hidden body, which a light one of a driven body may imitate to the noise."""
        for place, body in prediction.bodies.items():
            if place == placed.at or not prediction.record.is_hidden(body.direction):
                continue
            mass = _LIGHT * float(body.direction @ prediction.response.plant.mass @ body.direction)
            for factor in _NEARBY:
                shape = self.bounded(prediction, place, (factor * placed.shape[0], _DAMPINGS[-2]))
                yield replace(placed, at=place, shape=shape, amplitudes=(mass,))

    def bounded(self, prediction: Prediction, place: str, shape: Shape) -> Shape:
        lowest, highest = _modes_seen(prediction.record)
        return float(np.clip(shape[0], 0.5 * lowest, highest)), float(np.clip(shape[1], 1e-3, 1.0))

    def stiffness(self, omega: FloatArray, shape: Shape) -> ComplexArray:
        own, square = 2 * math.pi * shape[0], omega**2
        return np.asarray(-(square**2) / (own**2 - square + 2j * shape[1] * own * omega), dtype=np.complex128)

    def free_forces(self, prediction: Prediction, placed: Placed) -> tuple[FreeForce, ...]:
        """Force of the mass that rings from before the log; a weakly damped one does so for long."""
        (frequency, damping), s = placed.shape, 1j * prediction.record.omega
        own = 2 * math.pi * frequency
        ringing = 1.0 / ((s / own) ** 2 + 2 * damping * (s / own) + 1.0)
        return ((prediction.bodies[placed.at].direction, np.asarray(ringing)),)

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        force, length = joint_units(prediction, place)
        return str(force * Unit.of("s") ** 2 / length), "Hz", "1"


def _whole_mass(prediction: Prediction, place: str) -> float:
    """Mass or inertia of a body, with that of a mode on it."""
    direction = prediction.bodies[place].direction
    return float(direction @ prediction.response.plant.mass @ direction)


def _modes_seen(record: Record) -> tuple[float, float]:
    """Lowest and highest frequency of a mode that a log shows, Hz."""
    lowest = float(np.clip(_PERIODS_SOUGHT / record.duration, *_LOWEST_MODES))
    return lowest, _SHARE_OF_MOTION * record.motion_hz
