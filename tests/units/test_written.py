"""Units as they are written: what a unit means for its signal is taken, and nothing else."""

import math

import pytest
from hypothesis import given, strategies as st

from symid.errors import LogError
from symid.units import Unit, to_si

TURN = 2 * math.pi


@pytest.mark.parametrize(
    ("text", "expected", "factor"),
    [
        ("Grad", "rad", TURN / 360),
        ("°", "rad", TURN / 360),
        ("°/s", "rad/s", TURN / 360),
        ("gon", "rad", TURN / 400),
        ("1/min", "rad/s", TURN / 60),
        ("min-1", "rad/s", TURN / 60),
        ("min⁻¹", "rad/s", TURN / 60),
        ("min^-1", "rad/s", TURN / 60),
        ("U/min", "rad/s", TURN / 60),
        ("rpm", "rad/s", TURN / 60),
        ("Hz", "rad/s", TURN),
        ("kHz", "rad/s", 1e3 * TURN),
        ("rev/s", "rad/s", TURN),
        ("rpm/s", "rad/s^2", TURN / 60),
        ("1/min/s", "rad/s^2", TURN / 60),
        ("4096 counts/rev", "rad", TURN / 4096),
        ("4096/turn", "rad", TURN / 4096),
        ("rev/4096", "rad", TURN / 4096),
        ("4096 counts per turn", "rad", TURN / 4096),
        ("65536 cpr", "rad", TURN / 65536),
        ("1000 counts/mm", "m", 1e-6),
        ("0.1 um", "m", 1e-7),
        ("Nm", "N*m", 1.0),
        ("mNm", "N*m", 1e-3),
        ("Ncm", "N*m", 1e-2),
        ("N.m", "N*m", 1.0),
        ("lbf ft", "N*m", 1.3558179483314),
        ("g", "m/s^2", 9.80665),
        ("m/s2", "m/s^2", 1.0),
        ("m/s²", "m/s^2", 1.0),
        ("m/min", "m/s", 1 / 60),
        ("kN", "N", 1e3),
        ("Volts", "V", 1.0),
        ("Millimeters", "m", 1e-3),
        ("min", "s", 60.0),
        ("in", "m", 0.0254),
        ("millimeters", "m", 1e-3),
        ("mA", "A", 1e-3),
    ],
)
def test_what_a_unit_means_for_its_signal(text: str, expected: str, factor: float) -> None:
    assert to_si(text, Unit.of(expected)) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "expected", "says"),
    [
        ("grad", "rad", "a degree or a gon"),
        ("count", "rad", "counts per turn"),
        ("bit", "m", "has no known size"),
        ("Inkr", "m", "has no known size"),
        ("counts/s", "rad/s", "has no known size"),
        ("counts/rev", "rad", "has no known size"),
        ("", "rad", "has no known size"),
        ("-", "m", "has no known size"),
        ("%", "N", "has no known size"),
        ("dB", "rad", "is not known"),
        ("1/s", "rad/s", "radians or turns"),
        ("s^-1", "rad/s", "radians or turns"),
        ("Mm", "m", "is not known"),
        ("Ms", "s", "is not known"),
        ("Grad", "m", "does not measure"),
        ("Hz", "m/s", "does not measure"),
        ("1/min", "m/s", "does not measure"),
        ("Nm", "N", "does not measure"),
        ("nm", "N*m", "does not measure"),
        ("A", "N", "does not measure"),
        ("N*m/rad", "N*m", "does not measure"),
        ("rad", "rad/s", "does not measure"),
        ("0 m", "m", "is not possible"),
    ],
)
def test_what_it_does_not_mean_is_refused(text: str, expected: str, says: str) -> None:
    with pytest.raises(LogError, match=says) as refused:
        to_si(text, Unit.of(expected))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "bomb",
    [
        "9**9**9**9",
        "m^9^9^9^9",
        "m**999999999",
        "(" * 50,
        "(" * 9999,
        "9" * 9999,
        "m" * 9999,
        "m*" * 9999,
        "9e999 m",
        "m^-99",
        "((((((m))))))",
        "9**9**9**9 counts/rev",
        "1e308*1e308*m",
        "m\x00",
        "lambda: 0",
    ],
)
def test_bombs_are_no_units(bomb: str) -> None:
    for expected in (None, Unit.of("m"), Unit.of("rad/s")):
        with pytest.raises(LogError):
            to_si(bomb, expected)


@given(st.text(alphabet="mMs1/2 *^-()radHzNµ°.9e%countsGg", max_size=30) | st.text(max_size=80))
def test_any_text_is_a_factor_or_refused(text: str) -> None:
    for expected in (None, Unit.of("rad"), Unit.of("N*m"), Unit.of("rad/s")):
        try:
            factor = to_si(text, expected)
        except LogError:
            continue
        assert 0 < factor < math.inf


@given(st.sampled_from(["m", "rad", "s", "N", "N*m", "m/s", "rad/s", "m/s^2", "rad/s^2", "A", "V"]))
def test_units_that_symid_prints_are_read(name: str) -> None:
    assert to_si(str(Unit.of(name)), Unit.of(name)) == to_si(name) == 1.0


@pytest.mark.parametrize(
    ("text", "expected", "factor"),
    [
        *((text, "kg*m^2", 1e-4) for text in ("kg*cm^2", "kgcm^2", "kgcm²", "kg·cm²", "kg cm2", "kgcm**2")),
        ("gcm²", "kg*m^2", 1e-7),
        ("kgm²", "kg*m^2", 1.0),
        ("N*m", "N*m/rad", 1.0),
        ("Nm/°", "N*m/rad", 360 / TURN),
        ("mNm*s", "N*m*s/rad", 1e-3),
        ("50counts/m", "m", 0.02),
        ("4096counts/rev", "rad", TURN / 4096),
    ],
)
def test_units_of_data_sheets_are_read(text: str, expected: str, factor: float) -> None:
    assert to_si(text, Unit.of(expected)) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "expected"), [("kg", "kg*m^2"), ("m", "rad"), ("N*m", "N"), ("kgcm", "kg*m^2")]
)
def test_a_radian_stands_for_nothing_else(text: str, expected: str) -> None:
    with pytest.raises(LogError):
        to_si(text, Unit.of(expected))
