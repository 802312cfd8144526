"""Certified problems of NIST's Statistical Reference Datasets, with an exact check of the data themselves."""

import pytest

from benchmarks import nist_strd

# digits of the worst parameter that may not be fallen below: plain, refined
FLOORS = {
    "norris": (12.0, 13.0), "pontius": (11.5, 12.5), "noint1": (14.0, 14.0), "noint2": (14.0, 14.0),
    "filip": (6.5, 6.5), "longley": (10.5, 12.5), "wampler1": (8.5, 11.5), "wampler2": (12.0, 12.0),
    "wampler3": (8.5, 11.5), "wampler4": (7.0, 10.0), "wampler5": (5.0, 8.0),
}  # fmt: skip


@pytest.mark.parametrize("name", nist_strd.PROBLEMS)
def test_data_give_the_certified_values_in_rational_arithmetic(name):
    problem = nist_strd.load(name)
    parameters, deviations, residual = nist_strd.exact_solution(problem)
    pairs = [
        *zip(parameters, problem.parameters, strict=True),
        *zip(deviations, problem.standard_deviations, strict=True),
        (residual, problem.residual_deviation),
    ]
    for exact, certified in pairs:
        assert float(exact) == pytest.approx(float(certified), rel=1e-14, abs=0.0)


@pytest.mark.parametrize("name", nist_strd.PROBLEMS)
def test_digits(name):
    problem = nist_strd.load(name)
    W, y = problem.arrays
    plain = nist_strd.digits(nist_strd.solve_symid(W, y), problem)
    refined = nist_strd.digits(nist_strd.solve_symid(W, y, refined=True), problem)
    numpy = nist_strd.digits(nist_strd.solve_lstsq(W, y), problem)
    assert plain.parameters >= FLOORS[name][0]
    assert refined.parameters >= FLOORS[name][1]
    assert plain.parameters >= numpy.parameters - 1.0  # a digit: what the order of summation alone may change
    assert refined.parameters >= numpy.parameters - 0.3
    assert plain.standard_deviations >= min(numpy.standard_deviations - 1.0, 12.5)
    assert plain.residual_deviation >= min(numpy.residual_deviation - 1.0, 12.5)
