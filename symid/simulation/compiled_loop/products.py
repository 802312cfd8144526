"""Products of small matrices, compiled."""

import numpy as np

from symid.jit import inner, jitted


@jitted
def recursion(matrix, start, inputs):  # type: ignore[no-untyped-def]
    """States z[k + 1] = matrix @ z[k] + inputs[k] from z[0] = start; shape (n + 1, m)."""
    states = np.zeros((len(inputs) + 1, start.size))
    states[0] = start
    for k in range(len(inputs)):
        for i in range(start.size):
            states[k + 1, i] = dot(matrix, i, states[k]) + inputs[k, i]
    return states


@inner
def dot(rows, i, values):  # type: ignore[no-untyped-def]
    """Product of row i of a matrix with a vector."""
    total = 0.0
    for j in range(values.size):
        total += rows[i, j] * values[j]
    return total


@inner
def product(matrix, z, out):  # type: ignore[no-untyped-def]
    """Write the product of a matrix with a vector to `out`."""
    for i in range(len(matrix)):
        out[i] = dot(matrix, i, z)


@inner
def copy(values, into):  # type: ignore[no-untyped-def]
    """Copy a vector."""
    for i in range(values.size):
        into[i] = values[i]
