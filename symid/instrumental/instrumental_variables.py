"""`identify_by_instruments`: least squares, refined with instruments from a noise-free simulation.

Each round simulates the axis along the reference of every log with the parameters of the round before. The simulated
logs are prepared like the real ones, and their rows are the instruments of the next estimate
X = (Z'S^2 W)^-1 Z'S^2 y. Z has the columns of W without their noise. If Z is independent of the noise, the estimate is
consistent: it avoids the errors-in-variables bias of least squares (A. Janot, P.-O. Vandanjon, M. Gautier, IEEE Trans.
Control Systems Technology 22(1), 2014).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel, as_generated, declared_delays
from symid.data import Log
from symid.errors import SettingError
from symid.estimation import LeastSquares
from symid.identification import (
    Constraints,
    Identification,
    Observation,
    Preparation,
    excerpts,
    found_from,
    identify,
    observe,
    with_checks,
    with_constraint_check,
)
from symid.identification.physical import open_by_structure
from symid.instrumental.recorded_gains import cascade_of_log
from symid.simulation import ClosedLoop


@dataclass(frozen=True, eq=False)
class InstrumentalFit:
    """An estimate by instrumental variables, and how strong its instruments are."""

    # the parameters with their classical covariance; rank and conditions are those of least squares
    fit: LeastSquares
    # lowest canonical correlation between the columns of Z and of W: 1 if both span the same
    correlation: float

    def strength(self, effective_samples: float) -> float:
        """F of the weakest direction in the regression of W on Z, for a number of independent samples.

        Below about 10 instruments are weak (D. Staiger and J. Stock, Econometrica 65, 1997).
        """
        explained = min(self.correlation, 1.0) ** 2
        n = self.fit.solution.size
        return explained / max(1.0 - explained, 1e-12) * max(effective_samples - n, 0.0) / n


def estimate_by_instruments(
    observations: Sequence[Observation], instruments: Sequence[FloatArray], start: LeastSquares
) -> InstrumentalFit:
    """Estimate with instruments, one array of the shape of W for each observation.

    The start is the estimate by least squares from these rows, with all parameters determined: it gives the weights.
    """
    root, p = start.rank.inverse_root, start.solution.size
    cross, own, slope = np.zeros((p, p)), np.zeros((p, p)), np.zeros(p)
    for seen, Z, weights in zip(
        observations, instruments, start.weights.reshape(len(observations), -1), strict=True
    ):
        for j, weight in enumerate(weights):
            used = seen.valid[j]
            z, w = (weight * columns[j][used] @ root for columns in (Z, seen.W))
            # the estimate is a correction of the start: products with residuals lose fewer digits than with y
            rest = weight * (seen.y[j][used] - seen.W[j][used] @ start.solution)
            cross, own, slope = cross + z.T @ w, own + z.T @ z, slope + z.T @ rest
    gain = np.linalg.pinv(cross)  # instruments without information show in their correlation
    solution = start.solution + root @ (gain @ slope)
    values, vectors = np.linalg.eigh(own)
    # W T is orthonormal. With Z T made orthonormal too, the singular values are the canonical correlations.
    orthonormal = vectors / np.sqrt(np.maximum(values, np.finfo(float).tiny))
    correlation = float(np.linalg.svd(orthonormal.T @ cross, compute_uv=False)[-1])
    norms = np.array(
        [
            float(np.linalg.norm(y[used] - W[used] @ solution))
            for seen in observations
            for W, y, used in zip(seen.W, seen.y, seen.valid, strict=True)
        ]
    )
    sigma = float(np.linalg.norm(start.weights * norms)) / np.sqrt(max(sum(start.rows) - p, 1))
    spread = root @ gain
    fit = replace(
        start,
        method="iv",
        parameters=solution,
        solution=solution,
        covariance=sigma**2 * spread @ own @ spread.T,
        sigma_rho=sigma,
        sigma_rho_equation=norms / np.sqrt(np.maximum(np.array(start.rows) - p, 1)),
        residual_norm=norms,
    )
    return InstrumentalFit(fit, correlation)


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
    model, runs = as_generated(model), (logs,) if isinstance(logs, Log) else tuple(logs)
    for log in runs:
        loop.check(log)
    first = identify(
        model, runs, preparation=preparation, nominal=nominal, constraints=constraints, examine=False
    )
    if first.fit.status != "ok":
        return replace(first, fit=replace(first.fit, method="iv"))
    start = _possible(first, nominal)
    loop, controlled = _with_controller(loop, runs, first, start)
    found, weak = first, ""
    parameters = start
    # Instruments are rows of the axis simulated with the last estimate: without the noise of the log, but correlated
    # with its motion. They improve with the estimate until that settles.
    for _ in range(_MOST_ROUNDS):
        try:
            Z = _instruments(model, runs, loop, first, parameters)
        except SettingError as error:
            weak = f"the axis cannot be simulated with the parameters found, give `nominal`: {error}"
            break
        result = estimate_by_instruments(first.observations, Z, first.fit)
        if result.correlation < _NONE:
            weak = f"the simulated axis does not move as the log does: {_CURE}"
            break
        latest = found_from(
            model,
            runs,
            first.observations,
            result.fit,
            instruments=Z,
            nominal=nominal or start,
            constraints=constraints,
        )
        moved = np.abs(latest.fit.solution - found.fit.solution) / latest.standard_deviations
        found, weak = latest, _weakness(latest, result)
        if np.all(moved < _SETTLED):
            break
        parameters = _possible(found, nominal)
    if weak:
        return replace(found, fit=replace(found.fit, method="iv"), status="weak_instruments", message=weak)
    found = replace(found, notes=(*found.notes, controlled))
    return (
        with_checks(found, excerpts(model, runs, found.observations), runs, Z)
        if examine
        else with_constraint_check(found)
    )


def _possible(found: Identification, nominal: Mapping[str, float] | None) -> dict[str, float]:
    """Parameters to simulate with: the estimates, with friction and damping at least 0; nominal ones otherwise.

    What no log of these signals determines, as the zero of an encoder that is not recorded, is 0 if that is possible.
    """
    signed = set(found.model.signed)
    given = dict.fromkeys(signed.intersection(open_by_structure(found.model)), 0.0) | dict(nominal or {})
    values = {name: value for name, value in found.physical_parameters.items() if np.isfinite(value)}
    return given | {name: value if name in signed else max(value, 0.0) for name, value in values.items()}


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
