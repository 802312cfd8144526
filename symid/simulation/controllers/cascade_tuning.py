"""Cascades tuned to the mass that each drive moves."""

import math
from collections.abc import Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.controllers.controller import Cascade
from symid.simulation.plants.plant import Plant

_SLOWEST, _FASTEST = 1e-6, 1e6
"""Range of bandwidths, Hz: beyond it powers of them overflow."""
_HEAVIEST = 1e100
"""Mass from which on powers of gains overflow, SI."""
_SHARED = 1e-9
"""Singular value, relative to the largest, below which drives count as moving the same mass."""
_RESOLVED = 1e-6
"""Rate at which the mass is resolved, relative to the fastest mode."""
_ALIKE = 3.0
"""Factor by which friction and springs to the ground may change the mass that a loop is tuned to, at most."""


def tuned_cascade(
    plant: Plant, signal: str, bandwidth_hz: float = 20.0, force_limit: float = math.inf
) -> Cascade:
    """Cascade tuned to the mass that the drive moves at low frequency, without friction and springs to the ground.

    The velocity loop crosses over at `bandwidth_hz`; the position loop and the integral at a fifth of it. A velocity
    sensor has no position loop.

    Parameters
    ----------
    plant : Plant
        The axis.
    signal : str
        A position or velocity sensor.
    bandwidth_hz : float
        Bandwidth of the velocity loop.
    force_limit : float
        Largest force, N.

    Raises
    ------
    SettingError
        If the signal does not belong to a position or velocity sensor.

    Examples
    --------
    The gain of the velocity loop is 2 pi 20 Hz times the mass of 100 kg:

    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 100.0, "Fv": 0.0, "Fs": 0.0})
    >>> round(tuned_cascade(plant, "q").velocity_gain)
    12566
    """
    return tuned_cascades(plant, (signal,), bandwidth_hz, force_limit)[0]


def tuned_cascades(
    plant: Plant, signals: Sequence[str], bandwidth_hz: float = 20.0, force_limit: float = math.inf
) -> tuple[Cascade, ...]:
    """Cascades of all drives, each tuned to its share of the mass if all controlled positions move together.

    Parameters
    ----------
    plant : Plant
        The axis.
    signals : sequence of str
        The sensor that each drive controls; drives of one body may share a sensor, and then share the mass.
    bandwidth_hz, force_limit : float
        As in `tuned_cascade`.

    Raises
    ------
    SettingError
        If a signal does not belong to a position or velocity sensor, there is not one for each drive, or the bandwidth
        is that of no controller.
    """
    if not _SLOWEST <= bandwidth_hz <= _FASTEST:
        raise SettingError(
            f"a bandwidth of {bandwidth_hz:g} Hz is not possible for a controller: "
            f"give one from {_SLOWEST:g} to {_FASTEST:g} Hz"
        )
    if len(signals) != plant.drives.shape[1]:
        raise SettingError(
            f"there are {plant.drives.shape[1]} drives and {len(signals)} signals: give one sensor for each drive"
        )
    for signal in signals:
        if signal not in plant.sensors or plant.sensors[signal].order not in (0, 1):
            raise SettingError(
                f"{signal!r} is not a position or velocity sensor of this axis: a cascade controls one, so declare "
                "it; an identification need not use it"
            )
    angular = 2 * math.pi * bandwidth_hz
    with np.errstate(over="ignore", invalid="ignore"):
        masses = _moved_masses(
            plant, np.array([plant.sensors[signal].row for signal in signals]), angular / 100
        )
    if not (np.abs(masses) < _HEAVIEST).all():
        raise SettingError(
            f"a drive of this axis moves {np.abs(masses).max():.3g} kg or kg*m^2: give masses below {_HEAVIEST:g}"
        )
    reads = [plant.sensors[signal].order == 1 for signal in signals]
    return tuple(
        Cascade(
            signal,
            0.0 if of_velocity else angular / 5,
            mass * angular,
            angular / 5,
            force_limit=force_limit,
            reads_velocity=of_velocity,
        )
        for signal, mass, of_velocity in zip(signals, masses.tolist(), reads, strict=True)
    )


def _moved_masses(plant: Plant, rows: FloatArray, rate: float) -> FloatArray:
    """Mass that each drive moves if all rows move together slowly; negative where it drives its row backwards.

    The force at this rate shows it, unless friction or springs to the ground make most of that force: the loop would
    then cross over far from its bandwidth.
    """
    # Slower, rounding would hide the mass beside the stiffest spring.
    rate = max(rate, _RESOLVED * math.sqrt(max(np.linalg.solve(plant.mass, plant.stiffness).trace(), 0.0)))
    # Force per acceleration. It is singular if drives move one mass: the pseudoinverse then shares the mass among them.
    s = 1j * rate
    dynamic = plant.mass * s**2 + plant.damping * s + plant.stiffness
    response = rows @ np.linalg.solve(dynamic, plant.drives)
    felt = np.abs(np.linalg.pinv(response * s**2, rcond=_SHARED).sum(axis=1))
    # Without friction, and at a real rate, the force per displacement is k + m s^2; m is its derivative by s^2.
    static = plant.mass * rate**2 + plant.stiffness
    moved, weights = np.linalg.solve(static, plant.drives), np.linalg.solve(static.T, rows.T)
    forces = np.linalg.pinv(rows @ moved, rcond=_SHARED)
    slopes = weights.T @ plant.mass @ moved
    masses = np.abs((forces @ slopes @ forces).sum(axis=1))
    alike = (felt < _ALIKE * masses) & (masses < _ALIKE * felt)
    return np.asarray(np.where(alike, felt, masses) * np.sign(np.diag(slopes)))
