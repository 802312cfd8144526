"""Names of the figures that commands print or write."""

from symid.report.figures.colours import palette_of as palette_of
from symid.report.figures.drawn import save_figure as save_figure
from symid.report.figures.foreign_figure import plot_foreign as plot_foreign
from symid.report.figures.identification_figure import plot_identification as plot_identification
from symid.report.figures.schematic import draw_schematic as draw_schematic
from symid.report.figures.tuning_figure import (
    plot_total_tuning as plot_total_tuning,
    plot_tuning as plot_tuning,
)
