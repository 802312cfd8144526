"""Coefficients that doubles do not hold, as products of the decimals of many ratios and known values become."""

from fractions import Fraction

import pytest
from sympy import QQ
from sympy.polys.rings import PolyRing

from symid.codegen.generation.lowering import minimal_parameter_code
from symid.export.c_code import c_code
from symid.symbolic.minimal import MinimalParameter
from symid.symbolic.parameter_function import ParameterFunction
from symid.units import Unit

RING = PolyRing(("s", "x", "y"), QQ)
_, X, Y = RING.gens


@pytest.mark.parametrize("size", [QQ(7) ** 600, QQ(1, 7**600)], ids=["huge", "tiny"])
def test_a_minimal_parameter_is_computed_from_coefficients_beyond_the_range_of_doubles(size):
    function = ParameterFunction(
        X.mul_ground(size) + Y.mul_ground(3 * size), (X * Y + 2).mul_ground(size / 5)
    )
    parameter = MinimalParameter("X1", function, Unit())
    values = {"x": 1.25, "y": 0.75}
    shared, (result,) = minimal_parameter_code([parameter], [None, "x", "y"])
    for name, text in shared:
        values[name] = eval(text, {}, values)
    assert eval(result, {}, values) == pytest.approx(5 * (1.25 + 3 * 0.75) / (1.25 * 0.75 + 2), rel=1e-15)


def test_no_number_in_exported_code_has_more_digits_than_a_double():
    size = QQ(7) ** 600
    function = ParameterFunction(
        X.mul_ground(size) + Y.mul_ground(3 * size), (X * Y + 2).mul_ground(size / 5)
    )
    shared, results = minimal_parameter_code(
        [MinimalParameter("X1", function, Unit())], [None, "x", "y"], c_code
    )
    assert max(map(len, (*(text for _, text in shared), *results))) < 100


def test_a_long_quotient_of_polynomials_is_written_as_what_it_is():
    above, below = (X + 2 * Y) ** 14 * (X - Y) ** 130 + X, (X + Y) ** 150 + 1
    x, y = Fraction(3, 2), Fraction(-2, 3)
    wanted = ((x + 2 * y) ** 14 * (x - y) ** 130 + x) / ((x + y) ** 150 + 1)
    assert eval(str(ParameterFunction(above, below)), {"x": x, "y": y}) == wanted
