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
from symid.diagnosis.selection.evidence import Verdict
from symid.shown import Shown

if TYPE_CHECKING:
    from symid.diagnosis.experiment.design import Experiment
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
    """Signals of the validation data in the band of the gap, for plots.

    Parameters
    ----------
    time : array of shape (n,)
        s.
    position, velocity : array of shape (n,)
        Of the driven joint.
    measured, nominal, reidentified, explained : array of shape (n,)
        Drive force: measured, and as each model predicts it from the motion; nan where a model is missing.
    compared : bool array of shape (n,)
        Whether a sample belongs to the gap; standstills and the ends do not.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    measured: FloatArray
    nominal: FloatArray
    reidentified: FloatArray
    explained: FloatArray
    compared: BoolArray


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Error density against noise density on the validation data.

    Parameters
    ----------
    frequency : array of shape (n,)
        Hz.
    reidentified, explained, noise : array of shape (n,)
        Force error of both models and noise, unit of the force / sqrt(Hz).
    """

    frequency: FloatArray
    reidentified: FloatArray
    explained: FloatArray
    noise: FloatArray


@dataclass(frozen=True, eq=False)
class DriveError:
    """The force error of one of several drives."""

    gap: Gap  # its size before and after
    signals: Signals  # for plots
    spectrum: Spectrum  # for plots
    weighted: WeightedError | None = None  # for its correlations


@dataclass(frozen=True)
class SimulatedParameter:
    """A physical parameter as identified from the simulator's log and from the machine's.

    Parameters
    ----------
    name, unit : str
        The parameter.
    simulated, simulated_std : float
        From the simulator's log.
    machine, machine_std : float
        From the machine's, with the effects found.
    differs : bool
        Whether the two differ by more than their deviations allow.
    """

    name: str
    unit: str
    simulated: float
    simulated_std: float
    machine: float
    machine_std: float
    differs: bool


@dataclass(frozen=True)
class SimulatedEffect:
    """An effect that the simulator has beyond the declared axis.

    Parameters
    ----------
    effect, at : str
        Names of the effect and of its place.
    parameters : mapping of str to EffectParameter
        From the simulator's log.
    machine : mapping of str to EffectParameter or None
        From the machine's; None if the machine does not have it.
    differs : bool
        Whether the machine has it with values that differ by more than their deviations allow.
    """

    effect: str
    at: str
    parameters: Mapping[str, EffectParameter]
    machine: Mapping[str, EffectParameter] | None
    differs: bool


@dataclass(frozen=True)
class Simulator:
    """Findings about a simulator, from its log.

    Parameters
    ----------
    log : str
        Its source.
    error : float
        Error of the axis with these values and effects on that log, in multiples of the noise.
    parameters : tuple of SimulatedParameter
        Of the declared axis.
    effects : tuple of SimulatedEffect
        Found beyond it.
    """

    log: str
    error: float
    parameters: tuple[SimulatedParameter, ...]
    effects: tuple[SimulatedEffect, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Shown):
    """Why simulation and machine differ.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    measured : tuple of str
        Sensors used.
    logs : tuple of str
        Sources of the identification log, and of the validation log if there is one.
    verdict : str
        "no_gap", "parameters", "effect", "partly", "unexplained" or "recording".
    sentence : str
        The verdict in one sentence.
    gap : Gap
        Its size before and after; of several drives, of the one whose force the re-identified model misses by most
        multiples of the noise, as are `location`, `maps`, `signals` and `spectrum`.
    location : tuple of Location
        Where it lies, largest share first.
    maps : mapping of str to tuple of MapCell
        The gap over ``band``, ``regime``, ``direction``, ``position``, ``drive force`` and ``time``.
    effects : tuple of FoundEffect
        Accepted effects, the strongest first: that which alone would leave the largest force error away from reversals.
    alternatives : tuple of Alternative
        All candidates, the most probable first.
    probabilities : mapping of str to float
        Of "no_gap", "parameters" and "unexplained".
    parameters : tuple of ParameterChange
        Before and after.
    faults : tuple of str
        Faults of the recording.
    assumptions : tuple of str
        Assumptions of the diagnosis.
    next_experiment : str
        The next step, in words.
    signals : Signals
        For plots.
    spectrum : Spectrum
        For plots.
    weighted : WeightedError or None
        For correlations; None where the hidden motion of the last model grows without bound.
    drives : tuple of DriveError
        Force error of each drive, if there are several.
    simulated : Simulator or None
        Findings from the log of a simulator, if one was given; it is then the nominal model.
    planned : Experiment or None
        The motion of the next experiment and its simulated result, if it was requested.
    search : tuple of SelectionStep
        The fitted models, from which the next experiment is designed; not written to files.
    model : State or None
        The model found, with the phases and moments of the validation log; not written to files.
    """

    axis: Axis
    measured: tuple[str, ...]
    logs: tuple[str, ...]
    verdict: Verdict
    sentence: str
    gap: Gap
    location: tuple[Location, ...]
    maps: Mapping[str, tuple[MapCell, ...]]
    effects: tuple[FoundEffect, ...]
    alternatives: tuple[Alternative, ...]
    probabilities: Mapping[str, float]
    parameters: tuple[ParameterChange, ...]
    faults: tuple[str, ...]
    assumptions: tuple[str, ...]
    next_experiment: str
    signals: Signals
    spectrum: Spectrum
    weighted: WeightedError | None = None
    drives: tuple[DriveError, ...] = ()
    simulated: Simulator | None = None
    planned: Experiment | None = None
    search: tuple[SelectionStep, ...] = field(default=(), repr=False)
    model: State | None = field(default=None, repr=False)

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
