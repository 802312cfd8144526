"""The verdict in words."""

from __future__ import annotations

from collections.abc import Sequence

from symid.diagnosis.record import Record
from symid.diagnosis.result import Alternative, FoundEffect, Gap, Verdict

_ADVICE = {
    "delay": "excite more above 50 Hz (multisine), so that a delay and a first-order lag part",
    "actuator_lag": "excite more above 50 Hz (multisine), so that a delay and a first-order lag part",
    "backlash": "reverse slowly under small loads, so that the spring passes its zero often",
    "stiffness_nonlinearity": "accelerate at several levels up to the limit",
    "stribeck_friction": "move at five to ten constant speeds below 10 % of the highest",
    "presliding_friction": "reverse slowly over 10 to 500 um",
    "coulomb_friction": "move at constant speeds in both directions",
    "viscous_friction": "move at several constant speeds in both directions",
    "asymmetric_friction": "move over the same stroke at the same speeds in both directions",
    "offset_force": "turn the axis round, or unload it: a constant force stays, friction changes its sign",
    "friction_drift": "repeat the same motion from cold until nothing changes",
    "payload_change": "repeat the same motion with the load fixed",
    "position_dependent_friction": "move slowly over the whole stroke in both directions",
    "position_stiffness": "move slowly over the whole stroke in both directions",
    "cogging": "move slowly at two speeds over the whole stroke: ripple of the stroke scales its frequency with speed",
    "encoder_ripple": "move at two speeds over the whole stroke: an error of the reading grows with the speed squared",
    "periodic_disturbance": "record the axis at rest and at two speeds: a disturbance in time keeps its frequency",
    "flexible_mode": "excite with a multisine up to twice the frequency found",
    "load_dependent_friction": "move at the same speeds with and without a load on the drive",
    "quadratic_drag": "move at several high constant speeds",
    "saturation": "accelerate at levels below and above the limit found",
    "gain_nonlinearity": "accelerate at several levels up to the limit",
}


def sentence(
    verdict: Verdict, gap: Gap, effects: Sequence[FoundEffect], rivals: Sequence[Alternative]
) -> str:
    """The verdict in one sentence."""
    floor = gap.noise_floor.rms
    left = f"{gap.explained.rms:.3g} {gap.unit} ({gap.explained.rms / floor:.1f} times the noise)"
    before = f"{gap.reidentified.rms:.3g} {gap.unit} ({gap.reidentified.rms / floor:.1f} times the noise)"
    if verdict == "no_gap":
        return f"There is no gap: the model leaves {before}."
    if verdict == "parameters":
        nominal = "" if gap.nominal is None else f" instead of {gap.nominal.rms:.3g} {gap.unit}"
        values = "The structure is right and only parameter values were off"
        return f"{values}: re-identified, the model leaves {before}{nominal}."
    if verdict == "unexplained":
        nearest = f"; the nearest is {rivals[0].effect} at {rivals[0].at}" if rivals else ""
        return f"There is a gap of {before} that nothing in the library explains{nearest}."
    named = " and ".join(f"{effect.effect} at {effect.at}" for effect in effects)
    doubt = effects[0].indistinguishable_from
    other = f" (this log does not tell it from {doubt[0][0]} at {doubt[0][1]})" if doubt else ""
    return f"The model lacks {named}{other}: with it, the force error falls from {before} to {left}."


def next_experiment(
    verdict: Verdict, effects: Sequence[FoundEffect], rivals: Sequence[Alternative], record: Record
) -> str:
    """What to do next."""
    if verdict == "no_gap":
        return "None is needed for this motion; for others, repeat the diagnosis with a log of theirs."
    if verdict == "parameters":
        return "Take over the re-identified values, and repeat the diagnosis on another motion."
    if verdict == "unexplained":
        first = _ADVICE.get(rivals[0].effect, "") if rivals else ""
        return "Look at where the gap lies" + (f"; to test the nearest candidate, {first}." if first else ".")
    doubt = effects[0].indistinguishable_from
    advice = _ADVICE.get(effects[0].effect, "repeat the diagnosis on another motion")
    if doubt and doubt[0][0] == effects[0].effect:
        return f"Measure the motion of {doubt[0][1]} too: the sensors used do not tell both places apart."
    if doubt:
        return f"To tell {effects[0].effect} from {doubt[0][0]}: {advice}."
    return f"To confirm {effects[0].effect}: {advice}."
