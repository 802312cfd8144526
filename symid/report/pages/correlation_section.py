"""Correlations of a residual: their section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symid.identification.residual_correlation import Correlation
from symid.report.figures.correlation_figure import correlation_figure
from symid.report.figures.drawn import wide_and_narrow
from symid.report.pages.plot_data import correlation_data

_NAME = "memory-plot"


def correlation_fields(parts: Sequence[tuple[str, Correlation, Correlation]]) -> dict[str, Any]:
    """Fields of `memory.html`: the figure, its numbers, and the shares outside the bands of each part."""
    return {
        "remembered": wide_and_narrow(lambda narrow: correlation_figure(parts, narrow=narrow), _NAME),
        "remembered_data": correlation_data(parts),
        "whiteness": [(title, own.outside, across.outside) for title, own, across in parts],
    }
