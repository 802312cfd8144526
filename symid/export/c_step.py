"""C function that advances an axis by a time step: friction is set-valued at rest, so joints stick and break loose.

Moreau's time stepping: v+ = v + h M^-1 (B F + c - C v - K x) - M^-1 sum_j d_j l_j, each impulse l_j of a joint with
friction lying within h times what its law can give, and being what keeps the joint at rest if that is enough. The
impulses are found by projected Gauss-Seidel iteration, exact in one sweep for one joint; then x+ = x + h v+.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from symid.export.c_code import c_code
from symid.export.dynamics import SymbolicDynamics

_LAW = """\
/* Force of the laws in a joint against its motion. */
static double {name}_law(const {name}_parameters *p, int joint, double joint_q_, double joint_v_)
{{
{members}
    (void)joint_q_;
    (void)joint_v_;
    switch (joint) {{
{cases}
    default: return 0.0;
    }}
}}

"""

_STEP = """\
{law}void {name}_step(const {name}_parameters *p, double x[{n_state}], double {force}, double h)
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
}}
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
        const double now = {name}_law(p, j, q, speed), moving = fabs(speed) + 1e-300;
        low[j] = h*{name}_law(p, j, q, -moving);
        high[j] = h*{name}_law(p, j, q, moving);
        if (!has_jump[j] || low[j] > high[j]) low[j] = high[j] = h*now;
        impulse[j] = 0.0;
    }}
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


def step_function(
    dynamics: SymbolicDynamics,
    members: Callable[[list[str]], str],
    renamed: Callable[[sp.Expr], sp.Expr],
    force: str,
) -> str:
    """Text of the function `<axis>_step`.

    Parameters
    ----------
    dynamics : SymbolicDynamics
        What moves.
    members : callable
        Statements that read parameters.
    renamed : callable
        An expression with names that C leaves free.
    force : str
        Name of the drive's force.
    """
    n, name = len(dynamics.bodies), dynamics.axis.name
    x = sp.Matrix([sp.Symbol(f"x[{i}]") for i in range(n)])
    v = sp.Matrix([sp.Symbol(f"x[{n + i}]") for i in range(n)])
    drive = dynamics.drive * sp.Symbol(dynamics.axis.drive.signal)
    smooth = drive + dynamics.constant - dynamics.damping * v - dynamics.stiffness * x
    inverse = dynamics.mass.inv(method="LU")
    used = _parameters(dynamics, smooth, inverse)
    return _STEP.format(
        law=_law(dynamics, members, renamed) if dynamics.joints else "",
        name=name,
        force=force,
        n=n,
        n_state=2 * n,
        members=members(used),
        inverse=_rows([[c_code(renamed(entry)) for entry in inverse.row(i)] for i in range(n)]),
        smooth="\n".join(f"        {c_code(renamed(entry))}," for entry in smooth),
        joints=_joints(dynamics) if dynamics.joints else "",
    )


def _law(
    dynamics: SymbolicDynamics, members: Callable[[list[str]], str], renamed: Callable[[sp.Expr], sp.Expr]
) -> str:
    forces = [joint.force for joint in dynamics.joints]
    cases = [f"    case {j}: return {c_code(renamed(force))};" for j, force in enumerate(forces)]
    used = _parameters(dynamics, sp.Matrix(forces))
    return _LAW.format(name=dynamics.axis.name, members=members(used), cases="\n".join(cases))


def _joints(dynamics: SymbolicDynamics) -> str:
    rows = [
        [c_code(joint.displacement.get(b, sp.S.Zero)) for b in dynamics.bodies] for joint in dynamics.joints
    ]
    jumps = ", ".join(str(int(joint.jumps)) for joint in dynamics.joints)
    flags = f"    static const int has_jump[] = {{{jumps}}};\n"
    text = _JOINTS.format(name=dynamics.axis.name, joints=len(rows), directions=_rows(rows))
    if any(joint.free_symbols for j in dynamics.joints for joint in j.displacement.values()):
        text = text.replace("static const double d", "const double d")
    return flags + text


def _rows(rows: list[list[str]]) -> str:
    return "\n".join(f"        {{{', '.join(row)}}}," for row in rows)


def _parameters(dynamics: SymbolicDynamics, *matrices: sp.Matrix) -> list[str]:
    symbols = set().union(*(matrix.free_symbols for matrix in matrices))
    return [name for name in dynamics.axis.physical_parameters if sp.Symbol(name) in symbols]
