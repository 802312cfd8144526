"""Motion in which joints stick, slip or reverse, compiled.

Between two events the motion is linear, and is advanced exactly by the matrix exponential of a stick-slip mode. An
event is the moment at which a sliding joint comes to rest, or the force on a resting joint leaves the range that its
law can hold: Coulomb friction is set-valued at rest, without any smoothing. Events are located within a step to
rounding, as roots of the Taylor series of the motion.

Laws that depend on displacement or speed otherwise (a sine, a cube, a friction that falls with speed) act as a force
that is constant over a step, taken at its midpoint (exponential midpoint rule, second order).
"""

import numpy as np

from symid.jit import inner, part
from symid.simulation.compiled_loop.evaluation import law_value
from symid.simulation.loops.loop_numbers import SLIDING, STUCK, VARYING
from symid.simulation.plants.plant import JUST_MOVING

UNKNOWN = -1
"""In place of a mode that is not in the table: its signs are in `wanted`."""
_NOT_PASSED = 2.0
"""In place of the sign of a joint after an event."""
_MOST_EVENTS = 100
"""Most events in one step; the rest of the step ignores further ones (Zeno behaviour)."""
_MOST_TRIALS, _SHARP = 100, 2.3e-16
"""Most Newton iterations for an event, and the change, relative to the step, at which they end."""


@part
def pass_events(current, state, drive, duration, laws, modes):  # type: ignore[no-untyped-def]
    """Advance a state over a duration under a generalised drive force; return the mode at its end, or `UNKNOWN`."""
    # Joints that stuck at the last event may break loose under the new force before any time passes.
    current, left, events = _release(current, state, drive, laws, modes), duration, 0
    while current != UNKNOWN and left > 0:
        seeks = events < _MOST_EVENTS
        current, made, is_event = _until_event(current, state, drive, left, seeks, laws, modes)
        left, events = left - made, events + is_event
    return current


@inner
def acceleration(current, state, drive, laws, modes, out):  # type: ignore[no-untyped-def]
    """Write the accelerations under a generalised drive force to `out`; return the mode then, or `UNKNOWN`."""
    current = _release(current, state, drive, laws, modes)
    if current != UNKNOWN:
        n = drive.size
        z = _with_force(current, state, drive, laws, modes)
        for i in range(n):
            out[i] = 0.0
            for j in range(3 * n):
                out[i] += modes.rates[current, i, j] * z[j]
    return current


@part
def _until_event(current, state, drive, duration, seeks, laws, modes):  # type: ignore[no-untyped-def]
    """Advance by a duration, or to the event before its end that it `seeks`; return mode, time, and whether it came."""
    # Within a mode the motion is a Taylor series in time. A sliding joint's speed and a stuck joint's margin are linear
    # in the state, so each event is the first zero of a polynomial. It is sought only if the sign at the end of the
    # step shows that it was passed; the state at the earliest zero then begins the next mode.
    n, n_laws, reach = drive.size, len(modes.directions), modes.reach[current]
    made = min(duration, reach)
    whole = made / reach
    z = _with_force(current, state, drive, laws, modes)
    terms = _series(modes.series[current], z)
    if _varies(modes.kinds, current):
        middle = _with_force(current, _at(terms, whole / 2), drive, laws, modes)
        for i in range(2 * n, 3 * n):
            z[i] = middle[i]
        terms = _series(modes.series[current], z)
    end = _at(terms, whole)
    first, joint, sign = whole, n_laws, 0.0
    for j in range(n_laws if seeks else 0):
        side, polynomial = _passed(current, j, state, terms, z, end, laws, modes)
        if side != _NOT_PASSED:
            time = _first_zero(polynomial, whole)
            if joint == n_laws or time < first:
                first, joint, sign = time, j, side
    end = _at(terms, first)
    for i in range(2 * n):
        state[i] = end[i]
    if joint == n_laws:
        return current, made, False
    # Rounding leaves a speed at the zero; an impulse in the joint removes it exactly.
    if sign == 0:
        residue = _along(modes.directions, joint, state, n)
        for i in range(n):
            state[n + i] -= modes.impulses[joint, i] * residue
    current = _changed(current, joint, sign, modes)
    if current != UNKNOWN:
        current = _release(current, state, drive, laws, modes)
    return current, first * reach, True


@inner
def _passed(current, j, state, terms, z, end, laws, modes):  # type: ignore[no-untyped-def]
    """The sign that a joint has after the event it passed before `end`, and the polynomial of which that is a zero."""
    n, polynomial = modes.directions.shape[1], np.zeros(len(terms))
    if modes.kinds[current, j] & SLIDING:
        # sliding: the speed in its direction falls to zero, and the joint sticks
        towards = modes.signs[current, j]
        if towards * _along(modes.directions, j, end, n) >= 0:
            return _NOT_PASSED, polynomial
        for k in range(len(terms)):
            polynomial[k] = towards * _along(modes.directions, j, terms[k], n)
        return 0.0, polynomial
    excess = _excess(current, j, end, z, laws, modes) if modes.kinds[current, j] & STUCK else 0.0
    if excess == 0:
        return _NOT_PASSED, polynomial
    # stuck: the force that holds it reaches the limit of its law, and the joint slides to that side
    side, held = 1.0 if excess > 0 else -1.0, modes.holding[current]
    for k in range(len(terms)):
        polynomial[k] = -side * _along(held, j, terms[k], 0)
    limit = law_value(j, _along(modes.directions, j, state, 0), side * JUST_MOVING, laws)
    for i in range(2 * n, 3 * n):
        limit -= held[j, i] * z[i]
    polynomial[0] += side * limit
    return side, polynomial


@inner
def _release(current, state, drive, laws, modes):  # type: ignore[no-untyped-def]
    """The mode after all joints were released that their laws cannot hold, the largest excess first."""
    # Each release changes the forces on the joints that still stick: these are computed again before the next one.
    n_laws = len(modes.directions)
    for _ in range(n_laws + 1):
        z, worst, largest = _with_force(current, state, drive, laws, modes), n_laws, 0.0
        for j in range(n_laws):
            if modes.kinds[current, j] & STUCK:
                excess = _excess(current, j, state, z, laws, modes)
                if abs(excess) > abs(largest):
                    worst, largest = j, excess
        if worst == n_laws:
            break
        current = _changed(current, worst, 1.0 if largest > 0 else -1.0, modes)
        if current == UNKNOWN:
            break
    return current


@inner
def _changed(current, joint, sign, modes):  # type: ignore[no-untyped-def]
    """The mode in which one joint has another sign; `UNKNOWN` if it is not in the table."""
    for j in range(modes.wanted.size):
        modes.wanted[j] = sign if j == joint else modes.signs[current, j]
    for m in range(len(modes.signs)):
        same = True
        for j in range(modes.wanted.size):
            same &= modes.signs[m, j] == modes.wanted[j]
        if same:
            return m
    return UNKNOWN


@inner
def _with_force(current, state, drive, laws, modes):  # type: ignore[no-untyped-def]
    """The state, then all generalised forces at it but those that hold joints."""
    n = drive.size
    z = np.empty(3 * n)
    for i in range(2 * n):
        z[i] = state[i]
    for i in range(n):
        z[2 * n + i] = drive[i] + modes.constant[current, i]
    for j in range(len(modes.directions)):
        if modes.kinds[current, j] & VARYING:
            v, sign = _along(modes.directions, j, state, n), modes.signs[current, j]
            if sign != 0:
                v = sign * max(sign * v, JUST_MOVING)
            force = law_value(j, _along(modes.directions, j, state, 0), v, laws)
            for i in range(n):
                z[2 * n + i] -= modes.directions[j, i] * force
    return z


@inner
def _varies(kinds, current):  # type: ignore[no-untyped-def]
    """Whether a law of a mode is not affine."""
    for j in range(kinds.shape[1]):  # noqa: SIM110  numba compiles no generator
        if kinds[current, j] >= VARYING:
            return True
    return False


@inner
def _series(series, z):  # type: ignore[no-untyped-def]
    """Taylor series of the state in time over the reach of its mode, of shape (terms, 2 n)."""
    terms = np.zeros((series.shape[0], series.shape[1]))
    for k in range(len(series)):
        for i in range(series.shape[1]):
            for j in range(z.size):
                terms[k, i] += series[k, i, j] * z[j]
    return terms


@inner
def _at(terms, time):  # type: ignore[no-untyped-def]
    """Value of a Taylor series."""
    value = np.zeros(terms.shape[1])
    for k in range(len(terms) - 1, -1, -1):
        for i in range(value.size):
            value[i] = value[i] * time + terms[k, i]
    return value


@inner
def _along(rows, j, values, first):  # type: ignore[no-untyped-def]
    """Product of a row with numbers from the place `first` on."""
    total = 0.0
    for i in range(min(rows.shape[1], values.size - first)):
        total += rows[j, i] * values[first + i]
    return total


@inner
def _excess(current, joint, state, z, laws, modes):  # type: ignore[no-untyped-def]
    """Excess of the force on a stuck joint over the range that its law can hold, at a state under the forces of z."""
    n, held = modes.directions.shape[1], modes.holding[current]
    needed = _along(held, joint, state, 0)
    for i in range(2 * n, 3 * n):
        needed += held[joint, i] * z[i]
    q = _along(modes.directions, joint, state, 0)
    over = needed - law_value(joint, q, JUST_MOVING, laws)
    under = needed - law_value(joint, q, -JUST_MOVING, laws)
    return max(over, 0.0) + min(under, 0.0)


@inner
def _first_zero(polynomial, end):  # type: ignore[no-untyped-def]
    """Zero of a polynomial that is negative at `end`, by Newton's method within a bracket; 0 if it starts negative."""
    if polynomial[0] <= 0:
        return 0.0
    # Newton's method from the end; a step that leaves the bracket [low, high] of the zero is replaced by bisection.
    low, high, time = 0.0, end, end
    for _ in range(_MOST_TRIALS):
        value = slope = 0.0
        for k in range(polynomial.size - 1, -1, -1):
            slope = slope * time + value
            value = value * time + polynomial[k]
        if value > 0:
            low = time
        else:
            high = time
        change = -value / slope if slope < 0 else low + high
        if abs(change) <= _SHARP * end:
            break
        time = time + change if low < time + change < high else (low + high) / 2
    return time
