"""Bode diagrams of a diagnosed axis beside the measured response, where the log excites the axis."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from bokeh.models.annotations.geometry import Span
from bokeh.models.plots import GridPlot
from bokeh.models.sources import ColumnDataSource
from bokeh.models.tickers import FixedTicker

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis import Diagnosis
from symid.diagnosis.in_motion import explained_response
from symid.report.figures.colours import EXPLAINED, INK, MEASURED, MODEL, NOISE
from symid.report.pages.page_plots import Curve, draw_curves, new_plot, stacked, with_one_crosshair
from symid.simulation.plants import COHERENT, FrequencyResponse, degrees_of, has_response, response_of

_MOST_SENSORS = 2
_BEYOND = 1.25
"""Multiple of the highest excited frequency up to which a response is drawn."""


@dataclass(frozen=True, eq=False)
class _ComparedResponse:
    """A response of the re-identified axis beside the measured one, and that with the effects found, if any."""

    of: FrequencyResponse
    explained: ComplexArray | None


def bode_plots(diagnosis: Diagnosis) -> dict[str, GridPlot]:
    """Bode diagrams by the first sensors' names; none with several drives, no search, or an axis hardly excited."""
    if diagnosis.drives:
        return {}
    compared = (_compared_response(diagnosis, signal) for signal in diagnosis.measured[:_MOST_SENSORS])
    return {
        f"response of {response.of.signal}": _bode(response) for response in compared if response is not None
    }


def _compared_response(diagnosis: Diagnosis, signal: str) -> _ComparedResponse | None:
    """Responses of a sensor; None where the axis or the measured response is not determined well enough."""
    values = {change.name: change.reidentified for change in diagnosis.parameters}
    if diagnosis.record is None or not has_response(diagnosis.axis, values):
        return None
    of = response_of(diagnosis.axis, values, signal, [diagnosis.record.log], diagnosis.record.late)
    if not of.top_hz:
        return None
    return _ComparedResponse(of, explained_response(diagnosis, of) if diagnosis.effects else None)


def _bode(response: _ComparedResponse) -> GridPlot:
    """Magnitude, phase and coherence below each other."""
    of = response.of
    source, sizes = _columns(response)
    label = f"{of.quantity} / {of.force} [{of.unit}]"
    seen = (float(sizes.min()) / 2, float(sizes.max()) * 2)
    along: Any = {"x_axis_type": "log"}
    magnitude = new_plot(f"response of {of.signal}", label, 300, y_axis_type="log", y_range=seen, **along)
    draw_curves(magnitude, source, _curves("magnitude", response), "frequency")
    phase = new_plot(f"phase of {of.signal}", "phase [°]", 150, magnitude, y_range=(-190, 190), **along)
    draw_curves(
        phase, source, [replace(curve, label="") for curve in _curves("phase", response)], "frequency"
    )
    phase.yaxis.ticker = FixedTicker(ticks=[-180, -90, 0, 90, 180])
    name = f"coherence of {of.signal}"
    coherence = new_plot(name, "coherence", 150, magnitude, y_range=(0, 1.03), **along)
    draw_curves(coherence, source, [Curve("coherence", "", NOISE)], "frequency")
    coherence.add_layout(Span(location=COHERENT, dimension="width", line_color=INK, line_dash="dashed"))
    coherence.yaxis.ticker = FixedTicker(ticks=[0, 0.5, 1])
    coherence.xaxis.axis_label = "frequency [Hz]"
    with_one_crosshair(magnitude, phase, coherence)
    return stacked(magnitude, phase, coherence)


def _curves(quantity: str, response: _ComparedResponse) -> list[Curve]:
    """Measured points and computed curves of the magnitude or the phase."""
    return [
        Curve(f"{quantity}_doubtful", f"coherence below {COHERENT}", MEASURED, 3, True, 0.25),
        Curve(f"{quantity}_measured", "measured", MEASURED, 5, True, 0.8),
        Curve(f"{quantity}_reidentified", "re-identified", MODEL, 1.6),
        *(
            [Curve(f"{quantity}_explained", "with effects", EXPLAINED, 1.6)]
            if response.explained is not None
            else []
        ),
    ]


def _columns(compared: _ComparedResponse) -> tuple[ColumnDataSource, FloatArray]:
    """Columns of the plots, and the sizes that must be seen."""
    of = compared.of
    shown = of.frequency <= _BEYOND * of.top_hz
    models = {"reidentified": of.identified[shown]}
    if compared.explained is not None:
        models["explained"] = compared.explained[shown]
    measured, sure = of.measured[shown], of.is_coherent[shown]
    columns = {"coherence": of.coherence[shown]}
    for quantity, value in (("magnitude", np.abs), ("phase", lambda h: np.rad2deg(np.angle(h)))):
        columns[f"{quantity}_measured"] = np.where(sure, value(measured), np.nan)
        columns[f"{quantity}_doubtful"] = np.where(sure, np.nan, value(measured))
    for name, response in models.items():
        columns[f"magnitude_{name}"], columns[f"phase_{name}"] = np.abs(response), degrees_of(response)
    thin = {name: values.astype(np.float32) for name, values in columns.items()}
    sizes = np.abs(np.concatenate([*models.values(), measured[sure]]))
    return ColumnDataSource({"frequency": of.frequency[shown], **thin}), sizes
