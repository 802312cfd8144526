"""Certified digits on the linear regression problems of NIST's Statistical Reference Datasets.

Ours next to numpy.linalg.lstsq on columns of unit norm. The figure is the log relative error of the worst
value, -log10 |x - c|/|c| (-log10 |x| where the certified c is 0), 15 digits at most.
The data lie in `benchmarks/nist`; `exact_solution` recomputes their certified values in rational arithmetic.

Usage: python -m benchmarks.nist_strd
"""

import csv
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symid.estimation.corrected_covariance import ObservationBlock
from symid.estimation.least_squares import estimate
from symid.estimation.refinement import refine_blocks
from symid.estimation.triangular import triangular_factors

FOLDER = Path(__file__).parent / "nist"
PROBLEMS = (
    "norris", "pontius", "noint1", "noint2", "filip", "longley",
    "wampler1", "wampler2", "wampler3", "wampler4", "wampler5",
)  # fmt: skip
FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """A data set with its certified values, all as exact rational numbers."""

    W: tuple[tuple[Fraction, ...], ...]
    y: tuple[Fraction, ...]
    parameters: tuple[Fraction, ...]
    standard_deviations: tuple[Fraction, ...]
    residual_deviation: Fraction

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """W and y, rounded once to floating point."""
        return np.array(self.W, dtype=np.float64), np.array(self.y, dtype=np.float64)


@dataclass(frozen=True)
class Solution:
    parameters: FloatArray
    standard_deviations: FloatArray
    residual_deviation: float


@dataclass(frozen=True)
class Digits:
    """Certified digits of the worst parameter, the worst standard deviation, and the residual's deviation."""

    parameters: float
    standard_deviations: float
    residual_deviation: float


def load(name: str) -> Problem:
    """Read a problem from its two files."""
    with (FOLDER / f"{name}.csv").open() as file:
        table = list(csv.DictReader(file))
    with (FOLDER / f"{name}_certified.csv").open() as file:
        *certified, residual = list(csv.DictReader(file))
    return Problem(
        W=tuple(tuple(_regressor(entry["regressor"], row) for entry in certified) for row in table),
        y=tuple(Fraction(row["y"]) for row in table),
        parameters=tuple(Fraction(entry["estimate"]) for entry in certified),
        standard_deviations=tuple(Fraction(entry["standard_deviation"]) for entry in certified),
        residual_deviation=Fraction(residual["standard_deviation"]),
    )


def exact_solution(problem: Problem) -> tuple[tuple[Fraction, ...], tuple[Decimal, ...], Decimal]:
    """Solve the normal equations in rational arithmetic; deviations to 40 decimal digits."""
    W, y, p = problem.W, problem.y, len(problem.parameters)
    normal = [[_dot([row[i] for row in W], [row[j] for row in W]) for j in range(p)] for i in range(p)]
    inverse = _inverse(normal)
    moments = [_dot([row[i] for row in W], y) for i in range(p)]
    X = tuple(_dot(row, moments) for row in inverse)
    rho = [b - _dot(row, X) for row, b in zip(W, y, strict=True)]
    variance = _dot(rho, rho) / (len(y) - p)
    return X, tuple(_root(variance * inverse[i][i]) for i in range(p)), _root(variance)


def solve_symid(W: FloatArray, y: FloatArray, refined: bool = False) -> Solution:
    """Solve with symid's triangular factor, with a step of refinement on the rows if wanted."""
    fit = estimate(triangular_factors(W[None], y[None]), method="ols")
    fit = refine_blocks([ObservationBlock(W[None], y[None])], fit) if refined else fit
    return Solution(fit.parameters, fit.standard_deviations, fit.sigma_rho)


def solve_lstsq(W: FloatArray, y: FloatArray) -> Solution:
    """Solve with numpy.linalg.lstsq and the pseudo-inverse, columns scaled to unit norm."""
    norms = np.linalg.norm(W, axis=0)
    X, *_ = np.linalg.lstsq(W / norms, y, rcond=1e-15)
    _, values, Vt = np.linalg.svd(W / norms, full_matrices=False)
    sigma = float(np.linalg.norm(y - (W / norms) @ X)) / np.sqrt(len(y) - len(X))
    return Solution(X / norms, sigma * np.linalg.norm(Vt.T / values, axis=1) / norms, float(sigma))


def digits(solution: Solution, problem: Problem) -> Digits:
    """Compare a solution with the certified values."""
    return Digits(
        min(map(_digits, solution.parameters, problem.parameters)),
        min(map(_digits, solution.standard_deviations, problem.standard_deviations)),
        _digits(solution.residual_deviation, problem.residual_deviation),
    )


def _regressor(name: str, row: dict[str, str]) -> Fraction:
    if name == "1":
        return Fraction(1)
    base, _, power = name.partition("^")
    return Fraction(row[base]) ** int(power or 1)


def _digits(value: float, certified: Fraction) -> float:
    error = abs(Fraction(float(value)) - certified) / (abs(certified) or 1)
    return 15.0 if error == 0 else float(min(15.0, -np.log10(float(error))))


def _dot(a: list[Fraction] | tuple[Fraction, ...], b: list[Fraction] | tuple[Fraction, ...]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _inverse(matrix: list[list[Fraction]]) -> list[list[Fraction]]:
    n = len(matrix)
    rows = [row + [Fraction(int(i == j)) for j in range(n)] for i, row in enumerate(matrix)]
    for i in range(n):  # positive definite: no pivot is 0
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for k in range(n):
            if k != i:
                rows[k] = [b - rows[k][i] * a for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def _root(value: Fraction) -> Decimal:
    with localcontext() as context:
        context.prec = 40
        return (Decimal(value.numerator) / Decimal(value.denominator)).sqrt()


def main() -> None:
    print(f"{'certified digits':18}{'parameters':^27}{'standard dev.':^18}{'residual dev.':^18}")
    print(f"{'':18}" + f"{'symid':>9}{'refined':>9}{'lstsq':>9}" + 2 * f"{'symid':>9}{'lstsq':>9}")
    for name in PROBLEMS:
        problem = load(name)
        W, y = problem.arrays
        ours, theirs = digits(solve_symid(W, y), problem), digits(solve_lstsq(W, y), problem)
        refined = digits(solve_symid(W, y, refined=True), problem)
        values = (
            *(ours.parameters, refined.parameters, theirs.parameters),
            *(ours.standard_deviations, theirs.standard_deviations),
            *(ours.residual_deviation, theirs.residual_deviation),
        )
        print(f"{name:18}" + "".join(f"{value:9.1f}" for value in values))


if __name__ == "__main__":
    main()
