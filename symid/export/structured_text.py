"""Feed-forward and friction compensation of an axis as a function block in IEC 61131-3 Structured Text."""

import re
import textwrap
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import sympy as sp
from sympy.printing.str import StrPrinter

from symid.axis import Axis, Between, Body
from symid.errors import SettingError
from symid.export.exported import Exported, TextTarget, losses_of_imperfections, require_physical
from symid.export.feedforward import ACCELERATION, POSITION, SPEED, feedforward

_BLOCK = """\
(* Feed-forward of axis {name}, exported by symid:
{notes} *)
FUNCTION_BLOCK FB_{name}_Feedforward
VAR_INPUT
{inputs}
END_VAR
VAR_OUTPUT
{outputs}
END_VAR
VAR
    direction : LREAL;
END_VAR

IF ABS(velocity) < rest_speed THEN
    direction := velocity / rest_speed;
ELSE
    direction := SEL(velocity > 0.0, -1.0, 1.0);
END_IF
friction := {friction};
force := {force};{command}
END_FUNCTION_BLOCK
"""
_DIRECTION = sp.Symbol("direction_")
_LONGEST = 10**6  # numerator or denominator up to which a number is written as a fraction
_NAMES_OF_FUNCTIONS = ("ABS", "SIN", "COS", "TAN", "EXP", "LN", "ATAN")
_FUNCTIONS = dict(zip(("Abs", "sin", "cos", "tan", "exp", "log", "atan"), _NAMES_OF_FUNCTIONS, strict=True))
_TAKEN = frozenset(
    re.findall(
        r"\w+",
        """position velocity acceleration force friction command direction rest_speed
    abs sqrt sin cos tan asin acos atan exp ln log expt sel mod trunc and or xor not if then else elsif end_if
    case of for to by do while repeat until exit return at true false t s r s1 r1 n l d p ton tof tp date time tod
    dt int dint real lreal bool byte word en eno on var task type with step action array struct string pi
    add sub mul div move gt ge eq le lt ne min max limit mux shl shr rol ror len left right mid concat insert delete
    replace find""",
    )
)
"""Words of the language, its standard functions among them, and of the block; they are not case-sensitive."""


class _StructuredTextPrinter(StrPrinter):  # type: ignore[misc]  # sympy has no types
    """Prints numbers as LREAL, and powers as products or EXPT."""

    def _print_Integer(self, expression: Any) -> str:
        return f"{int(expression)}.0"

    def _print_Rational(self, expression: Any) -> str:
        return self._print_Float(sp.Float(expression, 17))

    def _print_Float(self, expression: Any) -> str:
        text = repr(float(expression))
        mantissa, exponent, power = text.partition("e")
        return (mantissa if "." in mantissa else f"{mantissa}.0") + exponent.upper() + power

    def _print_Pow(self, expression: Any, rational: bool = False) -> str:
        base, power = expression.args
        if power.is_Integer and 2 <= power <= 4 and base.is_Symbol:
            return "(" + "*".join([self._print(base)] * int(power)) + ")"
        if power == sp.S.Half:
            return f"SQRT({self._print(base)})"
        if power == -1:
            return f"(1.0/({self._print(base)}))"
        return f"EXPT({self._print(base)}, {self._print(power)})"

    def _print_Function(self, expression: Any) -> str:
        name = _FUNCTIONS.get(str(expression.func))
        if name is None or len(expression.args) != 1:
            raise SettingError(f"Structured Text has no function {str(expression.func)!r}: take `to=c`")
        return f"{name}({self._print(expression.args[0])})"

    def _print_Abs(self, expression: Any) -> str:
        return self._print_Function(expression)


def structured_text(axis: Axis, values: Mapping[str, float]) -> Exported:
    """Feed-forward and friction compensation of an axis as a function block.

    The axis is treated as rigid, without deflection of its springs. `friction` is the part of `force` that depends on
    the speed; below `rest_speed`, its jumps are replaced by straight lines.

    Parameters
    ----------
    axis : Axis
        The axis; its imperfections become losses.
    values : mapping of str to float
        Physical parameters, SI: the initial values of inputs.

    Raises
    ------
    SettingError
        If no machine has the values, or the axis does not have exactly one motion without deflection or has a law that
        the language cannot express.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> exported = structured_text(load_axis("rigid_1m"), {"M": 95.0, "Fv": 200.0, "Fs": 20.0})
    >>> [line for line in exported.text.splitlines() if line.startswith("friction")]
    ['friction := Fs*direction + Fv*velocity;']
    """
    require_physical(axis, values)
    law, drive = feedforward(axis.without(*axis.imperfections)), axis.only_drive
    named = {name: _name(name, axis.physical_parameters) for name in axis.physical_parameters}
    losses = list(losses_of_imperfections(axis, "a feed-forward"))
    if len(axis.bodies) > 1:
        losses.append("Deflection of springs: the force is that of the axis as one rigid motion.")
    notes = [
        "force = what the motion needs, without feedback; friction = its part that depends on the speed.",
        *(f"Lost: {loss}" for loss in losses),
    ]
    wrapped = (part for note in notes for part in textwrap.wrap(note, 97))
    text = _BLOCK.format(
        name=axis.name,
        notes="\n".join(f"   {line}" for line in wrapped),
        inputs="\n".join(f"    {line}" for line in _inputs(axis, values, law.force, named)),
        outputs="\n".join(f"    {line}" for line in _outputs(axis)),
        friction=_statement(law.friction, named),
        force=_statement(law.force - law.friction, named, "friction"),
        command=f"\ncommand := force / {_number(drive.factor)};" if drive.command else "",
    )
    return Exported({".st": text}, tuple(losses))


def _inputs(
    axis: Axis, values: Mapping[str, float], force: sp.Expr, named: Mapping[str, str]
) -> Iterator[str]:
    """Declarations of the motion and of the parameters of a force."""
    drive = axis.only_drive.at
    at = drive.second if isinstance(drive, Between) else drive
    length = "rad" if isinstance(at, Body) and at.inertia else "m"
    yield f"position : LREAL; (* reference of the drive, {length} *)"
    yield f"velocity : LREAL; (* {length}/s *)"
    yield f"acceleration : LREAL; (* {length}/s^2 *)"
    yield f"rest_speed : LREAL := 0.0001; (* {length}/s *)"
    for name, unit in axis.physical_parameters.items():
        if sp.Symbol(name) in force.free_symbols:
            yield f"{named[name]} : LREAL := {_number(values[name])}; (* {unit or '1'} *)"


def _outputs(axis: Axis) -> Iterator[str]:
    drive = axis.only_drive
    unit = axis.signal_units[drive.signal]
    yield f"force : LREAL; (* {unit} *)"
    yield f"friction : LREAL; (* its part that depends on the speed, {unit} *)"
    if drive.command:
        yield f"command : LREAL; (* {drive.command}, the command of the drive for this force *)"


def _number(value: float) -> str:
    return str(_StructuredTextPrinter().doprint(sp.Float(value, 17)))


def _name(name: str, names: Collection[str]) -> str:
    """A free name: names are not case-sensitive, and words of the language are taken."""
    same = [other for other in names if other.lower() == name.lower()]
    suffix = f"_{same.index(name) + 1}" if len(same) > 1 else "_p" if name.lower() in _TAKEN else ""
    return f"{name}{suffix}"


def _statement(expression: sp.Expr, named: Mapping[str, str], *more: str) -> str:
    """An expression in the names of the block."""
    exact = sp.expand_mul(expression)
    long = {r: sp.Float(r, 17) for r in exact.atoms(sp.Rational) if max(abs(r.p), r.q) > _LONGEST}
    written = exact.xreplace(long).subs({sp.sign(SPEED): _DIRECTION})
    words = {POSITION: "position", SPEED: "velocity", ACCELERATION: "acceleration", _DIRECTION: "direction"}
    names = {**{sp.Symbol(a): b for a, b in named.items()}, **words}
    text = _StructuredTextPrinter().doprint(written.xreplace({a: sp.Symbol(b) for a, b in names.items()}))
    return " + ".join([*more, text]) if text != "0.0" or not more else more[0]


TARGET = TextTarget("st", "feed-forward in Structured Text", structured_text)
