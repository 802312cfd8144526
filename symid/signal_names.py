"""Flat names of signals and of their time derivatives.

A derivative is written as the signal's name, ``_d`` and the order: ``q2_d3`` is the third derivative of
``q2``. The name without suffix is the signal as measured.
"""

import re

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(_(?!d\d+$)[A-Za-z0-9]+)*")
_DERIVATIVE = re.compile(r"(?P<signal>.+)_d(?P<order>[1-9]\d*)")


def is_signal_name(name: str) -> bool:
    """Whether `name` can name a signal or parameter: an identifier that does not look like a derivative.

    >>> is_signal_name("ddq1"), is_signal_name("q2_d1"), is_signal_name("2q")
    (True, False, False)
    """
    return _NAME.fullmatch(name) is not None


def derivative_name(signal: str, order: int) -> str:
    """Flat name of the derivative of a signal.

    >>> derivative_name("q2", 3), derivative_name("q2", 0)
    ('q2_d3', 'q2')
    """
    return signal if order == 0 else f"{signal}_d{order}"


def split_derivative(name: str) -> tuple[str, int]:
    """Signal and order that a flat name stands for; the inverse of `derivative_name`.

    >>> split_derivative("q2_d3"), split_derivative("Fm")
    (('q2', 3), ('Fm', 0))
    """
    match = _DERIVATIVE.fullmatch(name)
    return (match["signal"], int(match["order"])) if match else (name, 0)
