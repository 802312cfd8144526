"""Parameters of two results beside each other, with their intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import scipy

from symid.report.figures.colours import LIGHT
from symid.report.figures.drawn import Drawn

_INTERVAL = float(scipy.special.ndtri(0.975))
"""Half width of a 95 % interval, in deviations."""
_ROW, _WIDTH, _NARROW_WIDTH = 0.55, 8.0, 4.2
"""In inches."""


def comparison_figure(record: Mapping[str, Any], *, narrow: bool) -> Drawn | None:
    """Each parameter of both results, in percent of A, with 95 % intervals; None where A is 0 throughout.

    Parameters
    ----------
    record : mapping
        That of `comparison_record`.
    """
    drawn = {name: one for name, one in record["parameters"].items() if one["a"]["value"]}
    if not drawn:
        return None
    with mpl.rc_context(LIGHT.style):
        size = (_NARROW_WIDTH if narrow else _WIDTH, _ROW * len(drawn) + 1.1)
        figure = Drawn(figsize=size, layout="constrained")
        axes = figure.subplots()
        looks = (("a", "A", LIGHT.measured, "o", -0.13), ("b", "B", LIGHT.model, "^", 0.13))
        for side, label, colour, mark, beside in looks:
            scale = [100.0 / abs(one["a"]["value"]) for one in drawn.values()]
            apart = [one[side]["value"] - one["a"]["value"] for one in drawn.values()]
            stds = [one[side]["std"] for one in drawn.values()]
            axes.errorbar(
                [value * by for value, by in zip(apart, scale, strict=True)],
                [place + beside for place in range(len(drawn))],
                xerr=[
                    _INTERVAL * std * by if math.isfinite(std) else 0.0
                    for std, by in zip(stds, scale, strict=True)
                ],
                fmt=mark,
                color=colour,
                label=label,
                capsize=3,
            )
        axes.set_yticks(range(len(drawn)), list(drawn))
        axes.set_ylim(len(drawn) - 0.5, -0.5)
        axes.set_xlabel("difference from A [%], with 95 % intervals")
        figure.legend(loc="outside upper right", ncols=2, frameon=False)
    return figure
