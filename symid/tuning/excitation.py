"""Default trajectory of the tuning."""

from __future__ import annotations

from symid.simulation import Plant, Trajectory, chirp

LOWEST_HZ = 0.1
"""Where the chirp of the paper begins."""
_RIGID_HZ = 20.0
"""Where it ends for an axis without a flexible mode."""
_BEYOND_MODES = 1.25
"""The paper's chirp ends at 100 Hz, the mode of its axis lies at about 80 Hz."""
_UNIT = 1e-3


def excited_band(plant: Plant) -> tuple[float, float]:
    """Band of a chirp that excites every mode, Hz: 0.1 Hz to 1.25 times the highest mode; to 20 Hz if there is none."""
    return LOWEST_HZ, _BEYOND_MODES * plant.highest_mode or _RIGID_HZ


def tuning_chirp(
    plant: Plant,
    rate: float,
    seconds: float = 10.0,
    band: tuple[float, float] | None = None,
    *,
    travel: float = 0.2,
    speed: float = 0.5,
    acceleration: float = 5.0,
) -> Trajectory:
    """Chirp of constant velocity, its frequency rising exponentially, through every mode of the axis.

    Parameters
    ----------
    plant : Plant
        The axis.
    rate : float
        Samples per second, Hz.
    seconds : float
        Duration.
    band : tuple of two float, optional
        Frequencies at the beginning and the end, Hz; `excited_band` by default.
    travel, speed, acceleration : float
        Limits from zero, m or rad and s; the chirp is as large as nine tenths of the tightest one allow.
    """
    low, high = band or excited_band(plant)

    def of_size(size: float) -> Trajectory:
        return chirp(
            low,
            high,
            seconds,
            size,
            sampling_period=1 / rate,
            quantity="velocity",
            sweep="logarithmic",
        )

    trial = of_size(_UNIT).extremes
    shares = (
        travel / max(abs(trial.lowest), abs(trial.highest)),
        speed / trial.speed,
        acceleration / trial.acceleration,
    )
    return of_size(0.9 * _UNIT * min(shares))
