"""Figures for notebooks, files and pages, and the scales of their diagrams."""

import io
import math
import re
import textwrap
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from symid.arrays import FloatArray
from symid.files import replacing, written_path
from symid.report.figures.binned_means import Means


class Drawn(Figure):
    """A figure without a window; notebooks show it with or without pyplot."""

    def _repr_png_(self) -> bytes:
        """PNG that notebooks show."""
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=110)
        return picture.getvalue()


def save_figure(figure: Figure, file: str | Path) -> None:
    """Write a figure as png, svg or pdf, as a whole or not at all; SettingError for another suffix."""
    path = written_path("figure", file, ".png", ".svg", ".pdf")
    with replacing(path) as unfinished:
        figure.savefig(unfinished, dpi=150, format=path.suffix.lower()[1:])


def with_id_prefix(svg: str, name: str) -> str:
    """An SVG element whose identifiers begin with a name, for a page that holds several.

    >>> with_id_prefix('<svg id="a"><use xlink:href="#a" clip-path="url(#b)"/></svg>', "fit")
    '<svg id="fit-a"><use xlink:href="#fit-a" clip-path="url(#fit-b)"/></svg>'
    """
    return re.sub(r'( id="|href="#|url\(#)', rf"\g<1>{name}-", svg)


def svg_of(figure: Figure, name: str) -> str:
    """A figure as an element of a page, the same each time; figures of one page need different names.

    Places along its paths keep two decimals of a point.
    """
    text = io.StringIO()
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(text, format="svg", metadata=nothing)
    svg = text.getvalue()[text.getvalue().index("<svg ") :]
    seen: Counter[str] = Counter()  # an identifier stands once: signs of the same kind are numbered

    def numbered(match: re.Match[str]) -> str:
        seen[match[1]] += 1
        count = seen[match[1]]
        return match[0] if count == 1 else f' id="{match[1]} {count}"'

    shorter = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), svg)
    return re.sub(r' id="([^"]*)"', numbered, shorter)


def wide_and_narrow(draw: Callable[[bool], Figure | None], name: str) -> tuple[str, str] | None:
    """A figure for a desk and for a phone as elements of a page, which shows one of them; None where there is none.

    `draw` draws it, narrow or not; the name begins their identifiers.
    """
    figures = [(figure, f"{name}{end}") for end, figure in (("", draw(False)), ("-narrow", draw(True)))]
    elements = [with_id_prefix(svg_of(figure, one), one) for figure, one in figures if figure is not None]
    return (elements[0], elements[1]) if len(elements) == 2 else None


_LINE, _NARROW_LINE = 80, 42
"""Characters that a diagram has room for, at a desk and on a phone."""


def title_lines(title: str, *, narrow: bool) -> str:
    r"""A title in lines that a diagram has room for.

    >>> title_lines("validation on acceptance_run_of_the_second_shift.csv", narrow=True)
    'validation on\nacceptance_run_of_the_second_shift.csv'
    """
    return "\n".join(textwrap.wrap(title, _NARROW_LINE if narrow else _LINE))


_SEEN = (0.5, 99.5)
_MARGIN = 0.15
"""Percentiles of the residual within the plot, and the margin around them."""
_WIDE = 2.0
"""Decades beyond which only powers of ten are labelled."""
_MOST_TICKS = 7


def seen_range(residual: FloatArray, *means: Means) -> tuple[float, float]:
    """Range of a residual without its rarest values, which contains all means.

    >>> low, high = seen_range(np.array([-1.0, 1.0]), Means(np.zeros(1), np.array([4.0]), np.zeros(1)))
    >>> round(low, 3), round(high, 3)
    (-1.287, 4.297)
    """
    low, high = np.percentile(residual, _SEEN) if residual.size else (-1.0, 1.0)
    margin = _MARGIN * (high - low)
    ends = np.concatenate([[low, high], *(one.values for one in means)])
    return float(ends.min() - margin), float(ends.max() + margin)


def label_log_scales(axes: Axes) -> None:
    """Label each logarithmic scale of a finished diagram by plain numbers, few enough that they stand apart."""
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() != "log":
            continue
        low, high = sorted(axis.get_view_interval())
        between = (1.0,) if math.log10(high / low) >= _WIDE else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=between, numticks=_MOST_TICKS))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
