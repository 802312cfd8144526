"""Exported units for co-simulation, run by FMPy one step after the other."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np


def run_unit(
    file: Path,
    inputs: Mapping[str, np.ndarray],
    signal: str,
    period: float,
    settings: Mapping[str, float] | None = None,
) -> np.ndarray:
    """Readings of a signal after each step, in which every input is held."""
    description = fmpy.read_model_description(str(file))
    places = {v.name: v.valueReference for v in description.modelVariables}
    unit = fmpy.fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="axis",
    )
    assert unit.fmi2GetReal is not None
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    for name, value in (settings or {}).items():
        unit.setReal([places[name]], [value])
    read = []
    for k, values in enumerate(zip(*inputs.values(), strict=True)):
        unit.setReal([places[name] for name in inputs], [float(value) for value in values])
        unit.doStep(currentCommunicationPoint=k * period, communicationStepSize=period)
        read.append(unit.getReal([places[signal]])[0])
    unit.terminate()
    unit.freeInstance()
    return np.array(read)
