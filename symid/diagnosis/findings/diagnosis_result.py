"""The result of a diagnosis: the gap, where it lies, which effects cause it, and how far it shrinks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import polars as pl

from symid.arrays import BoolArray, FloatArray
from symid.axis import Axis, Drive
from symid.diagnosis.findings.found_effects import Alternative, EffectParameter, FoundEffect, ParameterChange
from symid.diagnosis.findings.gap import Gap, Location, MapCell
from symid.diagnosis.findings.planned_experiment import Experiment
from symid.diagnosis.selection.evidence import Verdict
from symid.shown import Shown

if TYPE_CHECKING:
    from symid.diagnosis.fitting.state import State
    from symid.diagnosis.prediction.record import Record
    from symid.diagnosis.selection.step import SelectionStep


@dataclass(frozen=True, eq=False)
class WeightedError:
    """Force error of the last model, and its prediction, in the weights of the fit, at the samples of `Signals`."""

    error: FloatArray  # shape (n,): in deviations of the noise; 0 where it is not compared
    predicted: FloatArray  # shape (n,): predicted force, weighted alike
    noise: FloatArray  # shape (m,): auto-correlation of the error that noise alone leaves, by lag in rows from 0 on


@dataclass(frozen=True, eq=False)
class Signals:
    """Signals of the validation data in the band of the gap, for plots."""

    time: FloatArray
    """Time in s; shape (n,)."""
    position: FloatArray
    velocity: FloatArray
    """`position`, `velocity`: of the driven joint; shape (n,)."""
    measured: FloatArray
    nominal: FloatArray
    reidentified: FloatArray
    explained: FloatArray
    """`measured`, `nominal`, `reidentified`, `explained`: drive force: measured, and as each model predicts it from the
    motion; nan where a model is missing; shape (n,)."""
    compared: BoolArray
    """Whether a sample belongs to the gap; standstills and the ends do not; shape (n,)."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Error density against noise density on the validation data."""

    frequency: FloatArray
    """Hz; shape (n,)."""
    reidentified: FloatArray
    explained: FloatArray
    noise: FloatArray
    """`reidentified`, `explained`, `noise`: force error of both models and noise, unit of the force / sqrt(Hz); shape
    (n,)."""


@dataclass(frozen=True, eq=False)
class DriveError:
    """The force error of one of several drives."""

    gap: Gap  # its size before and after
    signals: Signals  # for plots
    spectrum: Spectrum  # for plots
    weighted: WeightedError | None = None  # for its correlations


@dataclass(frozen=True)
class SimulatedParameter:
    """A physical parameter as identified from the simulator's log and from the machine's."""

    name: str
    unit: str
    """`name`, `unit`: the parameter."""
    simulated: float
    simulated_std: float
    """`simulated`, `simulated_std`: from the simulator's log."""
    machine: float
    machine_std: float
    """`machine`, `machine_std`: from the machine's, with the effects found."""
    differs: bool
    """Whether the two differ by more than their deviations allow."""


@dataclass(frozen=True)
class SimulatedEffect:
    """An effect that the simulator has beyond the declared axis."""

    effect: str
    at: str
    """`effect`, `at`: names of the effect and of its place."""
    parameters: Mapping[str, EffectParameter]
    """From the simulator's log."""
    machine: Mapping[str, EffectParameter] | None
    """From the machine's; None if the machine does not have it."""
    differs: bool
    """Whether the machine has it with values that differ by more than their deviations allow."""


@dataclass(frozen=True)
class Simulator:
    """Findings about a simulator, from its log."""

    log: str
    """Its source."""
    error: float
    """Error of the axis with these values and effects on that log, in multiples of the noise."""
    parameters: tuple[SimulatedParameter, ...]
    """Of the declared axis."""
    effects: tuple[SimulatedEffect, ...]
    """Found beyond it."""


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Shown):
    """Why simulation and machine differ."""

    axis: Axis
    """The declared axis."""
    measured: tuple[str, ...]
    """Sensors used."""
    logs: tuple[str, ...]
    """Sources of the identification log, and of the validation log if there is one."""
    verdict: Verdict
    """One of "no_gap", "parameters", "effect", "partly", "unexplained" and "recording"."""
    sentence: str
    """The verdict in one sentence."""
    gap: Gap
    """Its size before and after; of several drives, of the one whose force the re-identified model misses by most
    multiples of the noise, as are `location`, `maps`, `signals` and `spectrum`."""
    location: tuple[Location, ...]
    """Where it lies, largest share first."""
    maps: Mapping[str, tuple[MapCell, ...]]
    """The gap over ``band``, ``regime``, ``direction``, ``position``, ``drive force`` and ``time``."""
    effects: tuple[FoundEffect, ...]
    """Accepted effects, the strongest first: that which alone would leave the largest force error away from
    reversals."""
    alternatives: tuple[Alternative, ...]
    """All candidates, the most probable first."""
    probabilities: Mapping[str, float]
    """Of "no_gap", "parameters" and "unexplained"."""
    parameters: tuple[ParameterChange, ...]
    """Before and after."""
    faults: tuple[str, ...]
    """Faults of the recording."""
    assumptions: tuple[str, ...]
    """Assumptions of the diagnosis."""
    next_experiment: str
    """The next step, in words."""
    signals: Signals
    """For plots."""
    spectrum: Spectrum
    """For plots."""
    weighted: WeightedError | None = None
    """For correlations; None where the hidden motion of the last model grows without bound."""
    drives: tuple[DriveError, ...] = ()
    """Force error of each drive, if there are several."""
    simulated: Simulator | None = None
    """Findings from the log of a simulator, if one was given; it is then the nominal model."""
    planned: Experiment | None = None
    """The motion of the next experiment and its simulated result, if it was requested."""
    search: tuple[SelectionStep, ...] = field(default=(), repr=False)
    """The fitted models, from which the next experiment is designed; not written to files."""
    model: State | None = field(default=None, repr=False)
    """The model found, with the phases and moments of the validation log; not written to files."""

    @property
    def named(self) -> frozenset[tuple[str, str]]:
        """Names and places of the effects found."""
        return frozenset((one.effect, one.at) for one in self.effects)

    @property
    def headline(self) -> str:
        """Axis, sensors, verdict and its sentence."""
        return f"{self.axis.name} from {', '.join(self.measured)}, {self.verdict}: {self.sentence}"

    def to_frame(self) -> pl.DataFrame:
        """A polars data frame of kind, name, value, std, unit (SI): the parameters of the axis and of the effects.

        Values of the axis are those with the effects found; the kind is "physical", or the effect and its place.
        ``to_pandas`` and ``to_arrow`` give frames of other libraries.
        """
        rows = [("physical", p.name, p.explained, p.explained_std, p.unit) for p in self.parameters]
        rows += [
            (f"{found.effect} at {found.at}", name, one.value, one.std, one.unit)
            for found in self.effects
            for name, one in found.parameters.items()
        ]
        return pl.DataFrame(rows, schema=["kind", "name", "value", "std", "unit"], orient="row")

    @property
    def drive(self) -> Drive:
        """The drive whose force error is the gap."""
        named = (drive for drive in self.axis.drives if drive.signal == self.gap.signal)
        return next(named, self.axis.drives[0])

    @property
    def record(self) -> Record | None:
        """The identification log in the frequency domain; None if the search was not kept."""
        return self.search[0].before.state.prediction.record if self.search else None
