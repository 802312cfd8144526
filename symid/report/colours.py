"""Colours of Okabe and Ito's set, told apart by colour-blind readers and in grey print."""

from __future__ import annotations

MEASURED, MODEL, RESIDUAL = "#0072B2", "#D55E00", "#555555"
EXPLAINED, NOMINAL, NOISE = "#009E73", "#CC79A7", "#777777"
INK = "#222222"
