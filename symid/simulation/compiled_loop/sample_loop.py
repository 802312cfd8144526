"""Samples of a loop, compiled; imported when a simulation runs, as Numba takes 0.3 s.

The arguments `law`, `channels`, `laws`, `mode`, `modes` and `record` are records of `loop`, `loop_numbers` and
`sensor_channel`.
"""

import numpy as np

from symid.jit import inner, jitted, part
from symid.simulation.compiled_loop.evaluation import (
    built_up,
    law_value,
    numbers_of_mode,
    program_value,
    slide,
)
from symid.simulation.compiled_loop.products import copy, dot, product
from symid.simulation.compiled_loop.stick_slip import UNKNOWN, acceleration, pass_events
from symid.simulation.plants.plant import JUST_MOVING

MADE, UNKNOWN_MODE, RUNAWAY, REFUSED = range(4)
"""Why `advance` returns: all samples are made, a mode is not in the table, the axis runs away, or `ask` failed."""
_LARGEST = 1e150
"""Displacement or speed at which the axis runs away."""


@jitted
def advance(begin, end, ask, law, given, channels, laws, modes, current, record, memory, after):  # type: ignore[no-untyped-def]
    """Advance from sample `begin` to `end`; return how many samples were made, and why no more.

    `current[0]` is the stick-slip mode, as its place in the table `modes`; of one that is not there the signs are in
    `modes.events.wanted`. Where a force exceeds the limit of its linear law, `ask(k)` has the controllers write the
    forces to the record and their state to `after`; it returns 0, or 1 to stop. `memory`, the state of the controllers,
    and `laws.memories` are left as after the last sample made.
    """
    if begin == 0 and modes.is_accelerated:
        rest, rates = np.zeros(len(modes.drives)), record.accelerations[0]
        known = acceleration(current[0], record.states[0], rest, laws, modes.events, rates)
        if known == UNKNOWN:
            return 0, UNKNOWN_MODE
        current[0] = known
    k = begin
    while True:
        mode = numbers_of_mode(modes, current[0])
        _limit(record.states[k], laws, mode)
        made, goes_on = _in_mode(k, end, ask, law, given, channels, laws, mode, record, memory, after)
        k += made
        if k == end or not goes_on:
            return k - begin, MADE if k == end else REFUSED
        known, why = _events(k, current[0], channels, laws, modes, mode.is_accelerated, record)
        if why != MADE:
            return k - begin, why
        current[0] = known
        copy(after, memory)
        k += 1
        if k == end:
            return k - begin, MADE


@part
def _events(k, current, channels, laws, modes, is_accelerated, record):  # type: ignore[no-untyped-def]
    """Make sample k with its events under the recorded forces; return the mode after it, and why it is not made."""
    states, accelerations, forces, between = record
    n = len(modes.drives)
    state, drive, rates = np.zeros(2 * n), np.zeros(n), np.zeros(n)
    copy(states[k], state)
    product(modes.drives, forces[k], drive)
    if laws.any_timed:
        _set_moment(k, forces, channels, laws)
    for piece in range(modes.durations.size):
        current = pass_events(current, state, drive, modes.durations[piece], laws, modes.events)
        if current != UNKNOWN and is_accelerated:
            current = acceleration(current, state, drive, laws, modes.events, rates)
        if current == UNKNOWN:
            return current, UNKNOWN_MODE
        for i in range(2 * n):
            if not abs(state[i]) < _LARGEST:
                return current, RUNAWAY
        for i in range(n):
            states[k + 1, i], states[k + 1, n + i], accelerations[k + 1, i] = state[i], state[n + i], rates[i]
        for i in range(len(between)):
            if channels.pieces[i] == piece:
                between[i, k] = _exact(channels.between, i, k + 1, states, accelerations)
    _remember(state, laws)
    return current, MADE


@part
def _in_mode(begin, end, ask, law, given, channels, laws, mode, record, memory, after):  # type: ignore[no-untyped-def]
    """Advance as long as the stick-slip mode holds; return how many samples were made, and whether to go on.

    The force that a controller sends passes the gains and limits of its drive, then lags and delays, which are linear.
    Varying laws act over each piece of a sample with their force at its middle.
    """
    # Numba counts references at each access to a field, and at each call that is given a record: the fields used by all
    # samples are read once, here, and the sensors are read here (a function for them takes 40 % longer in all).
    (states, accelerations, forces, between), (law_after, law_sent, law_acting, limits) = record, law
    references, noise, steps, misread = channels.references, channels.noise, channels.steps, channels.misread
    readings, rows, ages, places = channels.readings, channels.rows, channels.ages, channels.places
    begins, ends, held, n_varying, rates = mode.begins, mode.ends, mode.limits, mode.varying.size, mode.rates
    n_state, n_drives, n_memory = states.shape[1], given.shape[1], memory.size
    n_known = law_after.shape[1] - n_drives
    n_remembered, is_timed, is_accelerated = laws.reaches.size, laws.any_timed, mode.is_accelerated
    inputs, out, z = np.zeros(law_after.shape[1]), np.zeros(ends.shape[1]), np.zeros(ends.shape[2])
    copy(states[begin], z)
    z[z.size - 1] = 1.0
    for k in range(begin, end):
        copy(memory, inputs)
        for i in range(references.shape[1]):
            inputs[n_memory + i] = references[k, i]
        # Readings of sample k depend on the motion up to it, and forces act after it: there is no algebraic loop.
        for i in range(ages.size):
            value = _taken(k - 1 - ages[i], places[i], rows, i, states, accelerations, between)
            if misread[i] >= 0:
                laws.arguments[0] = value
                value = program_value(misread[i], laws)
            value += noise[k, i]
            readings[i] = steps[i] * np.rint(value / steps[i]) if steps[i] > 0 else value
            inputs[n_known - ages.size + i] = readings[i]
        asked = False
        for i in range(n_drives):
            inputs[n_known + i] = 0.0
        for i in range(n_drives):
            forces[k, i] = given[k, i] + dot(law_sent, i, inputs)
            asked |= not abs(forces[k, i]) <= limits[i]
        if asked and ask(k):
            return k - begin, False
        if not asked:
            for i in range(n_drives):
                inputs[n_known + i] = _through_nonlinearities(i, forces[k, i], laws)
            for i in range(n_drives):
                forces[k, i] = dot(law_acting, i, inputs)
            product(law_after, inputs, after)
        # Where the mode does not hold over the whole sample, events happen in it.
        for i in range(n_drives):
            z[n_state + i] = forces[k, i]
        if is_timed:
            _set_moment(k, forces, channels, laws)
            _limit(z, laws, mode)
        for piece in range(len(ends)):
            if n_varying:
                is_smooth = _moves_under_varying_laws(piece, z, out, laws, mode)
            else:
                is_smooth = _moves(begins[piece], ends[piece], held, z, out)
            if not is_smooth:
                return k - begin, True
            for i in range(n_state):
                z[i] = states[k + 1, i] = out[i]
            if is_accelerated:
                if n_varying:
                    _act(z, z, laws, mode)
                product(rates, z, accelerations[k + 1])
            for i in range(len(between)):
                if channels.pieces[i] == piece:
                    between[i, k] = _exact(channels.between, i, k + 1, states, accelerations)
        if n_remembered:
            _remember(z, laws)
        copy(after, memory)
    return end - begin, True


@inner
def _remember(state, laws):  # type: ignore[no-untyped-def]
    """Update the memories of laws at the end of a sample."""
    for i in range(laws.reaches.size):
        q = slide(laws.slides, i, state)
        laws.memories[i, 1], laws.memories[i, 0] = (
            built_up(laws.memories[i, 1], q - laws.memories[i, 0], laws.reaches[i]),
            q,
        )


@inner
def _set_moment(k, forces, channels, laws):  # type: ignore[no-untyped-def]
    """Set load, time, and forces of the drives on which laws depend."""
    sizes = 0.0
    for i in range(forces.shape[1]):
        sizes += abs(forces[k, i])
        laws.arguments[5 + i] = forces[k, i]
    laws.arguments[2] = sizes if forces.shape[1] > 1 else forces[k, 0]
    laws.arguments[3] = (k + 0.5) * channels.period


@inner
def _through_nonlinearities(drive, force, laws):  # type: ignore[no-untyped-def]
    """Force after the gains and limits of a drive."""
    for program in range(laws.nonlinearities[drive], laws.nonlinearities[drive + 1]):
        laws.arguments[2] = force
        force = program_value(program, laws)
    return force


@inner
def _taken(interval, place, rows, i, states, accelerations, between):  # type: ignore[no-untyped-def]
    """Exact value that a sensor takes in an interval between samples; before the first one, the value at the start."""
    if place >= 0 and interval >= 0:
        return between[place, interval]
    return _exact(rows, i, max(interval + 1, 0), states, accelerations)


@inner
def _exact(rows, i, k, states, accelerations):  # type: ignore[no-untyped-def]
    """Exact reading of a sensor at a sample."""
    value, n = 0.0, states.shape[1]
    for j in range(n):
        value += rows[i, j] * states[k, j]
    for j in range(n // 2):
        value += rows[i, n + j] * accelerations[k, j]
    return value


@inner
def _moves(begin, end, held, z, out):  # type: ignore[no-untyped-def]
    """Write the motion over a piece of a sample to `out`; return whether the stick-slip mode held."""
    if len(held):
        product(begin, z, out)
        if not _holds(out, len(begin) - len(held), held):
            return False
    product(end, z, out)
    return _goes_on(out, len(begin) - len(held), held)


@inner
def _moves_under_varying_laws(piece, z, out, laws, mode):  # type: ignore[no-untyped-def]
    """As `_moves` with varying laws, whose force at the middle of the piece acts (exponential midpoint rule)."""
    n_state = 2 * laws.directions.shape[1]
    _act(z, z, laws, mode)
    product(mode.begins[piece], z, out)
    if not _holds(out, n_state, mode.limits):
        return False
    _act(out, z, laws, mode)
    product(mode.ends[piece], z, out)
    return _goes_on(out, n_state, mode.limits)


@inner
def _holds(out, first, limits):  # type: ignore[no-untyped-def]
    for i in range(len(limits)):  # noqa: SIM110  numba compiles no generator
        if not limits[i, 0] <= out[first + i] <= limits[i, 1]:
            return False
    return True


@inner
def _goes_on(out, n_state, limits):  # type: ignore[no-untyped-def]
    """Whether stuck joints hold, sliding ones keep their direction, and the axis does not run away."""
    for i in range(n_state):
        if not abs(out[i]) < _LARGEST:
            return False
    for i in range(n_state + len(limits), out.size):
        if out[i] < 0:
            return False
    return _holds(out, n_state, limits)


@inner
def _limit(state, laws, mode):  # type: ignore[no-untyped-def]
    """Set the forces that stuck joints can hold at a state."""
    for i in range(mode.stuck.size):
        j = mode.stuck[i]
        q = slide(laws.directions, j, state)
        mode.limits[i, 0] = law_value(j, q, -JUST_MOVING, laws)
        mode.limits[i, 1] = law_value(j, q, JUST_MOVING, laws)


@inner
def _act(state, z, laws, mode):  # type: ignore[no-untyped-def]
    """Write the forces that varying laws have at a state to z."""
    n, first = laws.directions.shape[1], z.size - 1 - mode.varying.size
    for i in range(mode.varying.size):
        j, sign, v = mode.varying[i], mode.signs[i], 0.0
        for b in range(n):
            v += laws.directions[j, b] * state[n + b]
        if sign != 0:
            v = sign * max(sign * v, JUST_MOVING)
        z[first + i] = law_value(j, slide(laws.directions, j, state), v, laws)
