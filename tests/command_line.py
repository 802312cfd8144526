"""The command line as tests call it."""

import re

import pytest

from symid.cli import main


def run(*arguments: str) -> int:
    """Exit code of a command."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


FRACTION = r"\d+(?:\.\d+(?:e[-+]?\d+)?|e[-+]?\d+)"
"""A number that was rounded for print; whole numbers count something."""


def follows(message: str, printed: str) -> bool:
    """Whether a text is what a page prints, lines wrapped anew and ``...`` for anything.

    Rounded numbers agree to a thousandth or to one unit of their last digit: processors round differently.
    """
    parts = [
        r"\s+".join(f"({FRACTION})".join(map(re.escape, re.split(FRACTION, word))) for word in part.split())
        for part in re.split(r"^\.\.\.$", printed, flags=re.MULTILINE)
    ]
    found = re.fullmatch(r"\s*" + r"[\s\S]*".join(parts) + r"\s*", message.strip())
    return found is not None and all(map(_agree, found.groups(), re.findall(FRACTION, printed)))


def _agree(message: str, printed: str) -> bool:
    mantissa, _, exponent = printed.partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(float(message) - float(printed)) <= max(1e-3 * float(printed), 1.01 * last_digit)
