"""The axis with the effects found as elements, which can be derived, generated and identified like any other."""

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from symid.arrays import ComplexArray
from symid.axis import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    EncoderRipple,
    PreslidingFriction,
    Sensor,
    Spring,
    Weight,
)
from symid.diagnosis.effects import LawEffect, Placed, force_at, imperfection_of, with_presliding_parts
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.fitting.fit import masses_and_stiffnesses
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.places import place_named
from symid.diagnosis.prediction.prediction import Prediction
from symid.errors import SettingError
from symid.simulation.plants import FrequencyResponse, has_response, identified_response

ParameterValues: TypeAlias = dict[str, float]
"""Value of each new parameter, SI."""


@dataclass(frozen=True)
class ExplainedAxis:
    """An axis with the effects that a diagnosis found."""

    axis: Axis
    """The axis diagnosed with the elements of the effects added."""
    values: ParameterValues
    """Values of its physical parameters, SI."""
    left_out: tuple[str, ...]
    """A sentence for each effect that cannot be an element of an axis, such as a force or a reading that is early, and,
    from `explained_axis`, for each value that is impossible for a real axis."""


def explained_axis(found: Diagnosis) -> ExplainedAxis:
    """The axis with the effects of a diagnosis added, and the values of its parameters.

    Values that belong to a log, such as the moment of a change, are those of the validation log, as in `Gap.motion`.

    Parameters
    ----------
    found : Diagnosis
        Result of a diagnosis. Without effects the axis is the declared one with re-identified values.

    Raises
    ------
    SettingError
        If nothing was fitted, or none of the effects is an element of an axis.
    """
    if found.model is None:
        raise SettingError("nothing was fitted: the axis stays as it is declared")
    explained = _as_sensed(axis_with_effects(found.model), found.axis)
    if not found.effects:
        return explained
    if explained.axis == found.axis.without(*found.axis.imperfections):
        raise SettingError("; ".join(explained.left_out))
    impossible = impossible_values(explained.axis, explained.values)
    return replace(explained, left_out=(*explained.left_out, *impossible))


def explained_response(found: Diagnosis, of: FrequencyResponse) -> ComplexArray | None:
    """Response with the linear effects among those found; None if it cannot be computed."""
    try:
        with_effects = explained_axis(found)
        axis, values = with_effects.axis, with_effects.values
    except SettingError:  # no effect is an element of the axis
        axis, values = found.axis, {change.name: change.explained for change in found.parameters}
    if not has_response(axis, values):
        return None
    drive = np.ones(of.frequency.size, dtype=complex)
    for effect in found.effects:
        if effect.effect in ("delay", "actuator_lag"):
            turned = 2j * np.pi * of.frequency * effect.parameters["T"].value
            if effect.effect == "delay":
                drive *= np.exp(-turned)
            else:  # a negative time means that the record lags, not the force
                drive *= 1 / (1 + turned) if effect.parameters["T"].value > 0 else 1 - turned
    return np.asarray(drive * identified_response(axis, values, of.signal, of.frequency, of.order))


def _as_sensed(explained: ExplainedAxis, declared: Axis) -> ExplainedAxis:
    """The axis with its declared sensors in place of integrated speeds and scaled sensors.

    A sensor with ripple stays a position.
    """
    found = {sensor.signal: sensor for sensor in explained.axis.sensors}
    rippled = {item.signal for item in explained.axis.imperfections if isinstance(item, EncoderRipple)}

    def is_read_alike(declared: Sensor) -> bool:
        return (
            not declared.is_scaled
            and declared.signal in found
            and found[declared.signal].quantity == declared.quantity
        )

    sensors = tuple(
        found[sensor.signal]
        if sensor.signal in rippled or is_read_alike(sensor)
        else replace(sensor, delay=found.get(sensor.signal, sensor).delay)
        for sensor in declared.sensors
    )
    known = {**explained.axis.known, **declared.known}
    return replace(explained, axis=replace(explained.axis, sensors=sensors, known=known))


def impossible_values(axis: Axis, values: ParameterValues) -> tuple[str, ...]:
    """A sentence for each negative inertia and stiffness, which a log that does not determine them may give.

    >>> from symid.axis import load_axis
    >>> impossible_values(load_axis("rigid_1m"), {"M": -2.0, "Fv": 1.0, "Fs": 1.0})
    ('M = -2 is impossible for a real axis: these logs do not fix it, and the axis may run away in simulation',)
    """
    return tuple(
        f"{name} = {values[name]:.4g} is impossible for a real axis: these logs do not fix it, "
        "and the axis may run away in simulation"
        for name in masses_and_stiffnesses(axis)
        if values.get(name, 0.0) < 0
    )


def axis_with_effects(state: State) -> ExplainedAxis:
    """The axis of a model with its effects as elements, and the values of its parameters.

    The effects include declared imperfections, with identified values.
    """
    declared, values = state.prediction.axis, dict(state.prediction.parameters)
    axis = declared.without(*declared.imperfections)
    left_out = []
    for item in with_presliding_parts(state.placed):
        added = _added(axis, item, values)
        if added is None:
            left_out.append(_left_out(state.prediction, item))
        else:
            axis = added
    return ExplainedAxis(axis, {name: values[name] for name in axis.physical_parameters}, tuple(left_out))


def _added(axis: Axis, item: Placed, values: ParameterValues) -> Axis | None:
    """The axis with an effect; its new parameters are added to `values`. None if it cannot be an element."""
    if item.effect.name == "flexible_mode":
        return _with_mode(axis, item, values)
    if isinstance(item.effect, LawEffect):
        place, effect = place_named(axis, item.at), item.effect
        laws, added = effect.elements(place, item.at, item.shape, item.amplitudes)
        if added.keys() & values.keys():  # amplitudes of two effects in one joint may have the same name
            prefix = f"{item.at}_{effect.name}"
            laws, added = effect.elements(place, prefix, item.shape, item.amplitudes)
        values |= added
        return axis.with_effect(*laws)
    if item.effect.name == "sensor_delay":
        (sensor,) = axis.measured((item.at,))
        delay = sensor.delay + item.shape[0]
        return axis.with_signal(item.at, sensor.noise, sensor.resolution, delay) if delay > 0 else None
    if item.effect.name == "presliding_friction":
        return _with_presliding(axis, item, values)
    found = imperfection_of(axis, item)
    return None if found is None else axis.with_effect(found)


def _with_presliding(axis: Axis, item: Placed, values: ParameterValues) -> Axis:
    """The axis with Coulomb friction that builds up over a displacement; the friction is added if there is none."""
    (level,), (reach,) = item.amplitudes, item.shape
    place = place_named(axis, item.at)
    declared = any(isinstance(law, CoulombFriction) and law.at == place for law in axis.laws)
    if item.integrated or not declared:  # in addition to existing friction, not a part of it
        name = f"{item.at}_Fs"
        if name not in values:
            axis = axis.with_effect(CoulombFriction(place, name))
        values[name] = values.get(name, 0.0) + level
    return axis.with_effect(PreslidingFriction(place, level, reach=reach))


def _left_out(prediction: Prediction, item: Placed) -> str:
    """Sentence on an effect that cannot be an element; one before its cause belongs to the recording."""
    found = {name: (value, unit) for name, value, unit in item.values(prediction)}
    numbers = ", ".join(f"{name} = {value:.4g} {unit}" for name, (value, unit) in found.items())
    if item.effect.name == "delay":
        late = f"{force_at(prediction.record.forces, item.at)}={-1e6 * found['T'][0]:.4g}us"
        return f"delay ({numbers}) cannot be an element of an axis, as the force was recorded late: give `late` {late}"
    if item.effect.name == "sensor_delay":
        late = f"{item.at}={1e6 * found['T'][0]:.4g}us"
        return f"sensor_delay ({numbers}) cannot be an element of an axis, as it is early: give `late` {late}"
    if item.effect.name == "actuator_lag":
        signal = force_at(prediction.record.forces, item.at)
        return (
            f"actuator_lag ({numbers}) cannot be an element of an axis, as it filters the record of {signal} and not "
            "its force: record it unfiltered, or filter the position alike"
        )
    return f"{item.effect.name} at {item.at} ({numbers}) cannot be an element of an axis"


def _with_mode(axis: Axis, item: Placed, values: ParameterValues) -> Axis:
    """The axis with a part of a body's mass, and of its weight, on a spring."""
    (mass,), (frequency, ratio) = item.amplitudes, item.shape
    body = next(b for b in axis.free_bodies if b.name == item.at)
    own = 2 * math.pi * frequency
    names = [f"{item.at}_mode_{letter}" for letter in ("m", "k", "c")]
    slides = body.mass is not None
    added = Body(f"{item.at}_mode", mass=names[0] if slides else None, inertia=None if slides else names[0])
    spring = Spring(
        f"{added.name}_spring", Between(first=body, second=added), stiffness=names[1], damping=names[2]
    )
    values |= dict(zip(names, (mass, mass * own**2, 2 * ratio * own * mass), strict=True))
    known = axis.known_parameters
    if body.inertial in known:
        axis = axis.with_known({body.inertial: known[body.inertial] - mass})
    else:
        values[body.inertial] -= mass
    weights = (own for own in axis.elements if isinstance(own, Weight) and own.body == body)
    return axis.with_effect(added, spring, *(replace(own, body=added) for own in weights))
