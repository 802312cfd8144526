"""The verdict in words."""

from collections.abc import Sequence

from symid.diagnosis.effects import LIBRARY, LawEffect
from symid.diagnosis.findings.diagnosis_result import Diagnosis, Simulator
from symid.diagnosis.findings.found_effects import Alternative, FoundEffect, ParameterChange
from symid.diagnosis.findings.gap import Gap, Level
from symid.diagnosis.findings.parameter_changes import lost
from symid.diagnosis.selection.evidence import Verdict
from symid.diagnosis.thresholds import THRESHOLDS
from symid.text import listed, spoken

_ADVICE = {
    "delay": "excite more above 50 Hz (multisine), so that a delay and a first-order lag differ",
    "actuator_lag": "excite more above 50 Hz (multisine), so that a delay and a first-order lag differ",
    "presliding_friction": "reverse slowly over 10 to 500 um",
    "friction_drift": "repeat the same motion from cold until nothing changes",
    "payload_change": "repeat the same motion with the load fixed",
    "force_constant_ripple": "accelerate at two levels over the same stroke: cogging keeps its height",
    "encoder_ripple": "move at two speeds over the whole stroke: an error of the reading grows with the speed squared",
    "periodic_disturbance": "record the axis at rest and at two speeds: a disturbance in time keeps its frequency",
    "flexible_mode": "excite with a multisine up to twice the frequency found",
    "load_dependent_friction": "move at the same speeds with and without a load on the drive",
    "saturation": "accelerate at levels below and above the limit found",
    "gain_nonlinearity": "accelerate at several levels up to the limit",
}
_LIKELY = 0.5
"""Probability above which the sentence states an effect without reservation."""
_ADVICE |= {
    effect.name: effect.advice for effect in LIBRARY if isinstance(effect, LawEffect) and effect.advice
}


def sentence(found: Diagnosis) -> str:
    """The verdict in one sentence, with the gaps of all drives, the main one first; and a sentence on the motion."""
    gap = found.gap
    gaps = (gap, *(own.gap for own in found.drives if own.gap.signal != gap.signal))
    left, before = _sizes(gaps, [g.explained for g in gaps]), _sizes(gaps, [g.reidentified for g in gaps])
    rest = ""
    if gap.reidentified.rms > THRESHOLDS.white * gap.noise_floor.rms:
        rest = (
            "; nothing in the library explains the rest, which drifts in the same way however the axis moves"
        )
    if found.verdict == "no_gap":
        return f"There is no gap: the model leaves {before}{rest}.{of_doubtful_values(found)}"
    if found.verdict == "parameters":
        of_nominal = [f"{g.nominal.rms:.3g} {g.unit}" for g in gaps if g.nominal is not None]
        nominal = f" instead of {' and '.join(of_nominal)}" if of_nominal else ""
        if rest:
            return f"Parameter values were off: re-identified, the model leaves {before}{nominal}{rest}."
        if doubtful := of_doubtful_values(found):
            return f"Parameter values were off: re-identified, the model leaves {before}{nominal}.{doubtful}"
        values = "The structure is right and only parameter values were off"
        return f"{values}: re-identified, the model leaves {before}{nominal}."
    if found.verdict == "recording":
        return f"No physics is read from the gap of this log: {found.faults[0].rstrip('.')}."
    if found.verdict == "unexplained":
        rivals = found.alternatives
        nearest = f"; the nearest is {spoken(rivals[0].effect, rivals[0].at)}" if rivals else ""
        return f"There is a gap of {before} that nothing in the library explains{nearest}."
    with_them = "with them" if len(found.effects) > 1 else "with it"
    falls = "force errors fall" if len(gaps) > 1 else "force error falls"
    text = f"The model {_lacking(found.effects)}: {with_them}, "
    if (first := found.effects[0]).shown_by in {g.signal for g in gaps}:
        text += f"the {falls} from {before} to {left}"
    else:
        share = f"{100 * first.removes.share:.0f} % of the excess error of {first.shown_by} is gone"
        text += f"{share}; the force error is {left} in place of {before}"
    if found.verdict == "partly":
        text += f"; {100 * gap.unexplained_share:.0f} % of the excess stays unexplained"
    if quantity := found.effects[0].outdone_by:
        text += (
            f"; a law of the {quantity} of another shape explains clearly more, which the library may lack"
        )
    return f"{text}.{of_motion(found)}{of_doubtful_values(found)}"


def of_doubtful_values(found: Diagnosis) -> str:
    """Sentences on values that are impossible, at their bounds, or not determined by the log; or empty."""
    signed = found.axis.signed_parameters
    negative = [p for p in found.parameters if p.is_negative and p.name not in signed]
    least = [p for p in found.parameters if p.at_bound]
    missing = lost(found.axis, found.parameters)
    vague = [p for p in missing if p not in least]
    said = []
    if vague:
        names = listed([p.name for p in vague])
        said.append(f"This log does not show {names}: accelerate more, with several forces and frequencies.")
    if negative:
        cause = "small errors of model or timing that this log hardly shows distort it"
        said.append(f"No machine has {_values(negative)}: {cause}.")
    if least:
        held, them = ("is at its bound", "it") if len(least) == 1 else ("are at their bounds", "them")
        bound = "half of the nominal or re-identified value, whichever is smaller"
        said.append(f"{_values(least)} {held}, {bound}: determine {them} from another log.")
    if missing and any(effect.effect == "flexible_mode" for effect in found.effects):
        said.append(
            "The mode may be one that the axis declares: give nominal values near those of the machine."
        )
    return "".join(f" {sentence}" for sentence in said)


def _values(parameters: Sequence[ParameterChange]) -> str:
    return listed([f"{p.name} = {p.explained:.3g} {p.unit}" for p in parameters])


def _lacking(effects: Sequence[FoundEffect]) -> str:
    """Words for the missing effects, and for those indistinguishable from the first."""
    first, *further = (spoken(effect.effect, effect.at) for effect in effects)
    likely = [effect.probability_with_ties > _LIKELY for effect in effects]
    further = [name if sure else f"perhaps {name}" for name, sure in zip(further, likely[1:], strict=True)]
    doubt = effects[0].indistinguishable_from
    lacks = "lacks" if likely[0] else "may lack"
    if doubt:
        either = listed([spoken(*key) for key in doubt], "or")
        first += f" (or {either}: this log does not distinguish them)"
    return f"{lacks} {listed([first, *further])}"


def of_motion(found: Diagnosis) -> str:
    """Sentence on the simulated position error before and after; empty without effects."""
    motion = found.gap.motion
    if (
        motion is None
        or not motion.steps
        or not motion.reidentified.status == motion.explained.status == "ok"
    ):
        return ""
    before, after = motion.reidentified.position_rms, motion.explained.position_rms
    scale, prefix = (1e3, "m") if max(before, after) >= 1e-3 else (1e6, "u")
    first, last = (f"{scale * rms:.3g} {prefix}{motion.unit}" for rms in (before, after))
    place = motion.signal if found.drives else "position"
    return f" Simulated, the axis is then {last} off the measured {place} instead of {first} (rms)."


def rejection(found: Diagnosis) -> str:
    """Sentence on effects that would close the gap of the force, but that the simulated motion contradicts."""
    named = listed([spoken(effect.effect, effect.at) for effect in found.effects])
    share = 100 * (1 - found.gap.unexplained_share)
    return f"Rejected: {named} would remove {share:.0f} % of the excess of the force.{of_motion(found)}"


def sentence_against(found: Diagnosis, simulator: Simulator) -> str:
    """The difference between a machine and a simulator in words."""
    gap, apart = found.gap, [p.name for p in simulator.parameters if p.differs]
    apart += [spoken(e.effect, e.at) for e in simulator.effects if e.differs]
    surplus = [spoken(e.effect, e.at) for e in simulator.effects if e.machine is None]
    before = "" if gap.nominal is None else f" from {_size(gap, gap.nominal.rms)}"
    shrinks = f": with the machine's, the force error falls{before} to {_size(gap, gap.explained.rms)}."
    parts = []
    if found.effects:
        parts.append("lacks " + listed([spoken(e.effect, e.at) for e in found.effects]))
    if surplus:
        parts.append(f"has {listed(surplus)}, which the machine does not have")
    if apart and found.verdict != "no_gap":
        parts.append(f"has other values of {', '.join(apart)}")
    if found.verdict == "unexplained":
        also = f" It {', and '.join(parts)}." if parts else ""
        return f"Nothing in the library explains why machine and simulator differ{shrinks}{also}"
    if parts:
        return f"The simulator {', and '.join(parts)}{shrinks}{of_motion(found)}"
    if found.verdict == "no_gap":
        return (
            f"There is no gap: the simulator leaves {_size(gap, gap.explained.rms)} of the machine's force."
        )
    return f"The simulator has the machine's structure and slightly other values{shrinks}"


def _sizes(gaps: Sequence[Gap], levels: Sequence[Level]) -> str:
    """Sizes of the errors of all drives, with their signals if there are several."""
    if len(gaps) == 1:
        return _size(gaps[0], levels[0].rms)
    sizes = (f"{_size(gap, level.rms)} in {gap.signal}" for gap, level in zip(gaps, levels, strict=True))
    return " and ".join(sizes)


def _size(gap: Gap, rms: float) -> str:
    multiple = rms / gap.noise_floor.rms
    return f"{rms:.3g} {gap.unit} ({multiple:{'.1f' if multiple >= 0.1 else '.1g'}} times the noise)"


def next_experiment(
    verdict: Verdict,
    effects: Sequence[FoundEffect],
    rivals: Sequence[Alternative],
    undetermined: Sequence[str],
) -> str:
    """The next step, in words."""
    if verdict == "no_gap":
        return "None is needed for this motion; for others, repeat the diagnosis with a log of those."
    if verdict == "parameters":
        values = "Take over the re-identified values"
        if undetermined:
            values += f" but {listed(undetermined)}, which the sensors used do not separate"
        return f"{values}, and repeat the diagnosis on another motion."
    if verdict == "recording":
        return "Record the log again; until then, trust neither parameters nor effects."
    if verdict == "unexplained":
        first = _ADVICE.get(rivals[0].effect, "") if rivals else ""
        return "Look at where the gap lies" + (f"; to test the nearest candidate, {first}." if first else ".")
    doubt = effects[0].indistinguishable_from
    advice = _ADVICE.get(effects[0].effect, "repeat the diagnosis on another motion")
    if doubt and doubt[0][0] == effects[0].effect:
        return f"Measure the motion of {doubt[0][1]} too: the sensors used do not distinguish the two places."
    if doubt:
        return f"To distinguish {spoken(effects[0].effect)} from {spoken(doubt[0][0])}: {advice}."
    return f"To confirm {spoken(effects[0].effect)}: {advice}."
