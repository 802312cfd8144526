"""Colours of Okabe and Ito's set, distinguishable by colour-blind readers and in grey print."""

from dataclasses import dataclass
from typing import Any

MEASURED, MODEL = "#0072B2", "#D55E00"
EXPLAINED, NOMINAL, NOISE = "#009E73", "#CC79A7", "#777777"
INK, PAPER = "#222222", "#FFFFFF"

DARK_FILTER = "invert(0.91) hue-rotate(180deg)"
"""CSS filter that makes a light picture dark and keeps its hues; a picture saved from the page stays light."""


def in_dark(colour: str) -> str:
    """Colour #RRGGBB after `DARK_FILTER`, for elements beside a filtered picture.

    Inverting maps a channel c to 0.91 - 0.82 c; turning the hue by half a circle mirrors each channel at the luminance
    Y (W3C Filter Effects, weights 0.213, 0.715, 0.072): together 0.91 + 0.82 (c - 2 Y).

    >>> in_dark("#FFFFFF"), in_dark(MEASURED)
    ('#171717', '#4dabdf')
    """
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    luminance = sum(weight * c for weight, c in zip((0.213, 0.715, 0.072), channels, strict=True))
    turned = (0.91 + 0.82 * (c - 2 * luminance) for c in channels)
    return "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in turned)


@dataclass(frozen=True)
class Palette:
    """Colours of a figure. Measured curves are wide and pale, computed ones thin and strong, also in grey print."""

    # paper, ink, grid: background, text and lines, and lines behind the curves
    paper: str
    ink: str
    grid: str
    # measured, model, residual, other: curves; `other` is a third one
    measured: str
    model: str
    residual: str
    other: str
    fill: str  # areas, such as a body or a confidence ellipse

    @property
    def style(self) -> Any:
        """Settings of matplotlib."""
        named = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
        return {
            "font.size": 9,
            "text.parse_math": False,  # names of columns may hold dollars
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "grid.color": self.grid,
            "grid.linewidth": 0.6,
            "figure.facecolor": self.paper,
            "savefig.facecolor": self.paper,
            "axes.facecolor": self.paper,
            "legend.facecolor": self.paper,
            **dict.fromkeys(named, self.ink),
        }


LIGHT = Palette(PAPER, INK, "#E3E3E3", "#8CC5E8", "#C04C00", "#444444", "#007D5C", "#DCE9F2")
DARK = Palette("#14181C", "#E6E6E6", "#343B42", "#3F77A3", "#FFA552", "#C4C4C4", "#5FD3AE", "#27384A")


def palette_of(dark: bool) -> Palette:
    """The palette for a dark or a light background."""
    return DARK if dark else LIGHT
