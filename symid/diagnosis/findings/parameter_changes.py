"""Parameters before and after the effects, and the values of the effects."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from symid.axis import Axis
from symid.diagnosis.effects import declared_effects, with_presliding_parts
from symid.diagnosis.findings.found_effects import EffectParameter, ParameterChange
from symid.diagnosis.fitting.fit import Fit, masses_and_stiffnesses
from symid.diagnosis.fitting.moments import moment_deviation
from symid.diagnosis.thresholds import THRESHOLDS


def effect_values(fit: Fit) -> list[dict[str, EffectParameter]]:
    """Free values of each effect with standard deviations.

    A moment that the log does not determine, because the axis does not accelerate, may lie anywhere in that time, at
    most with the deviation of a uniform distribution over the log.
    """
    parts = with_presliding_parts(fit.state.placed)
    if parts != fit.state.placed:  # otherwise the cached derivatives stay valid
        fit = replace(fit, state=replace(fit.state, placed=parts))
    deviations = fit.standard_deviations
    anywhere = fit.state.prediction.record.duration / math.sqrt(12.0)
    found = list[dict[str, EffectParameter]]()
    for at, (item, places) in enumerate(zip(fit.state.placed, fit.state.values_of, strict=True)):
        parameters = {}
        values = item.values(fit.state.prediction)
        for (name, value, unit), linear in zip(values, deviations[places], strict=True):
            std = float(linear)
            if name in item.effect.moments:
                std = min(max(std, moment_deviation(fit, at, name)), anywhere)
            parameters[name] = EffectParameter(value, std, unit)
        found.append(parameters)
    return found


def parameter_changes(
    fits: Sequence[Fit], nominal: Mapping[str, float] | None
) -> tuple[ParameterChange, ...]:
    """Parameters, and values of declared imperfections as `effect.value`; `effect_2.value` for a second one."""
    base, last = fits[0], fits[-1]
    before, after = base.standard_deviations, last.standard_deviations
    units = base.state.prediction.axis.physical_parameters
    changes = [
        _change(
            (name, str(units[name]), (nominal or {}).get(name, math.nan)),
            (base.parameters[name], float(before[i])),
            (last.parameters[name], float(after[i])),
            at_bound=math.isclose(last.parameters[name], last.state.bounds.get(name, (math.nan,))[0]),
        )
        for i, name in enumerate(base.parameters)
    ]
    declared = declared_effects(base.state.prediction)
    known = [effect_values(fit)[: len(declared)] for fit in (base, last)]
    seen = Counter[str]()
    for item, olds, news in zip(declared, *known, strict=True):
        effect = item.effect.name
        seen[effect] += 1
        label = effect if seen[effect] == 1 else f"{effect}_{seen[effect]}"
        for name, value, unit in item.values(base.state.prediction):
            old, new = olds[name], news[name]
            changes.append(
                _change((f"{label}.{name}", unit, value), (old.value, old.std), (new.value, new.std))
            )
    return tuple(changes)


def _change(
    declared: tuple[str, str, float],
    before: tuple[float, float],
    after: tuple[float, float],
    *,
    at_bound: bool = False,
) -> ParameterChange:
    """The change of a parameter (name, unit, nominal value) from value and deviation `before` effects to `after`."""
    (old, old_std), (new, new_std) = before, after
    limit = max(THRESHOLDS.absorbed_deviations * old_std, THRESHOLDS.absorbed_share * abs(new))
    absorbed = before != after and abs(new - old) > limit
    return ParameterChange(*declared, old, old_std, new, new_std, absorbed=bool(absorbed), at_bound=at_bound)


def lost(axis: Axis, parameters: Sequence[ParameterChange]) -> list[ParameterChange]:
    """Masses and stiffnesses that the logs do not determine beside the effects, or that are at their lower bounds."""
    masses = masses_and_stiffnesses(axis)
    return [own for own in parameters if own.at_bound or (own.name in masses and not own.is_shown)]
