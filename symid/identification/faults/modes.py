"""Natural frequencies of an identified axis, from the coefficients of its equations; motion beyond the band of a log.

Without laws the equations are A(s) q = B(s) F, with polynomials in s whose coefficients are those of W X - y. The
natural frequencies are the zeros of det A. The determinant is sampled on a circle around the band of the estimate, and
its polynomial follows by a Fourier transform.
"""

from collections.abc import Sequence

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.codegen import GeneratedModel
from symid.identification.rows.excerpts import Excerpt
from symid.identification.rows.noise import coefficients
from symid.signal_names import split_derivative
from symid.signal_processing import NOISE_FROM, explained_power, mean_power, segment_spectra

_POINTS = 32
"""Points on the circle: more than the degree of any determinant."""
_LEAST = 1e-9
"""Coefficient, over the largest, that is rounding."""
_DAMPED = 0.5
"""Damping ratio above which a root does not count as a mode: structures have 0.002 to 0.1."""
_RIGID = 2
"""Highest derivatives of a rigid axis."""
_STIFFNESSES = ("N/m", "N*m/rad")


def lost_mode(model: GeneratedModel, X: FloatArray, around_hz: float) -> str:
    """Statement on a flexible axis that came out without a mode; empty for others.

    A lag or a smoothed force looks like a spring and a damper that hardly oscillate: they then describe this filter.
    """
    has_spring = any(unit in _STIFFNESSES for unit in model.physical_units.values())
    if not has_spring or max(model.highest_derivatives.values()) <= _RIGID or not is_square(model):
        return ""
    if natural_frequencies(model, X, around_hz).size:
        return ""
    return (
        "the flexible axis is estimated without a mode, its springs are overdamped: a signal was filtered before it "
        "was recorded, or the mode lies far above what the log shows; record raw signals, and faster motion"
    )


def mode_above(model: GeneratedModel, X: FloatArray, cutoff_hz: float) -> str:
    """Statement on a mode above the cutoff, which rows below it show only by its stiffness; empty without one.

    Anything that the model does not describe there changes this stiffness, and the masses that follow from it.
    """
    if max(model.highest_derivatives.values()) <= _RIGID:
        return ""
    frequencies = natural_frequencies(model, X, cutoff_hz)
    if not frequencies.size or frequencies[-1] <= cutoff_hz:
        return ""
    return (
        f"the mode of {frequencies[-1]:.3g} Hz lies above the cutoff of {cutoff_hz:.3g} Hz, and the model does not "
        "describe what lies below: a signal was filtered before it was recorded, or the model lacks an effect; record "
        "raw signals, and faster motion"
    )


def is_square(model: GeneratedModel) -> bool:
    """Whether there are as many equations as sensors that do not repeat each other."""
    return len(model.output_names) == len(_independent_sensors(model))


def _independent_sensors(model: GeneratedModel) -> list[str]:
    repeated = [name for name, terms in model.redundant if len(terms) == 1]
    return [name for name in model.measured if name not in repeated]


def natural_frequencies(model: GeneratedModel, X: FloatArray, around_hz: float) -> FloatArray:
    """Natural frequencies of weakly damped modes, Hz; empty where equations and independent sensors differ in number.

    >>> from symid.codegen import load_generated
    >>> model = load_generated("direct_2m1s", ("q2",))
    >>> X = np.asarray(model.minimal_parameters(30.0, 20.0, 4e5, 10.0, 5.0, 1.0))  # Ms, Fvs, Ks, Mm, Fvm, Fsm
    >>> natural_frequencies(model, X, 20.0).round(2)
    array([18.38])
    """
    repeated = {name: terms[0] for name, terms in model.redundant if len(terms) == 1}
    sensors = _independent_sensors(model)
    rows = np.einsum("jas,a->js", coefficients(model), np.append(X, -1.0))  # of each signal in each equation
    if not is_square(model):
        return np.zeros(0)
    circle = np.exp(2j * np.pi * np.arange(_POINTS) / _POINTS)
    s = 2 * np.pi * around_hz * circle
    # Each signal adds its coefficient times s to the order of its derivative, at the column of its sensor.
    A: ComplexArray = np.zeros((_POINTS, len(rows), len(sensors)), dtype=complex)
    for flat, column in zip(model.signals, rows.T, strict=True):
        name, order = split_derivative(flat)
        power, factor = order, 1.0
        if name in repeated:
            name, more, factor = repeated[name]
            power += more
        if name in sensors:
            A[:, :, sensors.index(name)] += factor * column * s[:, None] ** power
    polynomial = np.fft.fft(np.linalg.det(A)).real / _POINTS  # coefficient of circle**k at place k
    size = np.max(np.abs(polynomial))
    kept = np.flatnonzero(np.abs(polynomial) > _LEAST * size)
    roots = np.roots(polynomial[: kept[-1] + 1][::-1]) if size > 0.0 else np.zeros(0)
    weakly = (roots.imag > 0.0) & (-roots.real < _DAMPED * np.abs(roots))
    return np.sort(around_hz * np.abs(roots[weakly]))


_LEAST_SHARE_ABOVE = 0.1
"""Share of a sensor's power above `NOISE_FROM`; an accelerometer's noise of 2 % of the rms signal is 1e-4 of it."""
_COHERENT = 0.8
"""Share of a force's power there that is linear in the sensors, in the median: noise is not."""
_SEGMENTS, _LONGEST = 16, 1024  # segments at least, and samples of one at most


def aliasing_of(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a sensor with motion up to half the sampling frequency; empty without one.

    A controller turns the noise of an encoder into force, so that both are coherent up to there in a sound log too: the
    share of the power decides. Mostly accelerometers show it.
    """
    for part in parts:
        length = max(16, min(_LONGEST, part.log.n_samples // _SEGMENTS))
        motion = [name for name in model.highest_derivatives if name not in model.forces]
        sensors = {name: segment_spectra(part.log[name][None], length) for name in motion}
        upper = np.arange(length // 2 + 1) > NOISE_FROM * length
        power = {name: mean_power(x) for name, x in sensors.items()}
        shares = {name: float(p[upper].sum()) / max(float(p.sum()), 1e-300) for name, p in power.items()}
        name = max(shares, key=shares.__getitem__)
        if shares[name] < _LEAST_SHARE_ABOVE:
            continue
        for force in model.forces:
            spectra = segment_spectra(part.log[force][None], length)
            seen = explained_power(spectra, np.stack(list(sensors.values())))
            if np.median((seen / np.maximum(mean_power(spectra), 1e-300))[upper]) > _COHERENT:
                return (
                    f"{name} has {100 * shares[name]:.2g} % of its power above 0.7 of half the sampling frequency, and "
                    f"{force} is coherent with it: faster motion is aliased; record faster, or filter all signals "
                    "alike before sampling"
                )
    return ""
