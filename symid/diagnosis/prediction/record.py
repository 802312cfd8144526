"""A log in the frequency domain: what the sensors and the drives say, up to the frequency at which motion ends.

Each drive has a position next to it, its *driven position*: from these motions all else is predicted. The outputs are
what is predicted: the force of each drive, which its balance gives, and the readings of all further sensors.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.axis import Body, Spring
from symid.data import Log
from symid.data.lost_samples import step_of
from symid.diagnosis.prediction.driven_positions import signals_of
from symid.diagnosis.prediction.last_values import LastValues
from symid.diagnosis.prediction.motion_band import force_noise, motion_band, noise_beyond
from symid.diagnosis.prediction.periodic_log import FEWEST_BINS, PeriodicLog
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.quantisation import quantisation_lines
from symid.errors import LogError
from symid.simulation import ForwardDynamics

_LEAST_SAMPLES = 100
"""Fewer have no spectrum in which motion and noise part; whether they move enough is counted in rows."""
NOISE_MARGIN, SLOW_SHARE = 6.0, 0.004
"""Times the noise of a velocity, and share of the highest speed, above which an axis moves."""
_FASTEST, _SLOWER = 0.25, 2**-0.25
"""Of the top speed, which that must not exceed; and the ratio of the bands that are tried in turn."""
_FINEST_FORCE = 1e-4
"""Noise of a record of a force, relative to the largest: one of 12 bits has more, and what has less is a command."""
_COMMANDED = 1e-3
"""Error with which a drive follows its command, relative to the largest force: the record of a command shows none."""
_FINEST_READING = 1e-8
"""Noise of the finest reading, relative to its range: an encoder of 24 bits has more."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Record(PeriodicLog):
    """A log of an axis, continued periodically, in the frequency domain."""

    dynamics: ForwardDynamics  # the axis
    # position sensors from whose motion everything is predicted, one for each drive, then the other sensors
    signals: tuple[str, ...]
    # time by which signals were recorded late, s; negative for a force that acts later than recorded
    late: Mapping[str, float] = field(default_factory=dict)
    # joints whose motion is measured, which no model changes
    driven_joints: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)
    # what follows from the log alone
    memory: LastValues = field(default_factory=LastValues, init=False, repr=False)

    @cached_property
    def forces(self) -> tuple[str, ...]:
        """Signals of the drives."""
        return tuple(drive.signal for drive in self.dynamics.axis.drives)

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Signals that are predicted: forces, and readings of further sensors."""
        return (*self.forces, *self.readings)

    @cached_property
    def driven_bodies(self) -> frozenset[str]:
        """Bodies in whose joint a drive acts."""
        drives = self.dynamics.axis.drives
        return frozenset(drive.at.name for drive in drives if isinstance(drive.at, Body))

    @property
    def n_drives(self) -> int:
        """Drives, and balances: as many outputs are forces, and as many signals driven positions."""
        return len(self.forces)

    @property
    def driven(self) -> tuple[str, ...]:
        """Driven positions."""
        return self.signals[: self.n_drives]

    @property
    def readings(self) -> tuple[str, ...]:
        """Sensors that are predicted."""
        return self.signals[self.n_drives :]

    @cached_property
    def springs_read(self) -> tuple[str, ...]:
        """For each of them the place of the spring whose force it reads; "" for any other."""
        sensors = {sensor.signal: sensor for sensor in self.dynamics.axis.sensors}
        springs = (getattr(sensors[name], "of", None) for name in self.readings)
        return tuple(place_of(spring) if isinstance(spring, Spring) else "" for spring in springs)

    def is_hidden(self, direction: FloatArray) -> bool:
        """Whether motion along a direction follows from the model: that of two bodies, which no sensor shows."""
        sensors, n_bodies = self.dynamics.sensors, len(self.dynamics.bodies)
        if not n_bodies == direction.size == 2 or any(sensors[name][1] == 0 for name in self.readings):
            return False
        rows = [sensors[name][0] for name in self.driven]
        return bool(np.linalg.matrix_rank(np.stack([*rows, direction])) > len(rows))

    @cached_property
    def dry_terms(self) -> tuple[tuple[int, int], ...]:
        """Laws, and their terms, of declared Coulomb friction in hidden joints.

        What holds a hidden body at times follows from no frequency response.
        """
        return tuple(
            (i, k)
            for i, law in enumerate(self.dynamics.laws)
            for k, term in enumerate(law.terms)
            if term.code == "np.sign(v)" and self.is_hidden(law.direction)
        )

    @cached_property
    def motions(self) -> ComplexArray:
        """Spectra of the driven positions, of shape (n_drives, n_bins)."""
        return np.stack([self._read(name) for name in self.driven])

    @cached_property
    def motion(self) -> ComplexArray:
        """Spectrum of the first of them, of shape (n_bins,)."""
        return np.asarray(self.motions[0])

    @cached_property
    def driven_courses(self) -> FloatArray:
        """Course of the first driven position, its velocity and its acceleration, of shape (3, n_points)."""
        s = 1j * self.omega
        return self.course(np.stack([self.motion, s * self.motion, s**2 * self.motion]))

    @cached_property
    def measured(self) -> ComplexArray:
        """Spectra of the drive forces and of the other sensors, of shape (n_outputs, n_bins)."""
        forces = map(self._in_time, self.forces, self.whole_forces)
        return np.stack([*forces, *map(self._read, self.readings)])

    def _read(self, name: str) -> ComplexArray:
        """Spectrum of a reading."""
        return self._in_time(name, self.continued(self.log[name], smoothly=True))

    def _in_time(self, name: str, values: FloatArray) -> ComplexArray:
        """Spectrum of a signal as if it had not been recorded late."""
        return np.asarray(self.from_grid(values) * np.exp(1j * self.omega * self.late.get(name, 0.0)))

    @cached_property
    def whole_forces(self) -> FloatArray:
        """Drive forces at all samples of a period, of shape (n_drives, n_extended)."""
        return np.stack([self.continued(self.log[name], smoothly=False) for name in self.forces])

    @cached_property
    def noise(self) -> FloatArray:
        """Standard deviations of the noise of driven positions, forces and other sensors, from above the motion.

        Of a force, what is coherent with the readings of the positions is not noise: a controller makes forces out of
        the noise of the encoder, and these act on the axis.
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
            level, largest = (
                force_noise(self.log[name], positions, frequency, self.band_hz),
                np.abs(self.log[name]).max(),
            )
            of_forces.append(level if level > _FINEST_FORCE * largest else _COMMANDED * float(largest))
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
        """Those of the driven positions, of shape (n_drives,)."""
        return self.noise[: self.n_drives]

    @cached_property
    def velocity_noise(self) -> float:
        """Standard deviation of what the noise of the driven positions makes of a velocity in the band."""
        share = np.sqrt(2 * self.n_bins / self.n_extended)
        return float(self.noise_of_motions.max() * self.omega[-1] * share / np.sqrt(3))

    @cached_property
    def speeds(self) -> FloatArray:
        """Those of the driven positions on the fine grid, of shape (n_drives, n_fine); 0 outside the log."""
        return np.abs(self.fine(1j * self.omega * self.motions)) * self.in_log

    def moves(self, speed: FloatArray) -> BoolArray:
        """Points of the fine grid at which a joint moves by more than noise, from its speed there."""
        least = max(SLOW_SHARE * float(speed[self.in_log].max()), NOISE_MARGIN * self.velocity_noise)
        return np.asarray(speed > least)

    @property
    def is_drowned(self) -> bool:
        """Whether noise in the band hides all but the fastest motion of the driven positions."""
        fast = np.quantile(self.speeds[:, self.in_log], 0.95, axis=1).max()
        return bool(NOISE_MARGIN * self.velocity_noise > _FASTEST * fast)

    @property
    def noise_of_outputs(self) -> FloatArray:
        """Those of the forces and of the other sensors, of shape (n_outputs,)."""
        return self.noise[self.n_drives :]


def record_of(
    dynamics: ForwardDynamics,
    log: Log,
    motion_hz: float | None = None,
    late: Mapping[str, float] | None = None,
) -> Record:
    """A log in the frequency domain.

    `motion_hz` is the highest frequency of its motion, by default where the spectrum of the position sinks into its
    noise, or less where that noise would hide the velocity; `late` the time by which signals were recorded late, s.
    """
    signals = signals_of(dynamics, log)
    if log.n_samples < _LEAST_SAMPLES:
        raise LogError(
            f"log {log.source!r} has {log.n_samples} samples: a diagnosis needs at least {_LEAST_SAMPLES}"
        )
    driven = signals[: len(dynamics.axis.drives)]
    band = motion_hz or max(motion_band(log[name], log.sampling_frequency) for name in driven)
    record = Record(dynamics=dynamics, log=log, signals=signals, motion_hz=band, late=dict(late or {}))
    while motion_hz is None and record.is_drowned and record.n_bins > FEWEST_BINS:
        record = replace(record, motion_hz=record.motion_hz * _SLOWER)
    return record
