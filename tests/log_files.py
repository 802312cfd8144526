"""Columns of a log of direct_2m1s, their text file, and the message of a file that cannot be read."""

import numpy as np
import pytest

from symid.data import read_log
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q2": Unit.of("m"), "ddq1": Unit.of("m/s^2"), "Fm": Unit.of("N")}
N = 200
T = 0.004 * np.arange(N)
Q2 = 0.1 * np.sin(3.0 * T)
FM = 50.0 * np.cos(2.0 * T) + 1.0


def write(path, columns, separator=",", decimal=".", lead=""):
    """A text file of columns with all digits of the numbers."""
    rows = zip(*(np.asarray(column, dtype=object) for column in columns.values()), strict=True)
    lines = [lead + separator.join(columns)]
    lines += [
        separator.join(
            value if isinstance(value, str) else repr(float(value)).replace(".", decimal) for value in row
        )
        for row in rows
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def columns(**replaced):
    return {"t": T, "q2": Q2, "Fm": FM, **replaced}


def error_of(path, **options):
    """The message of the error, which must be one line and start with the path."""
    with pytest.raises(LogError) as caught:
        read_log(path, **{"expected": EXPECTED, **options})
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: ")
    assert len(message) < 600
    return message
