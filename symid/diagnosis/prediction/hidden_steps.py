"""The steps of a hidden motion, compiled."""

import numpy as np

from symid.jit import compiled
from symid.simulation.evaluation import evaluate


@compiled
def _at(j, place, speed, course, operations, operands, ends, arguments, stack):  # type: ignore[no-untyped-def]
    """Value of the program of a law where its joint is; load and Dahl's state stand in its arguments already."""
    arguments[j, 0], arguments[j, 1], arguments[j, 2] = place, speed, course
    begin, end = ends[j], ends[j + 1]
    return evaluate(operations[begin:end], operands[begin:end], arguments[j], stack)


@compiled
def _built_up(z, path, reach):  # type: ignore[no-untyped-def]
    """Dahl's state after a path, exact where the motion on it is monotone."""
    decay = np.exp(-abs(path) / reach)
    return 1 - (1 - z) * decay if path >= 0 else (1 + z) * decay - 1


@compiled
def steps(  # type: ignore[no-untyped-def]  # compiled for arrays
    transition,
    inputs,
    first,
    pushed,
    q,
    v,
    courses,
    load,
    by_state,
    joints,
    dry,
    operations,
    operands,
    ends,
    arguments,
    stack,
    order,
):
    """States of shape (n,) and forces of shape (n_laws, n) in the order of the points.

    Smooth forces by Heun's rule, dry friction held over each step.

    Parameters
    ----------
    transition : array of shape (2, 2)
        Of the hidden coordinate and its rate over a step without forces.
    inputs : array of shape (2, 2)
        What a force that is held over the step does, and one that rises to 1 over it.
    first : array of shape (2,)
        What a force at the beginning of the step does that falls to 0 over it.
    pushed : array of shape (n_points,)
        All other forces.
    q, v : arrays of shape (n_points,)
        Driven position and its velocity.
    courses : array of shape (n_laws, n_points)
        Factors that follow the time.
    load : array of shape (n_points,)
        Drive force without the hidden coordinate and the laws.
    by_state : array of shape (2,)
        Shares of the hidden coordinate and its rate in the drive force.
    joints : array of shape (5, n_laws)
        Displacement for a unit of the driven position and for one of the hidden coordinate, shares of the force in that
        of the hidden coordinate and in the drive's, reach of Dahl's state.
    dry : bool array of shape (n_laws,)
        Which are dry friction.
    operations, operands, ends : arrays
        Programs of the laws, one behind the other; where each ends, from 0 on.
    arguments : array of shape (n_laws, 5 + n_values)
        Of the programs; the first five are written by the steps.
    stack : array
        Space for the programs.
    order : int array of shape (n,)
        Points, one after the other.
    """
    n_laws = dry.size
    states, forces = np.zeros(order.size), np.zeros((n_laws, order.size))
    before = np.zeros(n_laws)
    x, rate, force, before_drive = 0.0, 0.0, 0.0, 0.0
    for i in range(order.size):
        k = order[i]
        if i:
            last = order[i - 1]
            now, then = pushed[last], pushed[(last + 1) % pushed.size]
            given, quickened = first[0] * now + inputs[1, 0] * then, first[1] * now + inputs[1, 1] * then
            ahead = transition[0, 0] * x + transition[0, 1] * rate + given - inputs[0, 0] * force
            rate = transition[1, 0] * x + transition[1, 1] * rate + quickened - inputs[0, 1] * force
            x = ahead
        drive = load[k] + by_state[0] * x + by_state[1] * rate
        if i:
            for j in range(n_laws):
                drive += joints[3, j] * forces[j, i - 1]
        # dry friction acts over the step that ends here, smooth forces act at its end
        midway = 0.5 * (drive + before_drive) if i else drive
        before_drive = drive
        total = 0.0
        for j in range(n_laws):
            arguments[j, 4] = midway if dry[j] else drive
            if dry[j]:
                continue
            place, speed = joints[0, j] * q[k] + joints[1, j] * x, joints[0, j] * v[k] + joints[1, j] * rate
            if np.isfinite(joints[4, j]):
                arguments[j, 3] = _built_up(arguments[j, 3], place - before[j], joints[4, j])
                before[j] = place
            own = _at(j, place, speed, courses[j, k], operations, operands, ends, arguments, stack)
            forces[j, i] = own
            total += joints[2, j] * own
        x -= inputs[1, 0] * (total - force)
        rate -= inputs[1, 1] * (total - force)
        for j in range(n_laws):
            if not dry[j]:
                continue
            place, speed = joints[0, j] * q[k] + joints[1, j] * x, joints[0, j] * v[k] + joints[1, j] * rate
            level = _at(j, place, speed, courses[j, k], operations, operands, ends, arguments, stack)
            # the force that would stop the joint within the step, or the level of the law if that is smaller
            own = speed / (joints[1, j] * inputs[0, 1] * joints[2, j])
            own = level if own > level else -level if own < -level else own
            forces[j, i] = own
            x -= inputs[0, 0] * joints[2, j] * own
            rate -= inputs[0, 1] * joints[2, j] * own
        force = total
        states[i] = x
    return states, forces
