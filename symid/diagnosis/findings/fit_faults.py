"""Faults of a log that a model fitted to it shows: changed parameters, a constant or cut force, a wrong gain."""

import numpy as np

from symid.axis import CoulombFriction
from symid.data.quality import is_switched
from symid.diagnosis.effects.declared_friction import places_of
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import LogError
from symid.identification import CRITERIA
from symid.identification.deviations import greatest_change
from symid.identification.faults import CONSTANT, is_constant
from symid.text import moment


def changed_span(fit: Fit, of: str) -> str:
    """Sentence if separate parameters for a span of the log explain most of the error of a model; empty otherwise.

    Two machines in one log, or a gain that is another from some time on, are not effects of one machine. The log is
    called `of`.
    """
    record, names = fit.state.prediction.record, list(fit.parameters)
    segments, root = fit.blocks.segments(record.row_time[fit.weighting.kept])
    values = np.concatenate([list(fit.parameters.values()), np.zeros(len(root) - len(names))])
    change = greatest_change(segments, values, root)
    if change is None or change.explained < THRESHOLDS.changed_span:
        return ""
    # Few rows determine no parameter of a span, and an axis that lacks a law has values there that no machine has.
    axis, n = record.dynamics.axis, len(names)
    own = np.stack([change.inside, change.outside])[:, :n]
    certain = np.abs(own[0] - own[1]) > CRITERIA.change_certain * change.deviations[:n]
    certain &= (own.min(axis=0) >= 0.0) | np.array([name in axis.signed_parameters for name in names])
    if not certain.any():
        return ""
    i = change.most_certain(np.pad(certain, (0, values.size - n)))
    unit, begins = axis.physical_parameters[names[i]], moment(change.begins + record.log.start, 4)
    return (
        f"Look at what changed: in a part of {of} from {begins} s on {names[i]} is {change.inside[i]:.4g} "
        f"{unit}, elsewhere {change.outside[i]:.4g}. This explains "
        f"{100 * change.explained:.0f} % of the error: another payload, gain or machine. Diagnose the parts apart "
        "(`trim`)."
    )


_FAST = 0.1
"""Share of the top speed above which the direction of a motion is certain."""


def steady_force(fit: Fit) -> str:
    """Sentence if the force of an axis with free friction and inertia hardly changes in motion; otherwise empty.

    Friction alone explains such a log.
    """
    prediction = fit.state.prediction
    record, free = prediction.record, prediction.parameters
    if record.n_drives > 1 or not record.dynamics.parameters_of("mass") & free.keys():
        return ""
    (name,), at = record.forces, np.rint(record.fine_time / record.log.sampling_period).astype(int)
    force = record.log[name][np.minimum(at, record.log.n_samples - 1)]
    for law in prediction.axis.laws:
        is_free = isinstance(law, CoulombFriction) and any(term.parameter in free for term in law.terms())
        for place in places_of(prediction, law) if is_free else ():
            joint = prediction.joints[place]
            fast = record.in_log & (np.abs(joint.v) > _FAST * joint.top_speed)
            if is_constant(force[fast], np.sign(joint.v[fast])[None]):
                return CONSTANT.format(name)
    return ""


_LEVEL = 10.0
"""Error of a reading in multiples of its noise below which its gain is not doubted."""
_OFF = 0.03
"""Least relative error of a gain."""
_ALL_OF_IT = 0.95
"""Share of the power of the error, and of the prediction, that a wrong gain takes away: effects of the machine are not
in proportion."""


def wrong_gain(fit: Fit) -> str:
    """Sentence if another gain of a sensor removes nearly all of its error; otherwise empty.

    Its reading is then in proportion to the predicted one, but not the same.
    """
    prediction, weighting = fit.state.prediction, fit.weighting
    record, levels = prediction.record, prediction.levels
    if not levels:
        return ""
    rows = weighting.rows(np.stack([record.measured, prediction.outputs]))[..., weighting.kept]
    for name, level, read, predicted in zip(
        record.readings, levels[record.n_drives :], *rows[:, record.n_drives :], strict=True
    ):
        power = float(read @ read)
        if level < _LEVEL or not power:
            continue
        factor = float(read @ predicted) / power
        before, after = (float(np.sum((predicted - x * read) ** 2)) for x in (1.0, factor))
        # a reading many times the prediction errs by itself, with any gain: they must be in proportion
        if abs(factor - 1.0) > _OFF and after < (1.0 - _ALL_OF_IT) * min(
            before, float(predicted @ predicted)
        ):
            return (
                f"{name} would have to be {factor:.3g} times as large to agree with the other signals: its unit or "
                "gain is wrong, or a ratio of the axis"
            )
    return ""


_FLAT, _OF_NOISE = 0.002, 8.0
"""Width of a limit: part of the range of the force, and standard deviations of its noise."""
_LEAST = 0.005
"""Least share of the motion in which the force is at the limit."""
_REST = 0.1
"""Most mean square that the rest of the log leaves, relative to that of the whole: else the model lacks more."""
_BEYOND, _VARIES = 5.0, 3.0
"""Least mean excess of the prediction over the limit, relative to its error in the rest of the log, and least spread of
the prediction, relative to that of the record."""


def cut_force(found: Fit, drive: int) -> str:
    """Sentence if the range of a recorded force ended before the force did; empty if it did not.

    A drive at its limit moves the axis by the force that is recorded: a model fitted to the rest of the log predicts
    that force. Where it predicts more, differently from moment to moment while the record hardly changes, the record
    was cut.
    """
    record = found.state.prediction.record
    name = record.forces[drive]
    samples, width = record.log[name], _OF_NOISE * float(record.noise_of_outputs[drive])
    if found.squares[drive] < THRESHOLDS.fit_of_noise or is_switched(samples):
        return ""
    at = np.rint(record.fine_time / record.log.sampling_period).astype(int)
    force = samples[np.minimum(at, samples.size - 1)]
    moving = record.in_log & record.moves(record.speeds[drive])
    width = max(width, _FLAT * float(np.ptp(samples)))
    top, bottom = moving & (force > samples.max() - width), moving & (force < samples.min() + width)
    free = moving & ~(top | bottom)
    try:
        allowed = free if found.weighting.allowed is None else free & found.weighting.allowed
        rest = fitted(*first_state(record, found.parameters, allowed))
    except LogError:
        return ""
    if rest.squares[drive] > _REST * found.squares[drive]:
        return ""
    asked = record.fine(record.measured[drive] - rest.state.errors[drive])
    error = float(np.sqrt(np.mean((asked - force)[free] ** 2)))
    for sign, limited in ((1.0, top), (-1.0, bottom)):
        if np.sum(limited) < _LEAST * np.sum(moving):
            continue
        beyond = sign * (asked - force)[limited]
        varies = np.std(asked[limited]) > _VARIES * np.std(force[limited])
        if np.mean(beyond) > _BEYOND * error and varies:
            return (
                f"{name} ends at {np.mean(force[limited]):.4g} in {100 * np.sum(limited) / np.sum(moving):.2g} % of "
                f"the motion, which asks for up to {asked[limited][np.argmax(beyond)]:.4g} there: its record is "
                "clipped; record with a wider range, or cut those parts out"
            )
    return ""
