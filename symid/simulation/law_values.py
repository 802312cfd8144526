"""Values of laws and of other formulas in a simulation, compiled."""

from symid.jit import inner
from symid.simulation.evaluation import built_up, evaluate


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
