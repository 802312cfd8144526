"""Exported units for co-simulation, run by FMPy one step after the other."""

from collections.abc import Mapping
from pathlib import Path

import fmpy
import fmpy.fmi3
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
    newer = description.fmiVersion == "3.0"
    unit = (fmpy.fmi3.FMU3Slave if newer else fmpy.fmi2.FMU2Slave)(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="axis",
    )
    unit.instantiate()
    put, get = (unit.setFloat64, unit.getFloat64) if newer else (unit.setReal, unit.getReal)
    if not newer:
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    for name, value in (settings or {}).items():
        put([places[name]], [value])
    read = []
    for k, values in enumerate(zip(*inputs.values(), strict=True)):
        put([places[name] for name in inputs], [float(value) for value in values])
        unit.doStep(currentCommunicationPoint=k * period, communicationStepSize=period)
        read.append(get([places[signal]])[0])
    unit.terminate()
    unit.freeInstance()
    return np.array(read)
