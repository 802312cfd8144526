"""The steps of the integration of hidden motion, compiled; `hidden_motion` prepares their arguments."""

import numpy as np

from symid.jit import jitted, part
from symid.simulation.compiled_loop import built_up, evaluate

_SETTLED = 1e-6
"""Relative change at which the level of dry friction and the speed in a step have settled."""


@jitted
def integrate_steps(equation, driven, laws):  # type: ignore[no-untyped-def]  # compiled for records
    """Hidden coordinate as predicted and as observed, each (n,), and forces of laws, (n_laws, n), from rest at 0 on.

    Laws act at the observed motion, which an observer of the given `gain` corrects by the measured force. The predicted
    motion is the response to the forces of the laws alone, and equal to the observed one without gain. Smooth forces
    follow Heun's rule. Dry friction is constant over each step, with its level at the mean speed of the step.
    """
    # Numba counts references at each access to a field: the fields are read once, here.
    transition, falling, rising, held = equation
    phase, begins, ends_at, load, by_state, q, v, rest, gain = driven
    by_driven, by_hidden, on_hidden, on_drive, reach, dry, rounds, courses = laws[:8]
    operations, operands, ends, arguments, stack = laws[8:]
    n_laws, n = dry.size, load.size
    observed, corrections, forces = np.zeros(n), np.zeros(n), np.zeros((n_laws, n))
    before, speed_before = np.zeros(n_laws), np.zeros(n_laws)
    x, rate, total, before_drive, last_elastic = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        last_total, p = total, phase[i]
        if i:
            x, rate = _linear_step(
                x, rate, begins[i], ends_at[i], total, p, transition, falling, rising, held
            )
        elastic = by_state[p, 0] * x + by_state[p, 1] * rate
        drive = load[i] + elastic
        if i:
            for j in range(n_laws):
                drive += on_drive[p, j] * forces[j, i - 1]
        # dry friction acts over the step that ends here, smooth forces act at its end
        midway = 0.5 * (drive + before_drive) if i else drive
        before_drive, total = drive, 0.0
        for j in range(n_laws):
            arguments[j, 2], arguments[j, 4] = courses[j, i], midway if dry[j] else drive
            if dry[j]:
                continue
            place, speed = by_driven[j] * q[i] + by_hidden[j] * x, by_driven[j] * v[i] + by_hidden[j] * rate
            if np.isfinite(reach[j]):
                arguments[j, 3] = built_up(arguments[j, 3], place - before[j], reach[j])
                before[j] = place
            arguments[j, 0], arguments[j, 1] = place, speed
            forces[j, i] = _value(j, operations, operands, ends, arguments, stack)
            total += on_hidden[j] * forces[j, i]
        # Corrector: the change of the smooth forces rises linearly over the step.
        x -= rising[p, 0] * (total - last_total)
        rate -= rising[p, 1] * (total - last_total)
        for j in range(n_laws):
            if not dry[j]:
                continue
            place, speed = by_driven[j] * q[i] + by_hidden[j] * x, by_driven[j] * v[i] + by_hidden[j] * rate
            slowing = by_hidden[j] * held[p, 1] * on_hidden[j]  # of the joint in a step, for a unit of force
            arguments[j, 0] = 0.5 * (before[j] + place)
            stop = speed / slowing  # stops the joint in the step; it is at most the level of the law
            level_before = abs(forces[j, i - 1]) if i else 0.0
            own = min(max(stop, -level_before), level_before)  # the level hardly changes from step to step
            # Fixed point: the level depends on the mean speed, and this on the force.
            for _ in range(rounds[j]):
                arguments[j, 1] = 0.5 * (speed_before[j] + (speed - slowing * own))
                level = _value(j, operations, operands, ends, arguments, stack)
                last, own = own, level if stop > level else -level if stop < -level else stop
                if abs(own - last) <= _SETTLED * abs(own):
                    break
            forces[j, i], before[j], speed_before[j] = own, place, speed - slowing * own
            x -= held[p, 0] * on_hidden[j] * own
            rate -= held[p, 1] * on_hidden[j] * own
        if i:  # at the point before, where the dry friction is known by now
            unexplained = rest[i - 1] - last_elastic
            for j in range(n_laws):
                acting = 0.5 * (forces[j, i - 1] + forces[j, i]) if dry[j] else forces[j, i - 1]
                unexplained -= on_drive[p, j] * acting
            corrections[i] = gain[i - 1] * unexplained
            x += corrections[i]
        last_elastic, observed[i] = elastic, x
    predicted = observed - _moved_by(corrections, transition, phase) if corrections.any() else observed.copy()
    return predicted, observed, forces


@part
def _linear_step(x, rate, now, then, total, p, transition, falling, rising, held):  # type: ignore[no-untyped-def]
    """Hidden coordinate and its rate a step later, exact for an input that is linear between `now` and `then`.

    The smooth forces `total` are held at their values before the step; a corrector adds their change.
    """
    given, quickened = (
        falling[p, 0] * now + rising[p, 0] * then,
        falling[p, 1] * now + rising[p, 1] * then,
    )
    return (
        transition[p, 0, 0] * x + transition[p, 0, 1] * rate + given - held[p, 0] * total,
        transition[p, 1, 0] * x + transition[p, 1, 1] * rate + quickened - held[p, 1] * total,
    )


@jitted
def _moved_by(corrections, transition, phase):  # type: ignore[no-untyped-def]
    """Motion that corrections of the hidden coordinate leave behind, which no force changes."""
    moved, x, rate = np.zeros(corrections.size), 0.0, 0.0
    for i in range(corrections.size):
        p = phase[i]
        ahead = transition[p, 0, 0] * x + transition[p, 0, 1] * rate
        rate = transition[p, 1, 0] * x + transition[p, 1, 1] * rate
        x = ahead + corrections[i]
        moved[i] = x
    return moved


@jitted
def _value(j, operations, operands, ends, arguments, stack):  # type: ignore[no-untyped-def]
    """Value of the program of a law at its current arguments."""
    begin, end = ends[j], ends[j + 1]
    return evaluate(operations[begin:end], operands[begin:end], arguments[j], stack)
