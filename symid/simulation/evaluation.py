"""Values of postfix programs and of Dahl's state, compiled; import it where it runs, as Numba takes 0.3 s to load."""

import numpy as np

from symid.jit import compiled
from symid.simulation.postfix import ADD, ARGUMENT, CONSTANT, FUNCTION, MAXIMUM, MINIMUM, MULTIPLY, POWER


@compiled
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
        elif operation == ADD:
            top -= 1
            stack[top] += stack[top + 1]
        elif operation == MULTIPLY:
            top -= 1
            stack[top] *= stack[top + 1]
        elif operation == POWER:
            top -= 1
            stack[top] = stack[top] ** stack[top + 1]
        elif operation == MINIMUM:
            top -= 1
            stack[top] = min(stack[top], stack[top + 1])
        elif operation == MAXIMUM:
            top -= 1
            stack[top] = max(stack[top], stack[top + 1])
        else:
            stack[top] = _function(operation - FUNCTION, stack[top])
    return stack[0]


@compiled
def built_up(z, path, reach):  # type: ignore[no-untyped-def]  # compiled for numbers
    """Dahl's state after a path; exact along a motion that does not reverse."""
    side = 1.0 if path >= 0 else -1.0
    return side - (side - z) * np.exp(-abs(path) / reach)


@compiled
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
