"""Numbers as reports write them; a dash for a missing one."""

import math

MISSING = "–"
_LARGE = 3.0
"""A change by more than this factor is written as a factor."""
_LONG = 1e6
"""Magnitude from which a rounded number is written with an exponent."""


def significant(value: float, digits: int = 4) -> str:
    """A number with its significant digits.

    >>> significant(3.14159), significant(123.4, 2), significant(2.5e9), significant(float("nan"))
    ('3.142', '120', '2.5e+09', '–')
    >>> significant(9999.7), significant(-99.97, 3), significant(999999.7)
    ('10000', '-100', '1e+06')
    """
    if not math.isfinite(value):
        return MISSING
    rounded = f"{value:.{digits}g}"
    return f"{float(rounded):.0f}" if 10**digits <= abs(float(rounded)) < _LONG else rounded


def with_deviation(value: float, deviation: float) -> str:
    """A value with the digits that its standard deviation leaves, and the deviation to two digits.

    >>> with_deviation(88.6143, 0.123), with_deviation(22140.0, 614.2), with_deviation(3.0, float("nan"))
    ('88.61 ± 0.12', '22140 ± 614', '3')
    >>> with_deviation(1.00034e9, 2.1e6), with_deviation(6.1e-4, 2.3e-5)
    ('(1.0003 ± 0.0021)e9', '(6.10 ± 0.23)e-4')

    One with an infinite deviation is not shown: any value would do as well.

    >>> with_deviation(53.147, float("inf"))
    'not determined'
    """
    if not math.isfinite(value):
        return MISSING
    if deviation == math.inf:
        return "not determined"
    if not math.isfinite(deviation) or deviation <= 0:
        return significant(value)
    exponent, places = _digits(value, deviation)
    text = " ± ".join(f"{x / 10.0**exponent:.{places}f}" for x in (value, deviation))
    return f"({text})e{exponent}" if exponent else text


def interval_end(value: float, deviation: float, deviations: float) -> str:
    """End of an interval, some deviations from a value, with the digits of `with_deviation`.

    >>> interval_end(120.005, 0.0026, -1.96), interval_end(120.005, 0.0026, 1.96)
    ('119.9999', '120.0101')
    >>> interval_end(6.1e-4, 2.3e-5, 1.96), interval_end(53.1, float("inf"), 1.96)
    ('6.55e-4', '–')
    """
    end = value + deviations * deviation
    if not math.isfinite(end) or deviation <= 0:
        return significant(end)
    exponent, places = _digits(value, deviation)
    text = f"{end / 10.0**exponent:.{places}f}"
    return f"{text}e{exponent}" if exponent else text


def _digits(value: float, deviation: float) -> tuple[int, int]:
    """Power of ten that stands apart, and decimal places that leave two digits of a deviation."""
    exponent = math.floor(math.log10(max(abs(value), deviation)))
    exponent = 0 if -3 <= exponent < 6 else exponent
    return exponent, min(max(1 - math.floor(math.log10(deviation / 10.0**exponent)), 0), 15)


def multiple(value: float) -> str:
    """Multiples of the noise floor.

    >>> multiple(1.0423), multiple(12.34), multiple(999.8), multiple(1244.2), multiple(float("inf"))
    ('1.04 ×', '12.3 ×', '1000 ×', '1244 ×', '–')
    """
    if not math.isfinite(value):
        return MISSING
    return f"{significant(value, 3) if value < 1000 else f'{value:.0f}'} ×"


def times(value: float, floor: float) -> str:
    """An error in multiples of a noise floor.

    >>> times(6.0, 2.0), times(6.0, 0.0)
    ('3 ×', '–')
    """
    return multiple(value / floor if floor > 0 else math.nan)


def percent(value: float, digits: int = 3) -> str:
    """A share as a percentage.

    >>> percent(0.0483), percent(0.97), percent(9.997), percent(float("nan"))
    ('4.83 %', '97 %', '1000 %', '–')
    """
    return f"{significant(100 * value, digits)} %" if math.isfinite(value) else MISSING


def share(value: float) -> str:
    """A share in whole percent.

    >>> share(0.624), share(0.002), share(0.0)
    ('62 %', '< 1 %', '0 %')
    """
    if not math.isfinite(value):
        return MISSING
    return "< 1 %" if 0 < value < 0.01 else f"{100 * value:.0f} %"


def probability(value: float) -> str:
    """A probability, never rounded to certainty.

    >>> probability(0.934), probability(0.99999), probability(1e-9), probability(0.0)
    ('0.93', '> 0.999', '< 0.001', '0')
    """
    if not math.isfinite(value):
        return MISSING
    if value > 0.999:
        return "> 0.999" if value < 1 else "1"
    if value < 0.001:
        return "< 0.001" if value > 0 else "0"
    return f"{value:.3f}" if value > 0.99 or value < 0.01 else f"{value:.2f}"


def change(value: float, reference: float) -> str:
    """Change against a reference, in percent of it; as a factor where it is large.

    >>> change(88.6, 90.0), change(0.5, 20.0), change(3.0, 0.5), change(1.0, float("nan"))
    ('-1.56 %', '-97.5 %', '× 6', '–')
    """
    if not (math.isfinite(value) and math.isfinite(reference)) or reference == 0:
        return MISSING
    ratio = value / reference
    return f"× {significant(ratio, 3)}" if ratio > _LARGE else f"{100 * (ratio - 1):+.3g} %"


def band(low: float, high: float) -> str:
    """A frequency band; an end that is not finite is open.

    >>> band(0.5, 12.25), band(float("nan"), 8.0), band(1234.0, float("inf"))
    ('0.5–12.2 Hz', 'below 8 Hz', 'above 1230 Hz')
    """
    begin, end = significant(low, 3), significant(high, 3)
    if math.isfinite(low) and math.isfinite(high):
        return f"{begin}–{end} Hz"
    if math.isfinite(high):
        return f"below {end} Hz"
    return f"above {begin} Hz" if math.isfinite(low) else "all frequencies"


def capitalize_first(text: str) -> str:
    """A sentence with a capital first letter; names within it keep their letters.

    >>> capitalize_first("within noise of Fs")
    'Within noise of Fs'
    """
    return text[:1].upper() + text[1:]
