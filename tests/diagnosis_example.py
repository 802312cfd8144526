"""Diagnoses of the paper's axis as they could be: curves of a made-up machine, and tables that fit them."""

from dataclasses import replace

import numpy as np
from diagnosis_curves import FLOOR, FOUND, curves_of, level_of, maps_of, spectrum_of

from symid import load_axis
from symid.diagnosis import (
    Alternative,
    Diagnosis,
    EffectParameter,
    FoundEffect,
    Gap,
    Level,
    Location,
    ParameterChange,
    Signals,
)
from symid.diagnosis.findings.diagnosis_result import WeightedError
from symid.diagnosis.findings.gap import NotRepeated, Removed, Reversal

KINDS = ("effect", "two effects", "partly", "no gap", "parameters", "unexplained", "recording")
"""Diagnoses that can be made."""

_SENTENCES = {
    "effect": "Stribeck friction at the motor is missing from the model: with it the force error falls from "
    "{before:.3g} to {after:.3g} N, {closed:.0%} of the way to the noise.",
    "two effects": "Stribeck friction at the motor and a delay of the actuator are missing from the model: with both "
    "the force error falls from {before:.3g} to {after:.3g} N, {closed:.0%} of the way to the noise.",
    "partly": "Stribeck friction at the motor is missing from the model: with it the force error falls from "
    "{before:.3g} to {after:.3g} N; {left:.0%} of the excess stays unexplained.",
    "no gap": "There is no gap: the nominal values leave a force error of {before:.3g} N, as much as noise alone.",
    "parameters": "The structure of the model is right, its values were off: re-identified, it leaves {after:.3g} N, "
    "as much as the noise alone.",
    "unexplained": "The model leaves {before:.3g} N, several times the noise, and no known effect explains it.",
    "recording": "No physics is read from the gap of this log: q2 holds one value from 4.1 to 4.6 s.",
}
_NEXT = {
    "effect": "Nothing remains to be told apart. To narrow vs, move at 2 to 20 mm/s in both directions for 20 s.",
    "two effects": "A delay and a first-order lag of the drive are told apart by a chirp of 150 N, 20 to 120 Hz.",
    "partly": "To confirm Stribeck friction: hold several slow speeds in both directions.",
    "no gap": "Nothing is needed at these speeds; a faster motion would show what this one does not excite.",
    "parameters": "Use the identified values.",
    "unexplained": "Repeat the run with the table held: is the phase of the error tied to time, or to the motion?",
    "recording": "Record the log again; until then, trust neither parameters nor effects.",
}
_FAULTS = {
    "unexplained": ("Fm is clipped at ±1800 N in 12 samples",),
    "recording": ("q2 holds one value from 4.1 to 4.6 s",),
}
_VERDICTS = {"two effects": "effect", "no gap": "no_gap"}


def diagnosis_example(kind: str = "effect", seconds: float = 10.0) -> Diagnosis:
    """A diagnosis of one kind with all its parts filled."""
    signals = curves_of(kind, seconds)
    gap = _gap(kind, signals)
    sentence = _SENTENCES[kind].format(
        before=gap.reidentified.rms,
        after=gap.explained.rms,
        closed=gap.closed_fraction,
        left=gap.unexplained_share,
    )
    return Diagnosis(
        axis=load_axis("direct_2m1s"),
        measured=("q2",),
        logs=("logs/x_axis_2026-03-14_run1.csv", "logs/x_axis_2026-03-14_run2.csv"),
        verdict=_VERDICTS.get(kind, kind),
        sentence=sentence,
        gap=gap,
        location=_location(kind),
        maps=maps_of(signals),
        effects=_effects(kind, gap),
        alternatives=_alternatives(kind, gap),
        probabilities=_probabilities(kind),
        parameters=_parameters(kind),
        faults=_FAULTS.get(kind, ()),
        assumptions=(
            "d sign(q2_d1)/dt = 0 away from standstill",
            "Fm acts half a sample late (--held Fm)",
            "the noise of the force reading is white up to 120 Hz",
        ),
        next_experiment=_NEXT[kind],
        signals=signals,
        spectrum=spectrum_of(signals),
        weighted=WeightedError(
            (signals.measured - signals.explained) / FLOOR, signals.explained / FLOOR, np.eye(1, 64)[0]
        ),
    )


def without_nominal(found: Diagnosis) -> Diagnosis:
    """The same where no nominal values were given."""
    nothing = np.full_like(found.signals.time, np.nan)
    return replace(
        found,
        gap=replace(found.gap, nominal=None),
        parameters=tuple(replace(change, nominal=np.nan) for change in found.parameters),
        signals=replace(found.signals, nominal=nothing),
    )


def _gap(kind: str, signals: Signals) -> Gap:
    nominal, before, after = (
        level_of(signals.measured - force, signals)
        for force in (signals.nominal, signals.reidentified, signals.explained)
    )
    floor = Level(FLOOR, FLOOR * before.relative / before.rms)
    middle = Level((before.rms + 2 * after.rms) / 3, (before.relative + 2 * after.relative) / 3)
    steps = {"effect": (after,), "partly": (after,), "two effects": (middle, after)}.get(kind, ())
    span = before.rms - floor.rms
    closed = (before.rms - after.rms) / span if span > 0.1 else np.nan
    interval = (closed - 0.03, min(closed + 0.02, 1.0))
    excess = before.rms**2 - floor.rms**2
    left = max(after.rms**2 - floor.rms**2, 0.0) / excess if span > 0.1 else np.nan
    near = replace(signals, compared=signals.compared & (np.abs(signals.velocity) < 0.02))
    reversal = Reversal(
        *(level_of(near.measured - force, near) for force in (near.reidentified, near.explained))
    )
    new = NotRepeated(2.5, level_of(near.measured - near.explained, near))
    return Gap("Fm", "N", 120.0, nominal, before, after, floor, steps, closed, interval, left, reversal, new)


def _location(kind: str) -> tuple[Location, ...]:
    places = {
        "effect": (
            Location("motor", 0.94, (0.3, 12.0), "low speed"),
            Location("structure", 0.06, (40.0, 95.0), "fast"),
        ),
        "two effects": (
            Location("motor", 0.71, (0.3, 12.0), "low speed"),
            Location("actuator", 0.29, (15.0, 80.0), "accelerating"),
        ),
        "unexplained": (
            Location("motor", 0.88, (20.0, 26.0), "all"),
            Location("q2", 0.12, (60.0, 110.0), "all"),
        ),
        "partly": (Location("motor", 0.71, (0.3, 12.0), "low speed"),),
        "recording": (Location("q2", 1.0, (20.0, 26.0), "all"),),
    }
    return places.get(kind, ())


def _effects(kind: str, gap: Gap) -> tuple[FoundEffect, ...]:
    stribeck = FoundEffect(
        "stribeck_friction",
        "motor",
        0.9994,
        0.9994,
        {"dF": EffectParameter(44.6, 0.7, "N"), "vs": EffectParameter(0.0203, 0.0005, "m/s")},
        gap.steps[0] if gap.steps else gap.explained,
        Removed(*((0.71, 0.66, 0.75) if kind == "partly" else (0.968, 0.955, 0.979))),
        (),
    )
    delay = FoundEffect(
        "delay",
        "actuator",
        0.87,
        0.99,
        {"tau": EffectParameter(6.1e-4, 2.3e-5, "s")},
        Level(gap.reidentified.rms * 0.8, gap.reidentified.relative * 0.8),
        Removed(0.021, 0.014, 0.029),
        (("actuator_lag", "actuator"),),
    )
    return {"effect": (stribeck,), "partly": (stribeck,), "two effects": (stribeck, delay)}.get(kind, ())


def _alternatives(kind: str, gap: Gap) -> tuple[Alternative, ...]:
    ranked = {
        "effect": (("stribeck_friction", "motor", 0.9994, 8120.4),),
        "partly": (("stribeck_friction", "motor", 0.9712, 3120.4),),
        "two effects": (
            ("stribeck_friction", "motor", 0.9991, 8120.4),
            ("delay", "actuator", 0.87, 2214.0),
            ("actuator_lag", "actuator", 0.12, 2211.9),
        ),
    }.get(kind, ())
    rest = (
        ("presliding_friction", "motor", 5e-4, 6310.2 if ranked else 9.3),
        ("asymmetric_friction", "motor", 1e-6, 8.7),
        ("quadratic_drag", "motor", 1e-7, 6.0),
        ("cogging", "motor", 1e-9, 4.3),
        ("coulomb_friction", "structure", 1e-9, 3.0),
        ("stiffness_nonlinearity", "foundation", 0.0, 2.9),
        ("payload_change", "motor", 0.0, 2.1),
        ("encoder_ripple", "q2", 0.0, 1.2),
        ("saturation", "actuator", 0.0, 0.4),
    )
    return tuple(
        Alternative(effect, at, p, gain, gap.explained if p > 1e-5 else None)
        for effect, at, p, gain in (*ranked, *rest)
    )


def _probabilities(kind: str) -> dict[str, float]:
    most = {"no gap": "no_gap"}.get(kind, kind)
    return {name: 0.981 if name == most else 4e-4 for name in ("no_gap", "parameters", "unexplained")}


def _parameters(kind: str) -> tuple[ParameterChange, ...]:
    values = (
        ("Ms", "kg", 4100.0, 3917.2, 12.0, 3899.4, 9.6),
        ("Fvs", "N*s/m", 3000.0, 22140.0, 610.0, 3962.0, 240.0),
        ("Ks", "N/m", 1.1e9, 1.00412e9, 2.1e6, 1.00037e9, 1.8e6),
        ("Mm", "kg", 380.0, 362.71, 0.31, 362.60, 0.24),
        ("Fvm", "N*s/m", 60.0, 41.3, 3.2, 88.2, 1.9),
        ("Fsm", "N", 130.0, 158.8, 0.9, 146.3, 0.5),
    )
    absorbed = {"Fvs", "Fvm", "Fsm"} if kind in FOUND else set()
    return tuple(
        ParameterChange(
            name,
            unit,
            nominal,
            value if name in absorbed else after,
            std if name in absorbed else after_std,
            after,
            after_std,
            name in absorbed,
        )
        for name, unit, nominal, value, std, after, after_std in values
    )
