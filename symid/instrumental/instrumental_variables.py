"""`identify_by_instruments`: least squares, refined with instruments from a noise-free simulation.

Each round simulates the axis along the reference of every log with the parameters of the round before. The simulated
logs are prepared like the real ones, and their rows are the instruments of the next estimate
X = (Z'S^2 W)^-1 Z'S^2 y. Z has the columns of W without their noise. If Z is independent of the noise, the estimate is
consistent: it avoids the errors-in-variables bias of least squares (A. Janot, P.-O. Vandanjon, M. Gautier, IEEE Trans.
Control Systems Technology 22(1), 2014).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel, compiled, declared_delays
from symid.data import Log
from symid.errors import SettingError
from symid.identification import (
    Constraints,
    Identification,
    Preparation,
    Run,
    excerpts,
    found_from,
    identify_by_least_squares,
    logs_with_steps,
    observe,
    with_checks,
    with_constraint_check,
)
from symid.identification.parameters import open_by_structure
from symid.instrumental.instrumental_fit import InstrumentalFit, estimate_by_instruments
from symid.instrumental.recorded_gains import cascade_of_log
from symid.simulation import ClosedLoop, feedthrough_of, plant_of

_MOST_ROUNDS = 4
_SETTLED = 0.05
"""Change of every parameter, in standard deviations, below which the rounds end."""
_WEAK = 10.0
"""F statistic below which instruments are weak."""
_NONE = 1e-3
"""Canonical correlation below which instruments hold no information."""
_CURE = (
    "give the reference of this log, and of the machine's controller the gains (`controller`) and the rate "
    "(`rate_hz`), or take `method=wls`"
)


def identify_by_instruments(
    model: GeneratedModel,
    logs: Log | Sequence[Log],
    loop: ClosedLoop,
    *,
    preparation: Preparation | None = None,
    nominal: Mapping[str, float] | None = None,
    constraints: Constraints | None = None,
    examine: bool = True,
) -> Identification:
    """Identify the parameters of an axis by instrumental variables.

    Parameters
    ----------
    model : GeneratedModel
        Regressor and maps.
    logs : Log or sequence of Log
        Runs of one axis, with the signal ``reference``.
    loop : ClosedLoop
        The axis and its controller.
    preparation, nominal, constraints, examine
        As in `identify`; nominal physical parameters also start the simulation where least squares
        determines no value.

    Returns
    -------
    Identification
        Its method is "iv". The status is "weak_instruments" if the axis cannot be simulated or the simulation does not
        resemble the log.

    Raises
    ------
    LogError, SettingError
        If a log does not have the reference or a signal, or a setting is not possible.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.codegen import load_generated
    >>> from symid.simulation import ClosedLoop, chirp, plant_of, simulate, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    >>> reference = chirp(0.5, 5.0, 4.0, 0.01, sampling_period=1e-3)
    >>> noisy = axis.with_signal("q", noise=1e-5)
    >>> log = simulate(noisy, values, reference, tuned_cascade(plant_of(axis, values), "q")).log
    >>> settings = Preparation(cutoff_hz=40.0, held=True)
    >>> found = identify_by_instruments(load_generated("rigid_1m"), log, ClosedLoop(axis), preparation=settings)
    >>> round(found.physical_parameters["M"], 2)
    5.0
    """
    model, runs = compiled(model), (logs,) if isinstance(logs, Log) else tuple(logs)
    for log in runs:
        loop.check(log)
    plain = partial(
        identify_by_least_squares,
        model,
        preparation=preparation,
        nominal=nominal,
        constraints=constraints,
        examine=False,
    )
    first = plain(runs)
    if first.fit.status != "ok":
        return replace(first, fit=replace(first.fit, method="iv"))
    others, completed = logs_with_steps(loop.axis, first, runs, feedthrough_of, preparation=preparation)
    if completed:
        runs = tuple(log for log in others if isinstance(log, Log))
        first = plain(runs)
    start = _possible(first, nominal, loop.axis)
    loop, controlled = _with_controller(loop, runs, first, start)
    found, Z, weak = _refined(model, runs, loop, first, start, nominal, constraints)
    if weak:
        return replace(found, fit=replace(found.fit, method="iv"), status="weak_instruments", message=weak)
    found = replace(found, notes=(*found.notes, *([completed] if completed else []), controlled))
    return (
        with_checks(found, excerpts(model, runs, found.observations), runs, Z)
        if examine
        else with_constraint_check(found)
    )


def _refined(
    model: GeneratedModel,
    logs: Sequence[Log],
    loop: ClosedLoop,
    first: Identification,
    start: Mapping[str, float],
    nominal: Mapping[str, float] | None,
    constraints: Constraints | None,
) -> tuple[Identification, tuple[FloatArray, ...], str]:
    """The estimate after rounds of simulation and estimation, its instruments, and their fault if they have one."""
    # Instruments are rows of the axis simulated with the last estimate: without the noise of the log, but correlated
    # with its motion. They improve with the estimate until that settles.
    given: Any = {"nominal": nominal or start, "constraints": constraints}
    Z: tuple[FloatArray, ...] = ()
    rows = [Run.again(model, *pair) for pair in zip(logs, first.observations, strict=True)]
    found, weak, parameters = first, "", start
    for _ in range(_MOST_ROUNDS):
        try:
            Z = _instruments(model, logs, loop, first, parameters)
        except SettingError as error:
            cure = ", give `nominal`" if nominal is None else ""
            fault = f"{found.message}; " if found.status == "not_physical" else ""
            return found, Z, f"{fault}the axis cannot be simulated with the parameters found{cure}: {error}"
        result = estimate_by_instruments(first.observations, Z, first.fit)
        if result.correlation < _NONE:
            return found, Z, f"the simulated axis does not move as the log does: {_CURE}"
        latest = found_from(model, logs, rows, result.fit, instruments=Z, **given)
        moved = np.abs(latest.fit.solution - found.fit.solution) / latest.standard_deviations
        found, weak = latest, _weakness(latest, result)
        if np.all(moved < _SETTLED):
            break
        parameters = _possible(found, nominal, loop.axis)
    return found, Z, weak


def _possible(found: Identification, nominal: Mapping[str, float] | None, axis: Axis) -> dict[str, float]:
    """Parameters to simulate with: the estimates, with friction and damping at least 0; nominal ones otherwise.

    What no log of these signals determines, as the zero of an encoder that is not recorded, is 0 if that is possible.
    """
    signed = set(found.model.signed)
    given = dict.fromkeys(signed.intersection(open_by_structure(found.model)), 0.0) | dict(nominal or {})
    values = {name: value for name, value in found.physical_parameters.items() if np.isfinite(value)}
    values = given | {name: value if name in signed else max(value, 0.0) for name, value in values.items()}
    try:
        plant_of(axis, values)
    except SettingError:  # no machine has these masses
        return values if nominal is None else given
    return values


def _with_controller(
    loop: ClosedLoop, logs: Sequence[Log], first: Identification, start: Mapping[str, float]
) -> tuple[ClosedLoop, str]:
    """The loop with its controller, and a note on it.

    Without a given controller there are two candidates: a cascade tuned to the axis, and one whose gains are read from
    the log. The one whose simulated forces are nearer to the recorded forces is taken.
    """
    if loop.controller is not None:
        return loop, "instruments: the axis simulated under the given controller"
    log, positions = logs[0], loop.axis.controlled_signals
    tuned = "instruments: the axis simulated under a cascade tuned to it"
    if any(position not in log.signals for position in positions):
        return loop, tuned
    cutoff = first.observations[0].preparation.cutoff_hz
    assert cutoff is not None
    forces = [drive.signal for drive in loop.axis.drives]
    own = zip(forces, positions, loop.reference_columns(log), strict=True)
    found = [cascade_of_log(log, force, position, cutoff, column) for force, position, column in own]
    read = tuple(cascade for cascade in found if cascade is not None)
    if len(read) < len(found):
        return loop, tuned
    recorded, misfits = np.stack([log[force] for force in forces]), []
    # The controller whose simulated force is nearer to the recorded one makes the stronger instruments.
    for candidate in (replace(loop, controller=read), loop):
        try:
            simulated = candidate.run(start, log)
            misfits.append(float(np.linalg.norm(np.stack([simulated[force] for force in forces]) - recorded)))
        except SettingError:
            misfits.append(np.inf)
    if misfits[0] >= misfits[1]:
        return loop, tuned
    gains = "; ".join(
        f"Kpp {one.position_gain:.3g}, Kpv {one.velocity_gain:.3g}, Kiv {one.integral_gain:.3g}"
        for one in read
    )
    text = f"instruments: the axis simulated under a cascade read from the log ({gains})"
    return replace(loop, controller=read), text


def _instruments(
    model: GeneratedModel,
    logs: Sequence[Log],
    loop: ClosedLoop,
    first: Identification,
    parameters: Mapping[str, float],
) -> tuple[FloatArray, ...]:
    """Rows of the simulated logs, prepared like those of the real logs."""
    rows = []
    for log, seen in zip(logs, first.observations, strict=True):
        # The simulation records forces as commanded at each sample. They act half a hold later on average.
        late = dict.fromkeys(model.delays, 0.0) | declared_delays(loop.axis)
        late |= {force: late.get(force, 0.0) - loop.held_for(log) / 2 for force in model.forces}
        rows.append(observe(model, loop.run(parameters, log), replace(seen.preparation, late=late)).W)
    return tuple(rows)


def _weakness(found: Identification, result: InstrumentalFit) -> str:
    strength = result.strength(found.correlated.effective_samples)
    if strength >= _WEAK:
        return ""
    return (
        f"the simulated axis hardly resembles the log (canonical correlation {result.correlation:.2g}, F "
        f"{strength:.2g}, {_WEAK:g} is required): {_CURE}"
    )
