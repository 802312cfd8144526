"""Values of postfix programs and of laws in the records of a loop, compiled; import it late: Numba loads for 0.3 s."""

import numpy as np

from symid.jit import inner, jitted
from symid.simulation.loops.loop_numbers import ModeNumbers
from symid.simulation.plants.postfix import ADD, ARGUMENT, CONSTANT, FUNCTION, MINIMUM, MULTIPLY, POWER


@jitted
def evaluate(operations, operands, arguments, stack):  # type: ignore[no-untyped-def]  # compiled for arrays
    """Value of a program; `stack` is an array of at least its depth."""
    # a stack machine: operands are pushed, operations replace the topmost values by their result
    top = -1
    for i in range(operations.size):
        operation = operations[i]
        if operation == CONSTANT:
            top += 1
            stack[top] = operands[i]
        elif operation == ARGUMENT:
            top += 1
            stack[top] = arguments[int(operands[i])]
        elif operation >= FUNCTION:
            stack[top] = _function(operation - FUNCTION, stack[top])
        else:
            top -= 1
            stack[top] = _joined(operation, stack[top], stack[top + 1])
    return stack[0]


@inner
def _joined(operation, a, b):  # type: ignore[no-untyped-def]  # compiled for numbers
    if operation == ADD:
        return a + b
    if operation == MULTIPLY:
        return a * b
    if operation == POWER:
        # `pow` takes many times as long for squares and quotients, and more cases here slow down all operations
        return a * a if b == 2.0 else 1.0 / a if b == -1.0 else a**b
    return min(a, b) if operation == MINIMUM else max(a, b)


@jitted
def built_up(z, path, reach):  # type: ignore[no-untyped-def]  # compiled for numbers
    """Dahl's state after a path; exact along a motion that does not reverse."""
    side = 1.0 if path >= 0 else -1.0
    return side - (side - z) * np.exp(-abs(path) / reach)


@inner
def _function(which, x):  # type: ignore[no-untyped-def]  # compiled for numbers
    if which == 0:
        return abs(x)
    if which == 1:
        return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0
    if which == 2:
        return 1.0 if x > 0.0 else 0.0
    if which == 3:
        return np.sin(x)
    if which == 4:
        return np.cos(x)
    return np.exp(x)


@inner
def slide(directions, j, state):  # type: ignore[no-untyped-def]  # compiled for arrays
    """Displacement in a joint."""
    q = 0.0
    for b in range(directions.shape[1]):
        q += directions[j, b] * state[b]
    return q


@inner
def law_value(j, q, v, laws):  # type: ignore[no-untyped-def]
    """Force of all laws of a joint."""
    total = 0.0
    for term in range(laws.terms[j], laws.terms[j + 1]):
        laws.arguments[0], laws.arguments[1] = q, v
        if laws.remembers[term] >= 0:
            m = laws.remembers[term]
            laws.arguments[4] = built_up(laws.memories[m, 1], q - laws.memories[m, 0], laws.reaches[m])
        total += laws.parameters[term] * program_value(term, laws)
    return total


@inner
def program_value(program, laws):  # type: ignore[no-untyped-def]  # compiled for arrays
    """Value of a formula for the arguments that are set."""
    begin, end = laws.ends[program], laws.ends[program + 1]
    return evaluate(laws.operations[begin:end], laws.operands[begin:end], laws.arguments, laws.stack)


@inner
def numbers_of_mode(modes, m):  # type: ignore[no-untyped-def]  # compiled for arrays
    """Numbers of mode m of a table, as `ModeNumbers`; they share its memory."""
    n_stuck, n_sliding, n_varying = modes.counts[m]
    n, n_drives = modes.drives.shape
    pieces, width = modes.durations.size, 2 * n + n_drives + n_varying + 1
    a = modes.places[m]
    b = a + pieces * (2 * n + n_stuck) * width
    c = b + pieces * (2 * n + n_stuck + n_sliding) * width
    d = c + n * width
    e = d + n_varying
    f = modes.law_places[m]
    numbers = modes.numbers
    return ModeNumbers(
        numbers[a:b].reshape(pieces, 2 * n + n_stuck, width),
        numbers[b:c].reshape(pieces, 2 * n + n_stuck + n_sliding, width),
        numbers[c:d].reshape(n, width),
        modes.law_numbers[f : f + n_stuck],
        modes.law_numbers[f + n_stuck : f + n_stuck + n_varying],
        numbers[d:e],
        numbers[e : e + 2 * n_stuck].reshape(n_stuck, 2),
        modes.is_accelerated,
    )
