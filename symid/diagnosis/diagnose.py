"""The diagnosis from a log to its verdict: the table of contents of this room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.comparison import Comparison, compared
from symid.diagnosis.effects import LIBRARY, Effect
from symid.diagnosis.evidence import INDISTINGUISHABLE, Outcome, is_there, odds, outcome
from symid.diagnosis.faults import recording_faults
from symid.diagnosis.fit import Fit, first_state, unfitted
from symid.diagnosis.location import located, maps
from symid.diagnosis.record import Record, record_of
from symid.diagnosis.rejudging import judged_together
from symid.diagnosis.result import (
    Alternative,
    Diagnosis,
    EffectParameter,
    FoundEffect,
    Level,
    ParameterChange,
    Verdict,
)
from symid.diagnosis.screening import AR_ORDER
from symid.diagnosis.search import Turn, search
from symid.diagnosis.start import NOISE_ALONE, fitted_axis, starting_parameters
from symid.diagnosis.weighting import autoregression
from symid.diagnosis.wording import next_experiment, sentence
from symid.identification.settings import timing
from symid.simulation.plant import forward_dynamics

_HELD_OUT = 3
_BLOCKS = 12
_ABSORBED_DEVIATIONS = 3.0
_ABSORBED_SHARE = 0.01
_LISTED = 20
Recorded: TypeAlias = tuple[Mapping[str, float] | None, bool | None]
"""How signals were recorded: what `diagnose` takes as `late` and as `held`."""
_ONLY_IN_VALIDATION = (
    "The model fits the log: the effect shows in the validation log alone. It was identified from two thirds of that, "
    "and the gap measured on the rest."
)


def diagnose(
    axis: Axis,
    log: Log,
    *,
    validation: Log | None = None,
    nominal: Mapping[str, float] | None = None,
    late: Mapping[str, float] | None = None,
    held: bool | None = None,
    library: Sequence[Effect] = LIBRARY,
) -> Diagnosis:
    """Why simulation and machine differ.

    Parameters
    ----------
    axis : Axis
        The declared axis: the simulation.
    log : Log
        A log of the machine, from which everything is identified.
    validation : Log, optional
        Another log, on which the gap is measured; every third part of `log` by default, which then takes no part in
        the identification.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    late : mapping of str to float, optional
        Time by which signals were recorded late, s; negative for a force that acts later than recorded.
    held : bool, optional
        Whether the force is held from sample to sample, so that it acts half a sample later than it is recorded; as
        the axis declares it if not given.
    library : sequence of Effect
        Effects that are considered.

    Raises
    ------
    LogError
        If a log is too short or holds no position.
    SettingError
        If there are no nominal values and none can be identified to begin with.

    Examples
    --------
    >>> from symid.axis import load_axis, shipped_folder
    >>> from symid.identification import read_axis_log
    >>> axis = load_axis("emps")
    >>> files = (shipped_folder("data") / "emps" / name for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"))
    >>> log, other = (read_axis_log(axis, file, columns={"q": "qm"}) for file in files)
    >>> found = diagnose(axis, log, validation=other)
    >>> found.gap.reidentified.rms > found.gap.explained.rms
    True
    """
    found = _diagnosed(axis, (log, validation), nominal, (late, held), library)
    if validation is None or found.verdict != "unexplained" or not _fits_its_log(found):
        return found
    other = _diagnosed(axis, (validation, None), nominal, (late, held), library)
    if other.verdict != "effect":
        return found
    return replace(other, assumptions=(_ONLY_IN_VALIDATION, *other.assumptions))


def _fits_its_log(found: Diagnosis) -> bool:
    """Whether the re-identified model leaves no more than noise of the log that it was identified from."""
    return bool(found.search) and found.search[0].before.mean_square < NOISE_ALONE


def _diagnosed(
    axis: Axis,
    logs: tuple[Log, Log | None],
    nominal: Mapping[str, float] | None,
    recorded: Recorded,
    library: Sequence[Effect],
) -> Diagnosis:
    data = data_of(axis, *logs, recorded)
    start = dict(nominal) if nominal else starting_parameters(axis, data.record)
    state, weighting = first_state(data.record, start, data.training)
    base = fitted_axis(state, weighting)
    before = unfitted(state, weighting) if len(data.record.dynamics.bodies) > 1 else None
    turns = judged_together(search(base, library, before), data.validation, data.held_out)
    fits = fits_of(base, turns)
    comparison = compared(data.validation, state if nominal else None, fits, data.held_out)
    return concluded(comparison, turns, fits, nominal, logs)


def fits_of(base: Fit, turns: Sequence[Turn]) -> list[Fit]:
    """The re-identified model, and those with effects accepted one by one."""
    return [base, *(turn.confirmed[0].fit for turn in turns if turn.accepts)]


@dataclass(frozen=True, eq=False)
class Data:
    """What is identified from, and what the gap is measured on.

    Parameters
    ----------
    record, validation : Record
        Of the log and of the validation log; the same where there is none.
    training, held_out : bool array of shape (n_fine,) or None
        Parts of the log for either purpose, where one log serves both.
    """

    record: Record
    validation: Record
    training: BoolArray | None
    held_out: BoolArray | None


def data_of(axis: Axis, log: Log, validation: Log | None, recorded: Recorded = (None, None)) -> Data:
    """Logs in the frequency domain, see `diagnose`."""
    dynamics = forward_dynamics(axis)
    record = record_of(dynamics, log, None, timing_of(axis, log, recorded))
    if validation is None:
        return Data(record, record, *_parts(record))
    other = record_of(dynamics, validation, record.motion_hz, timing_of(axis, validation, recorded))
    return Data(record, other, None, None)


def timing_of(axis: Axis, log: Log, recorded: Recorded) -> dict[str, float]:
    """Time by which signals of a log were recorded late, a hold of the force included."""
    late, held = recorded
    held = axis.drive.held if held is None else held
    return timing(late or {}, axis.drive.signal, held=held, sampling_period=log.sampling_period)


def _parts(record: Record) -> tuple[BoolArray, BoolArray]:
    """Points of the fine grid for identification and for validation: every third of twelve parts is held out."""
    part = np.floor(record.fine_time / record.duration * _BLOCKS)
    held_out = np.asarray(part % _HELD_OUT == 1)
    return ~held_out, held_out


def concluded(
    comparison: Comparison,
    turns: Sequence[Turn],
    fits: Sequence[Fit],
    nominal: Mapping[str, float] | None,
    logs: tuple[Log, Log | None],
) -> Diagnosis:
    """The diagnosis that follows from a search.

    Parameters
    ----------
    comparison : Comparison
        The nominal model and `fits` on the validation data.
    turns : sequence of Turn
        Of the search.
    fits : sequence of Fit
        The re-identified model, and those with effects accepted one by one.
    nominal : mapping of str to float or None
        Nominal values.
    logs : tuple of Log
        What was identified from, and the validation log if there is one.
    """
    upheld = comparison.upheld
    comparison, fits = comparison.with_effects(upheld), fits[: 1 + upheld]
    gap, found = comparison.gap(), maps(comparison)
    floor = gap.noise_floor.rms
    chances = outcome(
        turns,
        upheld,
        gap.nominal.rms / floor if gap.nominal else None,
        gap.reidentified.rms / floor,
        gap.explained.rms / floor,
    )
    verdict: Verdict = chances.verdict  # type: ignore[assignment]  # one of its four names
    accepted = [turn for turn in turns if turn.accepts][:upheld] if verdict == "effect" else []
    if not accepted:
        comparison, fits = comparison.with_effects(0), fits[:1]
        gap, found = comparison.gap(), maps(comparison)
    effects = _effects(comparison, accepted, fits, chances)
    alternatives = _alternatives(comparison, turns[0], chances)
    faults = recording_faults(comparison, logs[0], accepted)
    axis = comparison.record.dynamics.axis
    return Diagnosis(
        axis=axis,
        measured=comparison.record.signals,
        logs=tuple(log.source for log in logs if log is not None),
        verdict=verdict,
        sentence=sentence(verdict, gap, effects, alternatives),
        gap=gap,
        location=located(comparison, found, _shares(comparison, accepted, turns)),
        maps=found,
        effects=effects,
        alternatives=alternatives,
        probabilities={k: v for k, v in chances.as_mapping.items() if k != "effect"},
        parameters=_parameters(fits, nominal),
        faults=faults,
        assumptions=_assumptions(comparison, logs[1]),
        next_experiment=next_experiment(verdict, effects, alternatives, comparison.record),
        signals=comparison.signals(),
        spectrum=comparison.spectrum(),
        search=tuple(turns),
    )


def driven(record: Record) -> str:
    """Body that the drive moves."""
    return next(
        body.name for body in record.dynamics.axis.free_bodies if body == record.dynamics.axis.drive.at
    )


def _effects(
    comparison: Comparison, accepted: Sequence[Turn], fits: Sequence[Fit], chances: Outcome
) -> tuple[FoundEffect, ...]:
    last, known = fits[-1], len(fits[0].state.placed)
    values = effect_values(last)[known:]
    found = []
    for i, turn in enumerate(accepted):
        chance = odds(turn, driven(comparison.record))
        item = last.state.placed[known + i]
        best, rivals = item.key, [k for k, p in chance.items() if p >= INDISTINGUISHABLE and k != item.key]
        there = chances.effect if i == 0 else is_there(turn)
        found.append(
            FoundEffect(
                effect=best[0],
                at=best[1],
                probability=there * chance[best],
                parameters=values[i],
                gap_after=comparison.level(i + 2),
                indistinguishable_from=tuple(rivals),
            )
        )
    return tuple(found)


def effect_values(fit: Fit) -> list[dict[str, EffectParameter]]:
    """Values of each effect with standard deviations, nan for those that are not free."""
    deviations = standard_deviations(fit)[len(fit.parameters) :]
    found, place = [], 0
    for item in fit.state.placed:
        n_amplitudes = 0 if item.effect.fixed else len(item.amplitudes)
        own = deviations[place : place + n_amplitudes + len(item.shape)]
        place += own.size
        stds = np.concatenate([np.full(len(item.amplitudes) - n_amplitudes, np.nan), own])
        values = zip(item.values(fit.state.scene), stds, strict=True)
        found.append({name: EffectParameter(value, float(std), unit) for (name, value, unit), std in values})
    return found


def standard_deviations(fit: Fit) -> FloatArray:
    """Of parameters and effects' values: errors taken as autoregressive."""
    noise = autoregression(fit.left, fit.weighting.kept, AR_ORDER)
    columns = noise.apply(fit.base)
    scale = np.linalg.norm(columns, axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    unit = columns / scale[:, None]
    inverse = np.linalg.pinv(unit @ unit.T, rcond=1e-13, hermitian=True)
    return np.asarray(np.sqrt(np.maximum(np.diag(inverse), 0.0)) / scale)[: len(fit.columns)]


def _alternatives(comparison: Comparison, turn: Turn, chances: Outcome) -> tuple[Alternative, ...]:
    chance = odds(turn, driven(comparison.record))
    confirmed = {c.key: c for c in turn.confirmed}
    gains = {c.placed.key: c.gain for c in turn.screened}
    found = []
    for key, probability in list(chance.items())[:_LISTED]:
        own = confirmed.get(key)
        level: Level | None = None
        if own is not None:
            rms = float(np.sqrt(own.fit.mean_square)) * comparison.unit
            level = Level(rms, rms / comparison.size)
        gain = gains[key] if own is None else own.gain
        found.append(Alternative(key[0], key[1], chances.effect * probability, gain, level))
    return tuple(found)


def _shares(comparison: Comparison, accepted: Sequence[Turn], turns: Sequence[Turn]) -> dict[str, float]:
    """Share of the excess error by place: what its effects take away; without effects, what they could."""
    shares: dict[str, float] = {}
    if not accepted:
        chance = odds(turns[0], driven(comparison.record)) if turns else {}
        for (_, place), probability in chance.items():
            shares[place] = shares.get(place, 0.0) + probability
        return shares
    powers = [max(float(np.mean(comparison.squares(i))) - 1, 0.0) for i in range(1, len(comparison.errors))]
    for turn, before, after in zip(accepted, powers[:-1], powers[1:], strict=True):
        place = turn.confirmed[0].key[1]
        shares[place] = shares.get(place, 0.0) + max(before - after, 0.0) / max(powers[0], 1e-12)
    left = 1 - sum(shares.values())
    if left > 0.005:
        shares["unexplained"] = left
    return shares


def _parameters(fits: Sequence[Fit], nominal: Mapping[str, float] | None) -> tuple[ParameterChange, ...]:
    base, last = fits[0], fits[-1]
    before, after = standard_deviations(base), standard_deviations(last)
    units = base.state.scene.axis.physical_parameters
    found = []
    for i, name in enumerate(base.parameters):
        old, new = base.parameters[name], last.parameters[name]
        limit = max(_ABSORBED_DEVIATIONS * before[i], _ABSORBED_SHARE * abs(new))
        found.append(
            ParameterChange(
                name=name,
                unit=str(units[name]),
                nominal=float(nominal[name]) if nominal and name in nominal else float("nan"),
                reidentified=old,
                reidentified_std=float(before[i]),
                explained=new,
                explained_std=float(after[i]),
                absorbed=len(fits) > 1 and bool(abs(new - old) > limit),
            )
        )
    return tuple(found)


def _assumptions(comparison: Comparison, validation: Log | None) -> tuple[str, ...]:
    record = comparison.record
    return (
        "Each sample is the value at its time; the force is compared as it is recorded.",
        f"Noise is white up to the Nyquist frequency, at the level found above {record.noise_from_hz:.0f} Hz.",
        "Standstills and 15 ms around them are left out: no model tells friction at rest.",
        "The gap is measured on "
        + (
            "parts of the log that took no part in the identification."
            if validation is None
            else "the validation log."
        )
        + " What belongs to a log (phases of disturbances in time, moments of changes) is fitted to it.",
    )
