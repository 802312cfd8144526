"""Start parameters of an iterative estimation without good nominal ones."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.output_error.run import read_orders
from symid.signal_processing import LowPass, derivatives
from symid.simulation import ForwardDynamics, Plant

_MODES = (0.01, 0.03, 0.07, 0.13, 0.22, 0.33, 0.43)
"""Start values of the frequency of the highest mode, as shares of the sampling frequency."""
_LOSS = 0.02  # damping of a spring relative to sqrt(mass * stiffness)
_RIGID = 1e-9  # stiffness, relative to the largest, of a motion that no spring resists
_FARTHEST = 300.0  # factor of a mass from its rough value


def spread(
    dynamics: ForwardDynamics, known: Mapping[str, float], sampling_frequency: float
) -> list[dict[str, float]]:
    """Variants of known parameters: unchanged, and with springs scaled to several frequencies of the highest mode."""
    springs = dynamics.parameters_of("stiffness")
    highest = dynamics.at(known).highest_mode
    if not springs or highest == 0.0:
        return [dict(known)]
    scales = [(share * sampling_frequency / highest) ** 2 for share in _MODES]
    return [dict(known), *({**known, **{name: k * known[name] for name in springs}} for k in scales)]


def rigid_start(model: GeneratedModel, dynamics: ForwardDynamics, logs: Sequence[Log]) -> dict[str, float]:
    """Start from the rigid motion in the first log: a mass for each body, and friction."""
    log, axis = logs[0], dynamics.axis
    lowpass = LowPass(0.02 * log.sampling_frequency)
    orders = read_orders(dynamics, log)
    known = [name for name, order in orders.items() if order == min(orders.values())]
    starts = []
    # F = m a + c v + Fc sign(v) + F0 by least squares, with a and v from the signal of the lowest derivative
    for drive, controlled in zip(axis.drives, axis.controlled_signals, strict=True):
        signal = controlled if controlled in known else known[0]
        read = lowpass.apply(log[signal], log.sampling_frequency)
        if orders[signal] == 2:
            read = np.cumsum(read - read.mean()) * log.sampling_period
        rates = derivatives(read, log.sampling_period, 2)
        v, a = rates if orders[signal] == 0 else (read, rates[0])
        motion = np.stack([a, v, np.sign(v), np.ones_like(v)], axis=1)
        force = lowpass.apply(log[drive.signal], log.sampling_frequency)
        starts.append(np.linalg.lstsq(motion, force, rcond=None)[0])
    mass, viscous, coulomb, _ = np.mean(np.abs(starts), axis=0)
    mass = max(float(mass), 1e-12)
    values = dict.fromkeys(model.physical_units, 0.0)
    gains = {sensor.named("gain") for sensor in axis.sensors} | {drive.constant for drive in axis.drives}
    values |= {name: 1.0 for name in values if name in gains}
    masses, springs = dynamics.parameters_of("mass"), dynamics.parameters_of("stiffness")
    # springs begin with a mode at a tenth of the sampling frequency
    stiffness = mass * (2 * np.pi * 0.1 * log.sampling_frequency) ** 2
    for name in values:
        if name in masses:
            values[name] = mass
        elif name in springs:
            values[name] = stiffness
        elif name in dynamics.parameters_of("damping"):
            values[name] = _LOSS * float(np.sqrt(mass * stiffness)) if springs else abs(float(viscous))
    for _, terms in dynamics.laws:
        for term in terms:
            for name in dynamics.names(term.parameter):
                values[name] = abs(float(coulomb))
    return _behind_gears(dynamics, values)


def _behind_gears(dynamics: ForwardDynamics, values: Mapping[str, float]) -> dict[str, float]:
    """Values as their gears make them: each mass as heavy for the drive, each spring as stiff for the masses at it."""
    apart, plant = dict(values), dynamics.with_nodes(values)
    moved, springs = _without_deflection(plant), dynamics.parameters_of("stiffness")
    for name in dynamics.parameters_of("mass"):
        share = float(moved @ dynamics.derivative(values, name).mass @ moved)
        apart[name] = values[name] / share if share > 0.0 else values[name]
    lighter = np.linalg.pinv(dynamics.with_nodes(apart).mass)  # a node without mass moves with its neighbours
    for name in springs | dynamics.parameters_of("damping") if springs else ():
        slope = dynamics.derivative(values, name)
        part = slope.stiffness if name in springs else slope.damping
        mobility = float(
            np.abs(np.linalg.eigvals(lighter @ part)).max()
        )  # of both ends, per unit force in the joint
        mass = float(np.mean([values[one] for one in dynamics.parameters_of("mass")]))
        apart[name] = values[name] / (mobility * mass) if mobility > 0.0 else values[name]
    return apart


def _without_deflection(plant: Plant) -> FloatArray:
    """Motion of the bodies for unit motion of the first drive, without deflection of springs; 0 if they hold it."""
    size = np.sqrt(np.diag(plant.stiffness))
    size[size == 0.0] = 1.0
    _, sizes, directions = np.linalg.svd(plant.stiffness / np.outer(size, size))
    free = directions[sizes <= _RIGID * max(sizes[0], 1.0)] / size
    along = free @ plant.drives[:, 0]
    return np.asarray(along @ free / (along @ along)) if along.any() else np.zeros(len(size))


def with_heavy_bodies(dynamics: ForwardDynamics, known: Mapping[str, float]) -> dict[str, float]:
    """Parameters with all bodies ten times as heavy, except those that move rigidly with the drive."""
    driven = {
        name
        for forces, row in zip(dynamics.drives, dynamics.motion[2], strict=True)
        if any(coefficient > 0 for force in forces for coefficient, _ in force.terms)
        for entry in row
        for name in dynamics.names(entry)
    }
    heavy = dynamics.parameters_of("mass") - driven
    return {name: 10.0 * value if name in heavy else value for name, value in known.items()}


def plausible(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    physical: Mapping[str, float],
    rough: Mapping[str, float],
) -> dict[str, float]:
    """Estimated parameters where they are physically possible; rough ones where they are not, nan or missing.

    Masses and stiffnesses are taken together or not at all; no parameter may be negative that must not be, and no mass
    further from the rough ones than a factor of 300.

    >>> from symid.axis import load_axis
    >>> from symid.codegen import load_generated
    >>> from symid.simulation import forward_dynamics
    >>> rough = {"M": 1.0, "Fv": 0.0, "Fs": 2.0}
    >>> model, dynamics = load_generated("rigid_1m"), forward_dynamics(load_axis("rigid_1m"))
    >>> plausible(model, dynamics, {"M": 5.0, "Fv": 3.0, "Fs": -4.0}, rough)
    {'M': 5.0, 'Fv': 3.0, 'Fs': 2.0}
    """
    values = dict(rough)
    masses, springs = dynamics.parameters_of("mass"), dynamics.parameters_of("stiffness")
    together = masses | springs
    if all(physical.get(name, -1.0) > 0 for name in together) and all(
        rough[name] / _FARTHEST < physical[name] < rough[name] * _FARTHEST for name in masses
    ):
        values.update({name: physical[name] for name in together})
    for name in values:
        value = physical.get(name, math.nan)
        if name not in together and math.isfinite(value) and (value >= 0 or name in model.signed):
            values[name] = value
    return values
