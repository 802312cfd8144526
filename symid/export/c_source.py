"""C99 source of an axis: its forward dynamics, and regressor, output and minimal parameters of its minimal model.

Plain functions of numbers and arrays, without allocation and static state, which need the mathematical library only.
"""

import math
import re
import textwrap
from collections.abc import Mapping, Sequence

import sympy as sp

from symid.axis import Axis, axis_of
from symid.codegen.generation import minimal_parameter_code, model_signals, symbol_names
from symid.errors import SettingError
from symid.export.c_code import assignments, c_code, c_name
from symid.export.c_delays import SHORTEST_STEP, delay_fields
from symid.export.c_motion import (
    derivative,
    force_parameters,
    lines,
    members,
    readings,
    renamed,
    sent_forces,
    settled_lags,
)
from symid.export.c_step import step_function
from symid.export.c_templates import (
    C_SOURCE,
    FEEDFORWARD_HEADER,
    FEEDFORWARD_SOURCE,
    HEADER,
    REGRESSOR_HEADER,
    REGRESSOR_SIZES,
    REGRESSOR_SOURCE,
    SETTLE_HEADER,
    SETTLE_SOURCE,
)
from symid.export.dynamics import SymbolicDynamics, symbolic_dynamics
from symid.export.exported import Exported, losses_of_signals, require_physical
from symid.export.feedforward import feedforward
from symid.simulation import plant_of
from symid.symbolic import DerivedModel

_LONGEST, _STEPS_A_RADIAN = 2e-5, 100  # s; steps in a radian of the fastest motion

_REST = (
    "Friction at rest: the derivative takes sign(0) = 0 and seeks no event, so that a fixed-step solver chatters "
    "around rest; use the step function, in which joints stick, or compile with -DSYMID_REST_SPEED=1e-4."
)


def c_source(model: DerivedModel | Axis, values: Mapping[str, float], header: str | None = None) -> Exported:
    """Source and header of an axis in C99.

    Parameters
    ----------
    model : DerivedModel or Axis
        Axis and sensors with their minimal model; an axis alone is exported without a regressor.
    values : mapping of str to float
        Physical parameters, SI: the constant `<axis>_values` of the source.
    header : str, optional
        File name of the header without suffix; by default that of the axis.

    Raises
    ------
    SettingError
        If no machine has the values, or a part of the axis cannot be expressed.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.symbolic import derive
    >>> exported = c_source(derive(load_axis("rigid_1m")), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> sorted(exported.files), "W[0][0] = q_d2;" in exported.text
    (['.c', '.h'], True)
    """
    axis = axis_of(model)
    require_physical(axis, values)
    dynamics = symbolic_dynamics(axis)
    parameters = set(map(sp.Symbol, axis.physical_parameters))
    losses = (
        *((_REST,) if any(joint.jumps for joint in dynamics.laws) else ()),
        *losses_of_signals(axis),
        *(f"{s.signal}: the noise of the reading is left out." for s in axis.sensors if s.noise),
        *(
            f"{signal}: it reads a body without mass, by the stiffnesses in {axis.name}_values."
            for signal, reading in dynamics.sensors.items()
            if reading.order is not None and reading.row.free_symbols & parameters
        ),
        *(
            f"{signal}: it is read at the parameters in {axis.name}_values."
            for signal, reading in dynamics.sensors.items()
            if (reading.motion.free_symbols - reading.row.free_symbols) & parameters
        ),
    )
    written = () if isinstance(model, Axis) else model.minimal.written
    words = {
        **_fields(axis, dynamics, values, [*written, *(f"Lost: {loss}" for loss in losses)]),
        **_regressor_fields(model),
        "header": f"{header or axis.name}.h",
    }
    texts = {".c": C_SOURCE.format(**words), ".h": HEADER.format(**words)}
    return Exported({suffix: _of_any_precision(text) for suffix, text in texts.items()}, losses)


def _of_any_precision(text: str) -> str:
    """C code whose numbers have the type that its header defines.

    >>> _of_any_precision("double y = (double)1;")
    'SYMID_REAL y = (SYMID_REAL)1;'
    """
    return re.sub(r"\bdouble\b(?! /\*)", "SYMID_REAL", text)


def internal_step(axis: Axis, values: Mapping[str, float]) -> float:
    """Step of an accurate integration, s: a hundredth of a radian of the fastest mode, 20 us at most."""
    fastest = 2 * math.pi * plant_of(axis, values).highest_mode  # rad/s
    return float(f"{min(_LONGEST, 1 / (_STEPS_A_RADIAN * max(fastest, 1.0))):.2g}")


def _fields(
    axis: Axis, dynamics: SymbolicDynamics, values: Mapping[str, float], texts: Sequence[str]
) -> dict[str, object]:
    """Fields of the templates, except those of the regressor."""
    parameters = axis.physical_parameters
    notes = [part for text in texts for part in textwrap.wrap(text, 105, subsequent_indent="    ")]
    return {
        "name": axis.name,
        "guard": f"SYMID_{axis.name.upper()}_H",
        "notes": "\n".join(f" * {line}" for line in notes),
        "bodies": len(dynamics.bodies),
        "n_state": dynamics.n_states,
        "memory": "  /* and what imperfections remember */" * bool(dynamics.imperfect.states),
        "state": ", ".join(
            [*(f"{kind}_{b}" for kind in "xv" for b in dynamics.bodies), *dynamics.imperfect.states]
        ),
        "members": lines(f"double {c_name(n)};  /* {unit or '1'} */" for n, unit in parameters.items()),
        "values": lines(f".{c_name(n)} = {float(values[n])!r}," for n in parameters),
        "constants": "".join(f"static const double {n} = {v!r};\n" for n, v in dynamics.constants.items())
        + ("\n" if dynamics.constants else ""),
        "force": sent_forces(axis),
        "forces": force_parameters(axis),
        "sensors": ", ".join(dynamics.sensors),
        "n_sensors": len(dynamics.sensors),
        "derivative": derivative(dynamics),
        "step": step_function(dynamics),
        "readings": readings(dynamics),
        **_feedforward_fields(axis),
        **_settle_fields(dynamics),
        **delay_fields(dynamics, min(SHORTEST_STEP, internal_step(axis, values))),
    }


def _regressor_fields(model: DerivedModel | Axis) -> dict[str, str]:
    """Fields that a minimal model adds to header and source; empty for an axis alone."""
    if isinstance(model, Axis):
        return dict.fromkeys(("measured_line", "regressor_sizes", "regressor_header", "regressor_source"), "")
    minimal, signals = model.minimal, model_signals(model)
    words = {
        "name": model.axis.name,
        "n_signals": len(signals),
        "signals": ", ".join(signals),
        "equations": len(minimal.output),
        "n_minimal": len(minimal.parameters),
        "minimal": ", ".join(p.name for p in minimal.parameters),
        "regressor": _of_signals(
            {f"W[{i}][{j}]": entry for i, row in enumerate(minimal.regressor) for j, entry in enumerate(row)},
            signals,
        ),
        "output": _of_signals({f"y[{i}]": entry for i, entry in enumerate(minimal.output)}, signals),
        "forward": _forward(model),
    }
    return {
        "measured_line": f"Measured: {', '.join(model.measured)}.",
        "regressor_sizes": REGRESSOR_SIZES.format(**words),
        "regressor_header": REGRESSOR_HEADER.format(**words),
        "regressor_source": REGRESSOR_SOURCE.format(**words),
    }


def _feedforward_fields(axis: Axis) -> dict[str, str]:
    """Fields that a feed-forward adds to header and source; empty if the axis has none."""
    try:
        force = feedforward(axis).force
    except SettingError:
        return {"feedforward_header": "", "feedforward_source": ""}
    used = [name for name in axis.physical_parameters if sp.Symbol(name) in force.free_symbols]
    body = lines([*members(used), f"return {c_code(renamed(force))};"])
    return {
        "feedforward_header": FEEDFORWARD_HEADER.format(name=axis.name),
        "feedforward_source": FEEDFORWARD_SOURCE.format(name=axis.name, body=body),
    }


def _settle_fields(dynamics: SymbolicDynamics) -> dict[str, str]:
    """Fields that lags of drives add to header and source; empty without lags."""
    axis = dynamics.axis
    words = {"name": axis.name, "n_state": dynamics.n_states, "body": settled_lags(dynamics)}
    words |= {"force": sent_forces(axis), "forces": force_parameters(axis)}
    texts = {"settle_header": SETTLE_HEADER, "settle_source": SETTLE_SOURCE}
    return {key: text.format(**words) if words["body"] else "" for key, text in texts.items()}


def _of_signals(entries: Mapping[str, sp.Expr], signals: Sequence[str]) -> str:
    """Body of a function that computes expressions of the signals."""
    used = set(symbol_names(list(entries.values())))
    read = [f"const double {c_name(s)} = signals[{i}];" for i, s in enumerate(signals) if s in used]
    unused = [] if read else ["(void)signals;"]
    return lines(
        [*read, *unused, *assignments(list(entries), [renamed(e) for e in entries.values()], signals)]
    )


def _forward(model: DerivedModel) -> str:
    """Body of the function for minimal parameters, by Horner's rule."""
    names = [None, *(c_name(str(symbol)) for symbol in model.minimal.source.operators.ring.symbols[1:])]
    shared, results = minimal_parameter_code(model.minimal.parameters, names, c_code)
    used = {name for p in model.minimal.parameters for name in p.function.names}
    return lines(
        [
            *members(name for name in model.axis.physical_parameters if name in used),
            *(f"const double {name} = {text};" for name, text in shared),
            *(f"X[{i}] = {text};" for i, text in enumerate(results)),
        ]
    )
