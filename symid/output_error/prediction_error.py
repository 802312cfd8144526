"""Innovations of a run as a function of the parameters, scaled so that their sum of squares is the likelihood.

The logarithm of the Gaussian likelihood with an unknown level of all noise is, except for constants,
-(N p / 2) log sum |L^-1 e[k]|^2 det(L)^(2/p), L L' being the covariance of the innovations e for noise of unit level:
least squares of the scaled innovations is maximum likelihood. The state at the beginning of each stretch is free; it is
projected out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Self

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.data import Log
from symid.last_values import LastValues
from symid.output_error.predicted_log import OutputErrorPrediction
from symid.output_error.predictor import Predictor, predictor
from symid.output_error.run import JointMotion, LogRun, motion_between
from symid.output_error.sampled_plant import SampledPlant, sampled_plant
from symid.simulation import ForwardDynamics, Plant

_LARGEST_RATIO = 14.0
"""Largest logarithm of a ratio of noise levels; beyond it the smaller noise has no influence."""
_FORGOTTEN = 1e-10  # part of the initial state that is left
_FIRST_RATIO = 2.0  # first logarithm of the noise of a force over that of the first reading
_NUISANCE_STEP = 1e-2  # of these logarithms, for differences
_EXCERPT_SAMPLES = 6000  # of the excerpts with which a search begins
_FIRST_DISTURBANCE = -2.0  # the same for a disturbance


@dataclass(frozen=True, eq=False)
class PredictionError:
    """Scaled innovations of a run as a function of parameters and noise ratios.

    `motions` are those of the joints with nonlinear laws. With free timing, the time by which the forces are recorded
    late is a nuisance parameter.
    """

    dynamics: ForwardDynamics
    run: LogRun
    motions: tuple[JointMotion, ...]
    free_timing: bool = False
    _memory: LastValues = field(default_factory=LastValues, init=False, repr=False)

    @property
    def first_nuisance(self) -> FloatArray:
        """Nuisance parameters to begin with.

        Logarithms of the noise levels of the forces and of the disturbances (for their effect in one sample) and of the
        other readings, relative to that of the first reading; then the further lateness of the forces in samples, if it
        is free.
        """
        # Drives whose noise enters the same reading share a noise level: the levels cannot be distinguished.
        levels = [_FIRST_RATIO] * len(set(self._driven)) + [_FIRST_DISTURBANCE] * len(self._disturbed)
        return np.array([*levels, *[0.0] * (len(self.run.signals) - 1 + self.free_timing)])

    @property
    def nuisance_steps(self) -> FloatArray:
        """Their difference steps."""
        return np.full(self.first_nuisance.size, _NUISANCE_STEP)

    def innovations(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Innovations of shape (n_samples, n_outputs), in the units of the readings."""
        raw, kalman = self._raw(parameters, nuisance)
        whitening, _ = _whitening(kalman)
        return np.asarray(np.linalg.solve(whitening, self._projected(raw, kalman, whitening).T).T)

    def scaled(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Scaled innovations, the stretches one after the other, of shape (n_samples * n_outputs,)."""
        raw, kalman = self._raw(parameters, nuisance)
        return self._projected(raw, kalman, _whitening(kalman)[0]).ravel()

    def noise(self, parameters: Mapping[str, float], nuisance: FloatArray) -> dict[str, float]:
        """Standard deviations of the noise of forces and readings, SI: their ratios at the level observed."""
        raw, kalman = self._raw(parameters, nuisance)
        whitening, unit = _whitening(kalman)
        level = float(np.sqrt(np.mean(self._projected(raw, kalman, whitening) ** 2))) / unit
        forces, readings = self._assumed_noise(self._sampled(self.dynamics.at(parameters)), nuisance)
        drives = [drive.signal for drive in self.dynamics.axis.drives]
        deviations = [*forces[: len(drives)], *readings]
        return {
            name: level * float(std)
            for name, std in zip((*drives, *self.run.signals), deviations, strict=True)
        }

    def prediction(
        self, log: Log, parameters: Mapping[str, float], nuisance: FloatArray
    ) -> OutputErrorPrediction:
        """Readings of the run and their innovations, at the times of its log."""
        innovations = np.full((self.run.time.size, len(self.run.signals)), np.nan)
        innovations[self.run.kept] = self.innovations(parameters, nuisance)
        readings = np.full_like(innovations, np.nan)
        readings[self.run.kept] = self.run.readings
        return OutputErrorPrediction(log.source, self.run.time, readings, innovations, self.run.signals)

    @property
    def trials(self) -> tuple[tuple[int, int], ...]:
        """Iterations of each round of trials of starts, and how many go on after it."""
        return ((4, 8), (10, 3), (25, 1))

    @property
    def has_motion(self) -> bool:
        """Whether the run holds any stretch of motion."""
        return bool(self.run.starts)

    def excerpt(self) -> PredictionError:
        """The run for a few parts of the log."""
        run = self.run.excerpt(_EXCERPT_SAMPLES)
        return replace(self, run=run, motions=run.known_motions)

    def of_noise(self, parameters: Mapping[str, float], nuisance: FloatArray) -> tuple[Self, Self]:
        """Excerpts that hold noise of the levels found and nothing else, and the same noise with the other sign.

        Half their difference is what noise alone makes of the innovations, without laws and constant forces.
        """
        rng, levels, run = np.random.default_rng(0), self.noise(parameters, nuisance), self.excerpt().run
        drives = [levels[drive.signal] for drive in self.dynamics.axis.drives]
        forces = rng.standard_normal(run.forces.shape) * drives
        readings = rng.standard_normal(run.readings.shape) * [levels[name] for name in run.signals]
        ahead, behind = (
            replace(
                self,
                run=replace(run.driven_by(sign * forces), readings=sign * readings),
                motions=run.known_motions,
            )
            for sign in (1.0, -1.0)
        )
        return ahead, behind

    @property
    def is_settled(self) -> bool:
        """Whether nothing follows from the parameters: the motion of all joints is measured, the timing known."""
        return not self.free_timing and self.run.determines_motion

    def updated(
        self, parameters: Mapping[str, float], nuisance: FloatArray
    ) -> tuple[PredictionError, FloatArray]:
        """The run with unmeasured motion and timing evaluated again, and the nuisance parameters for it."""
        motions = self.motions
        if not self.run.determines_motion:
            states, n = self.states(parameters, nuisance), len(self.dynamics.bodies)
            motions = tuple(
                known
                or motion_between(states[:, :n] @ direction, states[:, n : 2 * n] @ direction, self.run.parts)
                for known, (direction, _) in zip(self.run.motions, self.dynamics.laws, strict=True)
            )
        if not self.free_timing:
            return replace(self, motions=motions), nuisance
        run = self.run.recorded_later(float(nuisance[-1]))
        return replace(self, run=run, motions=motions), np.append(nuisance[:-1], 0.0)

    def states(self, parameters: Mapping[str, float], nuisance: FloatArray) -> FloatArray:
        """Predicted displacements and velocities of the bodies, of shape (n_samples, 2 n)."""
        plant = self.dynamics.at(parameters)
        sampled, kalman = self._predictor(plant, nuisance)
        inputs = self._inputs(plant, sampled, nuisance)
        n = len(kalman.innovations.A)
        recursion = kalman.innovations.observed(np.eye(n))
        states = recursion.response(inputs, self.run.starts)
        raw = inputs[:, : len(self.run.signals)] - states @ sampled.output.T
        for first, last in self._stretches:
            free = kalman.innovations.free_response(last - first)
            start = np.linalg.lstsq(free.reshape(-1, n), -raw[first:last].ravel(), rcond=None)[0]
            states[first:last] += recursion.free_response(last - first) @ start
        return np.asarray(states @ sampled.basis.T)

    @cached_property
    def _stretches(self) -> tuple[tuple[int, int], ...]:
        ends = [*self.run.starts[1:], len(self.run.readings)]
        return tuple(zip(self.run.starts, ends, strict=True))

    @cached_property
    def _forces(self) -> tuple[FloatArray, FloatArray]:
        """Forces of the drives, then values of each law of each joint: in the parts of the intervals, at the samples.

        Of shapes (n_samples, n_parts * n_forces) and (n_samples, n_forces).
        """
        joints = zip(self.motions, self.dynamics.laws, strict=True)
        laws = [(term, motion) for motion, (_, terms) in joints for term in terms]
        within = [term.forces(motion.q, motion.v)[:, :, None] for term, motion in laws]
        at = [term.forces(motion.q_at, motion.v_at)[:, None] for term, motion in laws]
        inside = np.concatenate([self.run.drive, *within], axis=2)
        return inside.reshape(len(inside), -1), np.hstack([self.run.drive_at, *at])

    @cached_property
    def _driven(self) -> tuple[int, ...]:
        """Index of the reading whose units measure the noise of each drive; with one drive, the first."""
        axis, signals = self.dynamics.axis, self.run.signals
        if len(axis.drives) == 1:
            return (0,)
        return tuple(signals.index(signal) if signal in signals else 0 for signal in axis.controlled_signals)

    @cached_property
    def _disturbed(self) -> tuple[int, ...]:
        """Indices of the other readings; each has a disturbing force."""
        return tuple(i for i in range(len(self.run.signals)) if i not in self._driven)

    def _sampled(self, plant: Plant) -> SampledPlant:
        """The plant from sample to sample; the last one is kept, as noise ratios and timing do not change it."""
        signals = self.run.signals
        disturbed = [signals[i] for i in self._disturbed]
        made = partial(sampled_plant, plant, signals, self.run.period, self.run.parts, disturbed)
        return self._memory.of("sampled", plant, made)

    def _assumed_noise(self, sampled: SampledPlant, nuisance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Noise of the forces and of the readings, up to a common factor."""
        ratios = nuisance[: nuisance.size - self.free_timing]
        levels = np.exp(_LARGEST_RATIO * np.tanh(ratios / _LARGEST_RATIO))
        effects = sampled.output @ sampled.transition @ sampled.noise_effects
        places = [*self._driven, *self._disturbed]
        seen = np.abs(effects + sampled.noise_feedthrough)[places, range(len(places))]
        seen = np.where(seen > 0, seen, np.max(np.abs(effects), initial=np.finfo(float).tiny))
        first = sorted(set(self._driven))
        first_levels, others = levels[: len(first)], levels[len(first) :]
        sources = np.append(
            first_levels[[first.index(i) for i in self._driven]], others[: len(self._disturbed)]
        )
        readings = np.append(1.0, others[len(self._disturbed) :])
        return sources * self.run.steps[places] / seen, self.run.steps * readings

    def _predictor(self, plant: Plant, nuisance: FloatArray) -> tuple[SampledPlant, Predictor]:
        sampled = self._sampled(plant)
        return sampled, predictor(sampled, *self._assumed_noise(sampled, nuisance))

    def _raw(self, parameters: Mapping[str, float], nuisance: FloatArray) -> tuple[FloatArray, Predictor]:
        plant = self.dynamics.at(parameters)
        sampled, kalman = self._predictor(plant, nuisance)
        return kalman.innovations.response(self._inputs(plant, sampled, nuisance), self.run.starts), kalman

    def _inputs(self, plant: Plant, sampled: SampledPlant, nuisance: FloatArray) -> FloatArray:
        """Readings without what forces add to them directly, and effects of the forces on the state."""
        run, m = self.run, sampled.n_drives
        joints = [m + j for j, law in enumerate(plant.laws) for _ in law.terms]
        weights = [1.0] * m + [term.parameter for law in plant.laws for term in law.terms]
        places, (within, at) = [*range(m), *joints], self._forces
        at_once = sampled.feedthrough[:, places] * weights
        effects = within @ _rows(sampled.effects[:, :, places] * weights)
        effects += sampled.effects[:, :, -1].sum(axis=0)
        direct = at @ at_once.T + sampled.feedthrough[:, -1]
        if run.course == "held" and sampled.read_forces.any():  # the mean of both sides of a jump is read
            direct += (run.drive[:, 0] - run.drive_at) / 2 @ sampled.read_forces.T
        if self.free_timing:
            rate = run.drive_rate.reshape(len(run.drive), -1)
            effects += nuisance[-1] * (rate @ _rows(sampled.effects[:, :, :m]))
            direct += nuisance[-1] * (run.drive_rate_at @ at_once[:, :m].T)
        return np.hstack([run.readings - direct, effects])

    def _projected(self, raw: FloatArray, kalman: Predictor, whitening: FloatArray) -> FloatArray:
        """Innovations without what any initial state of a stretch could make."""
        n = len(kalman.innovations.A)
        errors = raw @ whitening.T
        longest = max(last - first for first, last in self._stretches)
        free = whitening @ kalman.innovations.free_response(longest, _FORGOTTEN)
        if not np.all(np.isfinite(free)):
            raise np.linalg.LinAlgError("the predictor is not stable")
        # The initial state of a stretch is unknown, and its effect decays within `memory` samples. Projecting these
        # innovations on the complement of the free responses minimises their squares over all initial states.
        memory = len(free)
        bases: dict[int, FloatArray] = {}
        for first, last in self._stretches:
            length = min(last - first, memory)
            if length not in bases:
                bases[length] = _orthonormal(free[:length].reshape(-1, n))
            beginning = errors[first : first + length].ravel()
            remaining = beginning - bases[length] @ (bases[length].T @ beginning)
            errors[first : first + length] = remaining.reshape(length, -1)
        return errors


def _whitening(kalman: Predictor) -> tuple[FloatArray, float]:
    """Whitening matrix of determinant 1 for the innovations, and their level for unit noise."""
    root = np.linalg.cholesky(kalman.covariance)
    level = float(np.exp(np.mean(np.log(np.diag(root)))))
    return level * np.linalg.inv(root), level


def _rows(effects: FloatArray) -> FloatArray:
    """Effects of shape (n_parts, n_states, n_forces) as rows, for forces in the order of `PredictionError._forces`."""
    return effects.transpose(0, 2, 1).reshape(-1, effects.shape[1])


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of columns; LAPACK's own functions, as those of numpy take several times as long."""
    reflectors, factors, _, _ = scipy.linalg.lapack.dgeqrf(columns)
    return np.asarray(scipy.linalg.lapack.dorgqr(reflectors[:, : factors.size], factors)[0])
