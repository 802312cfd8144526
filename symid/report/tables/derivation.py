"""A derived model as text and as a JSON record."""

from collections.abc import Callable
from typing import Any, Final

import sympy as sp
from rich.console import Console
from rich.table import Table

from symid.axis import ActuatorDelay
from symid.report.tables.console import report_console
from symid.symbolic import DerivedModel, ParameterFunction

_MOST_LETTERS = 400
"""Longest expression that is printed as a whole."""
_BESIDE = {
    False: "not in the regressor, simulated only",
    True: "not in the regressor, which gets the force without it",
}
_LONGEST: Final = 10_000
"""Fractions of smaller numbers are kept, as 16/25 is."""
_DIGITS: Final = 6


def derivation_record(model: DerivedModel, write: Callable[[Any], str] = str) -> dict[str, Any]:
    """Record of `symid show --json`; `write` makes text of a formula."""
    minimal, maps = model.minimal, model.parameter_map
    branches = [{name: write(value) for name, value in branch.items()} for branch in maps.inverse]
    dynamics = minimal.source.source
    return {
        "axis": model.axis.name,
        "measured": list(model.measured),
        "equations_of_motion": [f"{e.lhs} = {e.rhs}" for e in dynamics.equations],
        "constants": dict(dynamics.constants),
        "output": [write(y) for y in minimal.output],
        "regressor": [[write(entry) for entry in row] for row in minimal.regressor],
        "minimal_parameters": {name: write(function) for name, function in maps.functions.items()},
        "minimal_units": {p.name: str(p.unit) for p in minimal.parameters},
        "physical_units": {name: str(unit) for name, unit in model.axis.physical_parameters.items()},
        "inverse": branches[0] if branches else None,
        "inverse_branches": branches,
        "identifiability": dict(maps.identifiability),
        "identifiability_counted": maps.counted,
        "determined_combinations": [write(function) for function in maps.combinations],
        "relations": maps.relations,
        "assumptions": [
            *model.assumptions,
            *(
                f"{type(element).__name__} is {_BESIDE[isinstance(element, ActuatorDelay)]}: {element.formula}"
                for element in model.axis.imperfections
            ),
        ],
    }


def print_derivation(model: DerivedModel, console: Console | None = None) -> None:
    """Print the derivation of an axis and a set of sensors."""
    record, console = derivation_record(model, readable), console or report_console()
    console.print(f"[bold]{record['axis']}[/bold] measured by {', '.join(record['measured'])}\n")
    motion = "Equations of motion (coordinates relative to the body that carries)"
    _section(console, motion, record["equations_of_motion"])
    for name, value in record["constants"].items():
        console.print(f"    with {name} = {value:g}")
    title = "Minimal model y = D X, columns of D"
    regressor = Table(box=None, pad_edge=False, title_justify="left", title=title)
    regressor.add_column("X")
    for output in record["output"]:
        regressor.add_column(f"y = {output}", overflow="fold")
    regressor.add_column("unit of X")
    regressor.add_column("X in physical parameters", overflow="fold")
    for j, (name, expression) in enumerate(record["minimal_parameters"].items()):
        entries = (row[j] for row in record["regressor"])
        regressor.add_row(name, *entries, record["minimal_units"][name], _shortened(expression))
    console.print(regressor)
    console.print()
    for i, branch in enumerate(record["inverse_branches"]):
        count = len(record["inverse_branches"])
        which = f", solution {i + 1} of {count}" if count > 1 else ""
        lines = [f"{name} = {_shortened(value)}" for name, value in branch.items()]
        _section(console, f"Inverse map{which}", lines)
    if not record["inverse_branches"]:
        lines = ["no closed form; identification solves for the parameters numerically"]
        _section(console, "Inverse map", lines)
    _print_identifiability(console, record)


def _print_identifiability(console: Console, record: dict[str, Any]) -> None:
    words = {
        "unique": "determined uniquely",
        "several": "determined up to a finite choice",
        "none": "not determined",
    }
    lines = []
    for kind, meaning in words.items():
        if names := [name for name, value in record["identifiability"].items() if value == kind]:
            lines.append(f"{meaning}: {', '.join(names)}")
    if not record["identifiability_counted"]:
        lines.append(
            "the solutions were not counted (the system is large): a finite choice may be a unique value"
        )
    if record["determined_combinations"]:
        combinations = ", ".join(map(_shortened, record["determined_combinations"]))
        lines.append(f"determined combinations: {combinations}")
    if record["relations"]:
        lines.append(
            f"{record['relations']} more minimal than physical parameters: as many relations check the structure"
        )
    _section(console, "Identifiability", lines)
    if record["assumptions"]:
        _section(console, "Assumptions", record["assumptions"])


def _section(console: Console, title: str, lines: list[str]) -> None:
    console.print(f"[italic]{title}[/italic]")
    for line in lines:
        console.print(f"    {line}", markup=False)
    console.print()


def _shortened(expression: str) -> str:
    if len(expression) <= _MOST_LETTERS:
        return expression
    return f"{expression[:_MOST_LETTERS]} ... ({len(expression)} characters; the record has all)"


def readable(formula: sp.Expr | ParameterFunction) -> str:
    """A formula as text, its long fractions as decimals of six digits.

    A quotient is divided by the largest number below its line first, so that none is left with a power of ten on both
    sides.

    >>> M, J, K = sp.symbols("M J K")
    >>> readable(J + sp.Rational(16129, 400000000) * M), readable(sp.Rational(16, 25) * M)
    ('J + 4.03225e-5*M', '16*M/25')
    >>> readable((312500000000 * M + 497359197162 * J) / (625000000000 * K))
    '(0.795775*J + M/2)/K'
    """
    if isinstance(formula, ParameterFunction):
        if formula.is_long:
            return str(formula)
        formula = formula.expression
    if not any(map(_is_long, formula.atoms(sp.Rational))):
        return str(formula)
    quotients = map(_quotient, sp.Add.make_args(formula))
    return str(sp.sstr(_in_decimals(sp.Add(*quotients)), full_prec=False))


def _quotient(expression: sp.Expr) -> sp.Expr:
    above, below = expression.as_numer_denom()
    largest = max(abs(term.as_coeff_Mul()[0]) for term in sp.Add.make_args(below))
    return _divided(above, largest) / _divided(below, largest)


def _divided(expression: sp.Expr, number: Any) -> sp.Expr:
    terms = (term.as_coeff_Mul() for term in sp.Add.make_args(expression))
    return sp.Add(*(_in_decimals(factor / number) * rest for factor, rest in terms))


def _in_decimals(expression: sp.Expr) -> sp.Expr:
    long = filter(_is_long, expression.atoms(sp.Rational))
    return expression.xreplace({number: sp.Float(f"{float(number):.{_DIGITS}g}") for number in long})


def _is_long(number: sp.Rational) -> bool:
    return bool(max(abs(number.p), number.q) >= _LONGEST)
