"""C function that advances an axis by a time step: friction is set-valued at rest, so joints stick and break loose.

Moreau's time stepping: v+ = v + h M^-1 (B F + c - C v - K x) - M^-1 sum_j d_j l_j, then x+ = x + h v+. The impulse l_j
of a joint with friction lies between h times the forces of its law for motion in either direction; if an impulse in
this range keeps the joint at rest, it is that one. Projected Gauss-Seidel iteration finds the impulses; for one joint,
the first sweep is exact.
"""

from dataclasses import replace

import sympy as sp

from symid.export.c_code import c_code
from symid.export.c_motion import (
    acting_force,
    clock,
    force_parameters,
    lines,
    members,
    renamed,
    smooth_force,
    state_symbols,
    used_parameters,
)
from symid.export.dynamics import VELOCITY, SymbolicDynamics
from symid.export.imperfect_terms import NOW, Memory, acting

_LAW = """\
/* Force of the laws in a joint against its motion. */
static double {name}_law(const {name}_parameters *p, int joint, double joint_q_, double joint_v_{arguments})
{{
{members}
    (void)joint_q_;
    (void)joint_v_;{unused}
    switch (joint) {{
{cases}
    default: return 0.0;
    }}
}}

"""

_FOLLOWED = """\
/* Solution of z(1) = gain - decay z after a time h. */
static double followed(double z, double gain, double decay, double h)
{
    return decay > 0.0 ? z - (gain/decay - z)*expm1(-decay*h) : z + gain*h;
}

"""

_STEP = """\
{followed}{law}void {name}_step(const {name}_parameters *p, double x[{n_state}], {forces}, double h)
{{
    enum {{ n = {n} }};
{members}
    const double inverse[n][n] = {{
{inverse}
    }};
    const double r[n] = {{
{smooth}
    }};
    double v[n];
    for (int i = 0; i < n; i++) {{
        v[i] = x[n + i];
        for (int k = 0; k < n; k++) v[i] += h*inverse[i][k]*r[k];
    }}
{joints}    for (int i = 0; i < n; i++) {{
        x[i] += h*v[i];
        x[n + i] = v[i];
    }}
{after}}}
"""

_JOINTS = """\
    enum {{ joints = {joints}, sweeps = 100 }};
    static const double d[joints][n] = {{
{directions}
    }};
    double response[joints][n], low[joints], high[joints], impulse[joints];
    for (int j = 0; j < joints; j++) {{
        double q = 0.0, speed = 0.0;
        for (int i = 0; i < n; i++) {{
            q += d[j][i]*x[i];
            speed += d[j][i]*x[n + i];
            response[j][i] = 0.0;
            for (int k = 0; k < n; k++) response[j][i] += inverse[i][k]*d[j][k];
        }}
        const double now = {name}_law(p, j, q, speed{beyond}), moving = fabs(speed) + 1e-300;
        low[j] = h*{name}_law(p, j, q, -moving{beyond});
        high[j] = h*{name}_law(p, j, q, moving{beyond});
        if (!has_jump[j] || low[j] > high[j]) low[j] = high[j] = h*now;
        impulse[j] = 0.0;
    }}
    /* Each joint in turn takes the impulse that stops it, limited to what its law can give. */
    for (int sweep = 0, moved = 1; sweep < sweeps && moved; sweep++) {{
        moved = 0;
        for (int j = 0; j < joints; j++) {{
            double speed = 0.0, own = 0.0;
            for (int i = 0; i < n; i++) {{
                speed += d[j][i]*v[i];
                own += d[j][i]*response[j][i];
            }}
            double wanted = impulse[j] + speed/own;
            wanted = wanted < low[j] ? low[j] : wanted > high[j] ? high[j] : wanted;
            const double change = wanted - impulse[j];
            if (fabs(change) > 1e-15*(fabs(low[j]) + fabs(high[j]))) moved = 1;
            for (int i = 0; i < n; i++) v[i] -= response[j][i]*change;
            impulse[j] = wanted;
        }}
    }}
"""


def step_function(dynamics: SymbolicDynamics) -> str:
    """Text of the function `<axis>_step` and of the functions that it calls."""
    n = len(dynamics.bodies)
    smooth = smooth_force(dynamics)
    inverse = dynamics.mass.inv(method="LU")
    used = used_parameters(dynamics, smooth, inverse)
    return _STEP.format(
        followed=_FOLLOWED if dynamics.imperfect.memories else "",
        law=_law(dynamics) if dynamics.laws else "",
        name=dynamics.axis.name,
        forces=force_parameters(dynamics.axis),
        n=n,
        n_state=dynamics.n_states,
        members=lines([*members(used), *clock(dynamics, "h/2.0"), *acting_force(dynamics, _lagging)]),
        inverse=_rows([[c_code(renamed(entry)) for entry in inverse.row(i)] for i in range(n)]),
        smooth="\n".join(f"        {c_code(renamed(entry))}," for entry in smooth),
        joints=_joints(dynamics) if dynamics.laws else "",
        after=_after(dynamics),
    )


def _lagging(place: str, memory: Memory) -> tuple[list[str], str]:
    """Statements for a lagging force, and its mean over the step."""
    before = f"before_{place}_"
    return (
        [f"const double {before} = {memory.symbol};", _follows(memory)],
        f"({before} + {memory.symbol})/2.0",
    )


def _after(dynamics: SymbolicDynamics) -> str:
    """Statements for the states of friction and the time after the step."""
    (_, v), statements = state_symbols(len(dynamics.bodies)), []
    for joint in dynamics.laws:
        now = {VELOCITY: (joint.direction @ v)[0]}
        statements += [
            _follows(replace(m, gain=m.gain.xreplace(now), decay=m.decay.xreplace(now)))
            for m in joint.memories
        ]
    if dynamics.imperfect.clock:
        statements.append(f"{dynamics.imperfect.clock} += h;")
    return "".join(f"    {line}\n" for line in statements)


def _follows(memory: Memory) -> str:
    return f"{memory.symbol} = followed({memory.symbol}, {c_code(memory.gain)}, {c_code(memory.decay)}, h);"


def _law(dynamics: SymbolicDynamics) -> str:
    forces = [joint.force for joint in dynamics.laws]
    cases = [f"    case {j}: return {c_code(renamed(force))};" for j, force in enumerate(forces)]
    used = used_parameters(dynamics, sp.Matrix(forces))
    arguments = "".join(f", {kind}" for kind, _ in _beyond(dynamics))
    unused = "".join(f"\n    (void){name};" for _, name in _beyond(dynamics))
    return _LAW.format(
        name=dynamics.axis.name,
        members=lines(members(used)),
        cases="\n".join(cases),
        arguments=arguments,
        unused=unused,
    )


def _beyond(dynamics: SymbolicDynamics) -> list[tuple[str, str]]:
    """Inputs of laws other than the motion, as parameters of a C function and as arguments."""
    symbols = set().union(*(joint.force.free_symbols for joint in dynamics.laws))
    statements = []
    if any(memory.symbol in symbols for joint in dynamics.laws for memory in joint.memories):
        statements.append(("const double x[]", "x"))
    inputs = (*map(acting, dynamics.axis.drives), NOW)
    return [*statements, *((f"double {s}", str(s)) for s in inputs if s in symbols)]


def _joints(dynamics: SymbolicDynamics) -> str:
    rows = [[c_code(share) for share in joint.direction] for joint in dynamics.laws]
    jumps = ", ".join(str(int(joint.jumps)) for joint in dynamics.laws)
    flags = f"    static const int has_jump[] = {{{jumps}}};\n"
    text = _JOINTS.format(
        name=dynamics.axis.name,
        joints=len(rows),
        directions=_rows(rows),
        beyond="".join(f", {name}" for _, name in _beyond(dynamics)),
    )
    if any(joint.direction.free_symbols for joint in dynamics.laws):
        text = text.replace("static const double d", "const double d")
    return flags + text


def _rows(rows: list[list[str]]) -> str:
    return "\n".join(f"        {{{', '.join(row)}}}," for row in rows)
