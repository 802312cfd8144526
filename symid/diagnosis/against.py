"""Diagnosis of a machine against the user's own simulator, from logs of both under the same reference.

1. The axis is fitted to the simulator's log, with the effects that the simulator has beyond the axis.
2. This model is the nominal one. It is fitted to the machine's log without the effects that this log does not need: the
   simulator has them, and the machine does not.
3. Effects are selected that explain the remaining error: the machine has them, and the simulator lacks them.

The noise of the machine's readings is added to the simulator's log, so that small numerical errors of a simulator
without noise do not count as effects.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.effects import LIBRARY, Effect, Placed, declared_effects, effects_named
from symid.diagnosis.findings.comparison import compared
from symid.diagnosis.findings.conclusion import concluded
from symid.diagnosis.findings.diagnosis_result import (
    Diagnosis,
    SimulatedEffect,
    SimulatedParameter,
    Simulator,
)
from symid.diagnosis.findings.found_effects import EffectParameter, ParameterChange
from symid.diagnosis.findings.parameter_changes import effect_values
from symid.diagnosis.findings.wording import sentence_against
from symid.diagnosis.fitting.applied import applied
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import ITERATIONS, converged, fitted
from symid.diagnosis.fitting.start import fitted_axis, starting_parameters
from symid.diagnosis.fitting.state import State, first_state, with_effects
from symid.diagnosis.in_motion.motion import with_motion
from symid.diagnosis.prediction.data import LogsByPurpose, Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.preparation import repaired
from symid.diagnosis.prediction.record import Record, record_of
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.backward import backward_elimination
from symid.diagnosis.selection.forward import forward_selection
from symid.diagnosis.selection.step import fits_of
from symid.diagnosis.thresholds import THRESHOLDS
from symid.simulation import Cascade

_DIFFERS_DEVIATIONS = 4.0  # deviations of the difference
_DIFFERS_SHARE = 0.01  # of the value


def diagnose_against(
    axis: Axis,
    log: Log,
    simulated: Log,
    *,
    validation: Log | None = None,
    late: Mapping[str, float] | None = None,
    held: bool | None = None,
    library: Sequence[Effect | str] = LIBRARY,
    controller: Cascade | Sequence[Cascade] | None = None,
) -> Diagnosis:
    """Diagnose why a machine and a simulator of it differ.

    Parameters
    ----------
    axis : Axis
        The declared axis, whose parameters and effects describe both.
    log : Log
        A log of the machine.
    simulated : Log
        A log of the simulator with the same signals, if possible under the same reference.
    validation, late, held, library, controller
        As for `diagnose`; signals of both logs are taken as recorded alike.

    Returns
    -------
    Diagnosis
        Its nominal model is the simulator, its effects are those that the simulator lacks; `simulated` holds the
        findings from the simulator's log.

    Raises
    ------
    LogError
        If a log is too short or holds no position.
    SettingError
        If no parameters can be identified from the simulator's log to begin with.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    >>> noisy = axis.with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
    >>> reference = trapezoids(0.1, [0.1, 0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    >>> loop = tuned_cascade(plant_of(axis, values), "q")
    >>> machine, simulator = (
    ...     simulate(noisy, values | {"Fs": level}, reference, loop, seed=seed).log
    ...     for seed, level in enumerate((36.0, 30.0))
    ... )
    >>> found = diagnose_against(axis, machine, simulator, held=True)
    >>> found.verdict, [p.name for p in found.simulated.parameters if p.differs]
    ('parameters', ['Fs'])
    """
    whole = repaired(axis, [log, validation] if validation else [log])
    recording = Recording(dict(late or {}), held, decimation=whole.decimation)
    logs = LogsByPurpose(joined(whole.logs[:1]), joined(whole.logs[1:]) if validation else None)
    data = data_of(axis, logs, recording)
    holds = replace(recording, decimation=1).holds(axis, simulated.sampling_period)
    noisy = as_noisy(simulated, data.record)
    own = record_of(data.record.dynamics, noisy, None, recording.delays(axis), holds)
    effects = effects_named(library)
    model = _simulator(own, effects)
    state, weighting = applied(model.state, data.record, data.training)
    base = _machine(state, weighting)
    shared = {item.key for item in base.state.placed}
    placed = tuple(item for item in state.placed if item.key in shared)
    start = Fit(with_effects(state, weighting, placed), weighting)
    steps = forward_selection(base, effects, start if len(data.record.dynamics.bodies) > 1 else None)
    steps = backward_elimination(steps, effects)
    fits = fits_of(steps[0].before, steps)
    comparison = compared(data.validation, model.state, fits, data.held_out)
    found = concluded(comparison, steps, fits, model.parameters, (log, validation))
    simulator = _described(model, fits[-1] if found.effects else base, found.parameters, simulated.source)
    found = with_motion(found, comparison, logs, data.held_out, controller=controller, simulated=simulated)
    return replace(
        found,
        sentence=sentence_against(found, simulator),
        assumptions=(*found.assumptions, _assumption(simulator)),
        faults=(*whole.notes, *found.faults),
        simulated=simulator,
    )


def as_noisy(log: Log, like: Record) -> Log:
    """A log with white noise added up to the density of the noise of a record, so that both get equal weights."""
    own = record_of(like.dynamics, log)
    rate = log.sampling_frequency / like.log.sampling_frequency
    levels = dict(zip(_signals(like), like.noise * np.sqrt(rate), strict=True))
    rng, signals = np.random.default_rng(0), dict(log.signals)
    for name, level in zip(_signals(own), own.noise, strict=True):
        lacking = np.sqrt(max(levels.get(name, 0.0) ** 2 - level**2, 0.0))
        signals[name] = log[name] + lacking * rng.standard_normal(log.n_samples)
    return replace(log, signals=signals)


def _signals(record: Record) -> tuple[str, ...]:
    """Signals in the order of the noise: driven positions, forces, other sensors."""
    return *record.driven, *record.outputs


def _simulator(record: Record, library: Sequence[Effect]) -> Fit:
    """The axis with the effects that the simulator has, fitted to its log."""
    model = fitted_axis(*first_state(record, starting_parameters(record.dynamics.axis, record)))
    for step in forward_selection(model, library):
        if step.accepts:
            model = step.best.fit
    return model


def _machine(state: State, weighting: Weighting) -> Fit:
    """The simulator's model fitted to the machine's log, without the effects that this log does not need."""
    model = converged(state, weighting)
    for item in model.state.placed[len(declared_effects(state.prediction)) :]:
        others = tuple(other for other in model.state.placed if other.key != item.key)
        without = fitted(with_effects(model.state, model.weighting, others), model.weighting, ITERATIONS)
        gain = model.predicted - without.predicted
        if gain - THRESHOLDS.penalty * item.n_free < THRESHOLDS.least_penalised_gain:
            model = without
    return model


def _described(model: Fit, machine: Fit, changes: Sequence[ParameterChange], source: str) -> Simulator:
    stds = dict(zip(model.parameters, model.standard_deviations, strict=False))
    of_machine = dict(zip((p.key for p in machine.state.placed), effect_values(machine), strict=True))
    effects = [
        _effect_beside(item, values, of_machine.get(item.key))
        for item, values in zip(model.state.placed, effect_values(model), strict=True)
    ]
    parameters = tuple(_beside(change, float(stds[change.name])) for change in changes)
    return Simulator(source, float(np.sqrt(model.mean_square)), parameters, tuple(effects))


def _effect_beside(
    item: Placed, simulated: Mapping[str, EffectParameter], machine: Mapping[str, EffectParameter] | None
) -> SimulatedEffect:
    """An effect of the simulator and of the machine; values that belong to a log, such as a phase, may differ."""
    both = [] if machine is None or item.effect.per_log else [(simulated[x], machine[x]) for x in simulated]
    differs = any(_differs(a.value, a.std, b.value, b.std) for a, b in both)
    return SimulatedEffect(*item.key, simulated, machine, differs)


def _differs(value: float, std: float, other: float, other_std: float) -> bool:
    deviation = _DIFFERS_DEVIATIONS * np.hypot(std, other_std)
    return bool(abs(other - value) > max(deviation, _DIFFERS_SHARE * abs(value)))


def _beside(change: ParameterChange, std: float) -> SimulatedParameter:
    return SimulatedParameter(
        name=change.name,
        unit=change.unit,
        simulated=change.nominal,
        simulated_std=std,
        machine=change.explained,
        machine_std=change.explained_std,
        differs=_differs(change.nominal, std, change.explained, change.explained_std),
    )


def _assumption(simulator: Simulator) -> str:
    return (
        f"The axis with values and effects identified from {simulator.log} represents the simulator, which leaves "
        f"{simulator.error:.2g} times the machine's noise."
    )
