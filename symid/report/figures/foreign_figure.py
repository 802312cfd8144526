"""Figure of a foreign log: its columns over time, in the units of the file."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from symid.arrays import FloatArray
from symid.data import ForeignColumn, Table
from symid.errors import LogError
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import save_figure
from symid.report.figures.panels import draw_over_time
from symid.units import to_si

_MOST_COLUMNS = 12


def plot_foreign(
    table: Table,
    columns: Sequence[ForeignColumn],
    period: float | None,
    file: str | Path,
    palette: Palette = LIGHT,
) -> None:
    """Draw each of the first dozen columns of a file over time, in the unit of the file, as png, svg or pdf.

    Samples are counted where neither a column of the time nor the sampling period (s) is known.
    """
    drawn = [column for column in columns if column.quantity != "time"][:_MOST_COLUMNS]
    if not drawn:
        raise LogError("there is no column to draw: the file holds no numbers besides the time")
    clock = next((column for column in columns if column.quantity == "time" and column.unit), None)
    values = _values(table, [column.header for column in drawn])
    if clock is not None and clock.unit is not None:
        time, label = to_si(clock.unit) * _values(table, [clock.header])[0], "time [s]"
    else:
        time = (period or 1.0) * np.arange(values[0].size, dtype=np.float64)
        label = "time [s]" if period else "samples"
    with mpl.rc_context(palette.style):
        figure = Figure(figsize=(9, 1.5 * len(drawn) + 0.6), layout="constrained")
        rows = figure.subplots(len(drawn), 1, sharex=True, squeeze=False)[:, 0]
        for axes, column, course in zip(rows, drawn, values, strict=True):
            colour = palette.model if column.setpoint else palette.other
            draw_over_time(axes, time, {column.header: (course, colour, 0.9)}, column.unit or "?")
            axes.set_title(f"{column.header}: {column.quantity or 'not known'}", loc="left", fontsize=9)
        rows[-1].set_xlabel(label)
        save_figure(figure, file)


def _values(table: Table, headers: Sequence[str]) -> list[FloatArray]:
    columns = table.read([table.headers.index(header) for header in headers])
    return [column for column in columns if not isinstance(column, str)]
