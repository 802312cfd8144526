"""Correctness of answers, and absurd ones: values that no machine has, however small the error."""

import math
from collections.abc import Iterator

from symid.axis import PendulumWeight
from symid.diagnosis import Diagnosis, FoundEffect

from .case import Case
from .plain import Plain

_CHANGE = 2.0
"""Factor by which an inertia may differ from all that is known of it, for an effect that is not about it."""
_ABOUT_MASS = ("flexible_mode", "payload_change", "weight", "gain_nonlinearity")
_SHAPES = ("pitch", "f", "D", "vs", "t0", "reach", "b", "limit")
"""Parameters that say where or how, not how much."""
_NOT_NEGATIVE = {
    ("viscous_friction", "Fv"),
    ("coulomb_friction", "Fs"),
    ("presliding_friction", "Fs"),
    ("quadratic_drag", "c"),
    ("load_dependent_friction", "mu"),
    ("flexible_mode", "m"),
    ("backlash", "b"),
    ("weight", "M"),
    ("weight", "ml"),
}
_MOST = {("load_dependent_friction", "mu"): 0.5, ("delay", "T"): 0.05, ("actuator_lag", "T"): 0.05}


def rightness(case: Case, found: Diagnosis) -> str:
    """Whether the first effect is right.

    Returns
    -------
    str
        "yes" if it is published; "tie" if it is said to be indistinguishable from one that is; "script" if it is not
        published but a plain script confirms it; "no"; "-" where nothing is published.
    """
    if not found.effects:
        return "no" if case.right else "-"
    first = found.effects[0]
    key = first.effect, first.at
    if key in case.right:
        return "yes"
    if set(first.indistinguishable_from) & set(case.right):
        return "tie"
    if key in case.confirmed:
        return "script"
    return "no" if case.right else "-"


def absurdities(case: Case, found: Diagnosis, script: Plain) -> tuple[str, ...]:
    """Physically impossible values in an answer, a few words each.

    Parameters
    ----------
    case : Case
        With its nominal values.
    found : Diagnosis
        The answer.
    script : Plain
        What the plain script found. An inertia that none of the three comes within a factor of two of, the
        re-identified, the nominal and the script's, is absurd.
    """
    said = [*_of_masses(case, found, script)]
    for effect in found.effects:
        said += _of_effect(effect)
    return tuple(said)


def _of_masses(case: Case, found: Diagnosis, script: Plain) -> Iterator[str]:
    bodies, laws = found.axis.free_bodies, found.axis.laws
    column = {law.moment: "weight" for law in laws if isinstance(law, PendulumWeight)}
    column |= {body.mass or body.inertia or "": "inertia" if len(bodies) == 1 else "" for body in bodies}
    about_mass = any(effect.effect in _ABOUT_MASS for effect in found.effects)
    for change in found.parameters:
        if change.name not in column:
            continue
        known = (
            change.reidentified,
            case.nominal.get(change.name),
            script.best.values.get(column[change.name]),
        )
        near = any(x and 1 / _CHANGE <= change.explained / x <= _CHANGE for x in known)
        if change.explained <= 0 or (found.effects and not (near or about_mass)):
            yield f"{change.name} {change.reidentified:.3g} -> {change.explained:.3g}"


def _of_effect(effect: FoundEffect) -> Iterator[str]:
    sizes: list[bool] = []
    shapes: list[bool] = []
    for name, parameter in effect.parameters.items():
        key = effect.effect, name
        if (key in _NOT_NEGATIVE and parameter.value < 0) or abs(parameter.value) > _MOST.get(key, math.inf):
            yield f"{effect.effect} {name} {parameter.value:.3g}"
        if math.isfinite(parameter.std):
            known = abs(parameter.value) > parameter.std
            (shapes if name in _SHAPES else sizes).append(known)
    if not any(sizes or shapes or [True]):
        yield f"{effect.effect} less than its deviation"
