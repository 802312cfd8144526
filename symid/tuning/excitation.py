"""What moves an axis while it is tuned, unless a trajectory is given."""

from __future__ import annotations

import math

import scipy

from symid.simulation import Plant, Trajectory, chirp

LOWEST_HZ = 0.1
"""Where the chirp of the paper begins."""
_RIGID_HZ = 20.0
"""Where it ends for an axis without a flexible mode."""
_BEYOND_MODES = 1.25
"""The paper's chirp ends at 100 Hz, the mode of its axis lies at about 80 Hz."""
_UNIT = 1e-3


def modes_hz(plant: Plant) -> tuple[float, ...]:
    """Natural frequencies of the flexible modes without damping, rising, Hz.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of
    >>> values = {"Ms": 3899, "Fvs": 3949, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146}
    >>> [round(f, 1) for f in modes_hz(plant_of(load_axis("direct_2m1s"), values))]
    [80.6]
    """
    squares = scipy.linalg.eigh(plant.stiffness, plant.mass, eigvals_only=True)
    flexible = squares[squares > 1e-9 * max(squares[-1], 0.0)]
    return tuple(float(math.sqrt(w) / (2 * math.pi)) for w in flexible)


def excited_band(plant: Plant) -> tuple[float, float]:
    """Band of a chirp that excites every mode, Hz: 0.1 Hz to 1.25 times the highest mode; to 20 Hz if there is none."""
    modes = modes_hz(plant)
    return LOWEST_HZ, _BEYOND_MODES * modes[-1] if modes else _RIGID_HZ


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
