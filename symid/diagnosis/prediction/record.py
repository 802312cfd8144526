"""A log in the frequency domain, up to the highest frequency of its motion.

Each drive has a position next to it, its *driven position*; everything else is predicted from these motions. The
predicted signals are the outputs: the force of each drive, and the readings of all further sensors.
"""

import re
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.axis import Body, Spring
from symid.data import Log
from symid.data.quality import step_of
from symid.diagnosis.prediction.driven_positions import signals_of
from symid.diagnosis.prediction.motion_band import force_noise, motion_band, noise_beyond
from symid.diagnosis.prediction.periodic_log import FEWEST_BINS, PeriodicLog
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.quantisation import quantisation_lines
from symid.errors import LogError
from symid.last_values import LastValues
from symid.simulation import ForwardDynamics
from symid.simulation.plants import dry_level

_JUMPS = re.compile(r"np\.(sign|heaviside)\(-?v\b")
"""Code of a law that jumps where the velocity changes its sign."""
LEAST_SAMPLES = 100
"""Least number of samples: with fewer, motion and noise do not separate in the spectrum."""
NOISE_MARGIN, SLOW_SHARE = 6.0, 0.004
"""Multiple of the velocity noise, and share of the highest speed, above which an axis moves."""
_FASTEST, _SLOWER = 0.25, 2**-0.25
"""Largest threshold of motion relative to the top speed, and the ratio of the bands tried in turn."""
_FINEST_FORCE = 1e-4
"""Least noise of a recorded force, relative to half its range: 12 bits have more; with less, it is a command."""
_COMMANDED = 1e-3
"""Assumed error of a drive against its command, relative to half its range: a recorded command shows none."""
_FINEST_READING = 1e-8
"""Noise of the finest reading, relative to its range: an encoder of 24 bits has more."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Record(PeriodicLog):
    """A log of an axis, continued periodically, in the frequency domain."""

    dynamics: ForwardDynamics  # the axis
    # time by which signals were recorded late, s, apart from holds; negative for a force that acts later than recorded
    late: Mapping[str, float] = field(default_factory=dict)
    # time for which a force is held, s
    holds: Mapping[str, float] = field(default_factory=dict)
    # joints with measured motion, which are the same in all models
    driven_joints: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)
    # cache of values that follow from the log alone
    memory: LastValues = field(default_factory=LastValues, init=False, repr=False)

    @cached_property
    def forces(self) -> tuple[str, ...]:
        """Signals of the drives."""
        return tuple(drive.signal for drive in self.dynamics.axis.drives)

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Predicted signals: forces, and readings of further sensors."""
        return (*self.forces, *self.readings)

    @cached_property
    def driven_bodies(self) -> frozenset[str]:
        """Bodies in whose joint a drive acts."""
        drives = self.dynamics.axis.drives
        return frozenset(drive.at.name for drive in drives if isinstance(drive.at, Body))

    @property
    def n_drives(self) -> int:
        """Number of drives: the first outputs are their forces, the first signals their driven positions."""
        return len(self.forces)

    @property
    def driven(self) -> tuple[str, ...]:
        """Signals of the driven positions."""
        return self.signals[: self.n_drives]

    @property
    def readings(self) -> tuple[str, ...]:
        """Signals of the sensors that are predicted."""
        return self.signals[self.n_drives :]

    @cached_property
    def springs_read(self) -> tuple[str, ...]:
        """For each predicted sensor the place of the spring whose force it reads, or ""."""
        sensors = {sensor.signal: sensor for sensor in self.dynamics.axis.sensors}
        springs = (sensors[name].element for name in self.readings)
        return tuple(place_of(spring) if isinstance(spring, Spring) else "" for spring in springs)

    def is_hidden(self, direction: FloatArray) -> bool:
        """Whether motion of two bodies along a direction is hidden: no sensor reads it, the model determines it."""
        read = any(self.dynamics.sensors[name][1] == 0 for name in self.readings)
        return not read and self.is_predicted(direction)

    def is_predicted(self, direction: FloatArray) -> bool:
        """Whether the model determines motion of two bodies along a direction, be it compared with a reading or not."""
        if not len(self.dynamics.bodies) == direction.size == 2:
            return False
        rows = [self.dynamics.sensors[name][0] for name in self.driven]
        return bool(np.linalg.matrix_rank(np.stack([*rows, direction])) > len(rows))

    @cached_property
    def hidden_terms(self) -> tuple[tuple[int, int], ...]:
        """Indices of law and term of declared nonlinear laws in hidden joints whose motion is integrated.

        These are dry friction, because a body that sticks at times has no frequency response, and laws without a jump
        at reversals, such as play in a spring. Other laws of friction are taken from the motion before.
        """
        return tuple(
            (i, k)
            for i, law in enumerate(self.dynamics.laws)
            for k, term in enumerate(law.terms)
            if (dry_level(term.code) or not _JUMPS.search(term.code)) and self.is_hidden(law.direction)
        )

    @cached_property
    def motions(self) -> ComplexArray:
        """Spectra of the driven positions, of shape (n_drives, n_bins)."""
        return np.stack([self._read(name) for name in self.driven])

    @cached_property
    def motion(self) -> ComplexArray:
        """Spectrum of the first driven position, of shape (n_bins,)."""
        return np.asarray(self.motions[0])

    @cached_property
    def driven_courses(self) -> FloatArray:
        """First driven position, its velocity and its acceleration on the fine grid; shape (3, n_fine)."""
        return self.courses(self.motion)

    def courses(self, position: ComplexArray) -> FloatArray:
        """A position of spectrum (n_bins,), its velocity and its acceleration on the fine grid; shape (3, n_fine)."""
        s = 1j * self.omega
        return self.fine(np.stack([position, s * position, s**2 * position]))

    @cached_property
    def measured(self) -> ComplexArray:
        """Spectra of the drive forces and of the other sensors, of shape (n_outputs, n_bins)."""
        forces = map(self.in_time, self.forces, self.whole_forces)
        return np.stack([*forces, *map(self._read, self.readings)])

    def _read(self, name: str) -> ComplexArray:
        """Spectrum of a reading."""
        return self.in_time(name, self.continued(self.log[name], smoothly=True))

    def in_time(self, name: str, values: FloatArray) -> ComplexArray:
        """Spectrum of values at the samples of a signal, at the time at which they act or were read."""
        return np.asarray(self.from_grid(values) * self.clock(name, self.omega))

    def clock(self, name: str, omega: FloatArray) -> ComplexArray:
        """Correction of a spectrum for the time by which a signal was recorded late, and for a hold.

        A force held for T is the mean over T of the force that was recorded: the factor is sin(w T/2)/(w T/2).
        """
        held = np.sinc(omega * self.holds.get(name, 0.0) / (2 * np.pi))
        return np.asarray(held * np.exp(1j * omega * self.time_late(name)), dtype=np.complex128)

    def time_late(self, name: str) -> float:
        """Time by which a signal was recorded late, s; a held force acts half its hold after it is recorded."""
        return self.late.get(name, 0.0) - self.holds.get(name, 0.0) / 2

    @cached_property
    def whole_forces(self) -> FloatArray:
        """Drive forces at all samples of a period, of shape (n_drives, n_extended)."""
        return np.stack([self.continued(self.log[name], smoothly=False) for name in self.forces])

    @cached_property
    def noise(self) -> FloatArray:
        """Standard deviations of the noise of driven positions, forces and other sensors, from above the motion.

        The part of a force that is coherent with the position readings is not noise: a controller turns noise of the
        encoder into forces that act on the axis.
        """
        frequency = self.log.sampling_frequency
        found = [
            max(
                noise_beyond(self.log[name], frequency, 1.2 * self.motion_hz),
                _FINEST_READING * float(np.ptp(self.log[name])),
            )
            for name in self.signals
        ]
        positions = np.stack([self.log[name] for name in self.driven])
        of_forces = []
        for name in self.forces:
            level = force_noise(self.log[name], positions, frequency, self.band_hz)
            largest = float(np.ptp(self.log[name])) / 2  # the weight that a drive holds makes no noise
            of_forces.append(level if level > _FINEST_FORCE * largest else _COMMANDED * largest)
        return np.array([*found[: self.n_drives], *of_forces, *found[self.n_drives :]])

    @cached_property
    def noise_spread(self) -> FloatArray:
        """Densities of the noises over frequency, relative to white ones, of shape (n_noises, n_bins)."""
        spread = np.ones((self.noise.size, self.n_bins))
        rate, frequency = self.log.sampling_frequency, self.omega / (2 * np.pi)
        for i, name in enumerate((*self.driven, *self.outputs)):
            if name not in self.forces and (step := step_of(self.log[name])) > 0.0:
                motion = self.grid([*self.motions, *self.measured][i] * self.taper, self.n_extended)
                noise = float(self.noise[i])
                spread[i] = quantisation_lines(step, motion[: self.log.n_samples], rate, noise, frequency)
        return spread

    @property
    def noise_of_motions(self) -> FloatArray:
        """Noise of the driven positions, of shape (n_drives,)."""
        return self.noise[: self.n_drives]

    @cached_property
    def velocity_noise(self) -> float:
        """Standard deviation of the velocity in the band from the noise of the driven positions."""
        share = np.sqrt(2 * self.n_bins / self.n_extended)
        return float(self.noise_of_motions.max() * self.omega[-1] * share / np.sqrt(3))

    @cached_property
    def speeds(self) -> FloatArray:
        """Speeds of the driven positions on the fine grid, of shape (n_drives, n_fine); 0 outside the log."""
        return np.abs(self.fine(1j * self.omega * self.motions)) * self.in_log

    def moves(self, speed: FloatArray) -> BoolArray:
        """Points of the fine grid at which a joint moves by more than noise, from its speed there."""
        least = max(SLOW_SHARE * float(speed[self.in_log].max()), NOISE_MARGIN * self.velocity_noise)
        return np.asarray(speed > least)

    @property
    def moving(self) -> BoolArray:
        """Points of the fine grid at which a driven position moves by more than noise."""
        return np.asarray(np.any([self.moves(speed) for speed in self.speeds], axis=0))

    @property
    def is_drowned(self) -> bool:
        """Whether noise in the band hides all but the fastest motion of the driven positions."""
        fast = np.quantile(self.speeds[:, self.in_log], 0.95, axis=1).max()
        return bool(NOISE_MARGIN * self.velocity_noise > _FASTEST * fast)

    @property
    def noise_of_outputs(self) -> FloatArray:
        """Noise of the forces and of the other sensors, of shape (n_outputs,)."""
        return self.noise[self.n_drives :]


def record_of(
    dynamics: ForwardDynamics,
    log: Log,
    motion_hz: float | None = None,
    late: Mapping[str, float] | None = None,
    holds: Mapping[str, float] | None = None,
) -> Record:
    """A log in the frequency domain.

    `motion_hz` is the highest frequency of its motion; by default the frequency at which the spectrum of the position
    falls to its noise, or less if that noise would hide the velocity. `late` are the times by which signals were
    recorded late, s, apart from `holds`, the times for which forces are held.
    """
    signals = signals_of(dynamics, log)
    if log.n_samples < LEAST_SAMPLES:
        raise LogError(
            f"log {log.source!r} has {log.n_samples} samples: a diagnosis needs at least {LEAST_SAMPLES}"
        )
    driven = signals[: len(dynamics.axis.drives)]
    band = motion_hz or max(motion_band(log[name], log.sampling_frequency) for name in driven)
    record = Record(
        dynamics=dynamics,
        log=log,
        signals=signals,
        motion_hz=band,
        late=dict(late or {}),
        holds=dict(holds or {}),
    )
    while motion_hz is None and record.is_drowned and record.n_bins > FEWEST_BINS:
        record = replace(record, motion_hz=record.motion_hz * _SLOWER)
    return record
