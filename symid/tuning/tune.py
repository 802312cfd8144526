"""`tune`: cutoff frequency and sampling period that keep the systematic errors below a bound, as [35]-[37]."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from symid.axis import Axis, of_any_axis
from symid.codegen import GeneratedModel, compiled
from symid.errors import SettingError
from symid.identification import Preparation, identify_by_least_squares
from symid.shown import Shown
from symid.signal_processing import differencing_bandwidth
from symid.simulation import Controller, Trajectory, plant_of, tuned_cascades
from symid.symbolic import derive, is_smooth, law_expression
from symid.tuning.bound import BoundSearch, Track, TuningStatus, lowest_within, tuning_status
from symid.tuning.exact_run import ExactRun, exact_run, tuning_chirp
from symid.tuning.low_pass import LowPassErrors, standard_model

ParameterKind = Literal["physical", "minimal"]

CUTOFF_DATA_HZ = 10_000.0
"""Sampling frequency of the data with exact derivatives, as in the paper."""
CONTROLLER_HZ = 20_000.0
"""Rate of the controller: at 100 Hz its held force differs from a continuous one by 4e-5."""
_DB_ONCE, _DB_EACH = 0.01, 0.0175  # dB: constant part, and part of each difference
_CUTOFFS, _RATES = 17, 15  # frequencies of the first scans


@dataclass(frozen=True, eq=False, repr=False)
class Tuning(Shown):
    """Settings that keep the systematic errors of an identification below their bounds."""

    axis: str
    """Name of the axis."""
    measured: tuple[str, ...]
    """Signals of the sensors."""
    order: int
    """Order of one pass of the low-pass filter."""
    cutoff: BoundSearch
    """Result of [35]: errors of the standard model with exact derivatives by cutoff frequency."""
    differences: int
    """Highest number m of successive differences in the model."""
    first_sampling_hz: float
    """First guess of the sampling frequency [36]."""
    sampling: BoundSearch
    """Result of [37]: errors of the model of the sensors by sampling frequency."""
    kind: ParameterKind
    """Parameters whose errors `sampling` bounds."""
    left_out: tuple[str, ...]
    """Parameters of laws that jump at standstill, without which the axis was tuned."""
    status: TuningStatus
    """Either "ok", or the reason why a bound does not decide; see `message`."""
    message: str
    """Meaning of the status and its cure; empty for "ok"."""

    @property
    def headline(self) -> str:
        """Status, cutoff and sampling frequency."""
        settings = f"cutoff {self.cutoff.frequency_hz:.4g} Hz, sampling {self.sampling.frequency_hz:.4g} Hz"
        return f"{self.axis} from {', '.join(self.measured)}, {self.status}: {settings}"

    @property
    def sampling_period(self) -> float:
        """Tuned sampling period Td, s."""
        return 1.0 / self.sampling.frequency_hz

    @property
    def preparation(self) -> Preparation:
        """Settings for `identify` of a log sampled at the tuned period."""
        return Preparation(
            cutoff_hz=self.cutoff.frequency_hz, order=self.order, decimation=1, difference_order=2
        )


def distortion_db(differences: int) -> float:
    """Loss allowed to m successive differences at the cutoff, dB: the straight line through the paper's two figures.

    The paper takes 0.08 dB for 4 differences and 0.045 dB for 2, which makes 0.01 + 0.0175 m.

    >>> [round(distortion_db(m), 4) for m in (2, 3, 4)]
    [0.045, 0.0625, 0.08]
    """
    return _DB_ONCE + _DB_EACH * differences


def first_sampling_frequency(cutoff_hz: float, differences: int) -> float:
    """First guess of the sampling frequency [36], Hz, for a cutoff, Hz, and the highest derivative in the model.

    >>> round(first_sampling_frequency(164.42, 4)), round(first_sampling_frequency(164.42, 2))
    (8791, 8289)
    """
    return cutoff_hz / differencing_bandwidth(max(differences, 1), 10 ** (-distortion_db(differences) / 20))


@of_any_axis
def tune(
    axis: Axis,
    parameters: Mapping[str, float],
    measured: Sequence[str] | None = None,
    *,
    trajectory: Trajectory | Sequence[Trajectory] | None = None,
    controller: Controller | Sequence[Controller] | None = None,
    max_lowpass_error: float = 0.01,
    max_sampling_error: float = 1.0,
    order: int = 4,
    filter_force: bool = False,
    keep_jumps: bool = False,
    kind: ParameterKind = "physical",
    track: Track = iter,
) -> Tuning:
    """Cutoff frequency [35], first sampling frequency [36] and sampling frequency [37] of an axis and its sensors.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        A priori values of its physical parameters, SI.
    measured : sequence of str, optional
        Signals of the sensors; those required by default.
    trajectory : Trajectory or sequence of Trajectory, optional
        Reference of the simulation, one for all drives or one for each, at the rate of the controller; `tuning_chirp`
        at 20 kHz by default.
    controller : Controller or sequence of Controller, optional
        One for each drive; by default a cascade tuned to the axis, 10 Hz of bandwidth, on its position sensor.
    max_lowpass_error : float
        Bound of the largest error in [35], percent.
    max_sampling_error : float
        Bound of the largest error in [37], percent.
    order : int
        Order of one pass of the low-pass filter.
    filter_force : bool
        Whether the force passes the low-pass in [35]. If it does, a linear axis has no error at any cutoff: W and y
        lose the same. [37] always filters the force, which the models of flexible axes differentiate.
    keep_jumps : bool
        Whether laws that jump at standstill stay in the axis. The paper leaves Coulomb friction out of model and
        simulation: errors at the zeros of the velocity would hide those of filter and differences.
    kind : {"physical", "minimal"}
        Parameters whose errors are bounded in [37]; minimal ones without an inverse map.
    track : callable, optional
        Is given the frequencies to be scanned and passes them on, to show progress.

    Returns
    -------
    Tuning
        The lowest cutoff and the lowest sampling frequency that meet the bounds: the least noise and the cheapest
        data. Its status states where none does.

    Raises
    ------
    SettingError
        If a bound is not positive, a parameter is missing, or the axis runs away.

    Examples
    --------
    >>> from symid import load_axis
    >>> from symid.simulation import chirp
    >>> values = {"M": 5.0, "Fv": 30.0, "Fs": 4.0}
    >>> reference = chirp(0.5, 20.0, 2.0, 0.02, sampling_period=1e-4, quantity="velocity")
    >>> tuned = tune(load_axis("rigid_1m"), values, trajectory=reference)
    >>> tuned.status, tuned.differences, tuned.left_out
    ('ok', 2, ('Fs',))
    """
    for bound in (max_lowpass_error, max_sampling_error):
        if not 0.0 < bound < math.inf:
            raise SettingError(f"a bound of {bound:g} % is not possible: give a positive number of percent")
    tuned = axis if keep_jumps else without_jumps(axis)
    left_out = tuple(name for name in axis.physical_parameters if name not in tuned.physical_parameters)
    parameters = axis.with_known_values(parameters)
    # The chain of the paper: the cutoff from the error of the low-pass alone [35], a first sampling frequency from the
    # loss of the differences at that cutoff [36], and the lowest one that keeps the error of the whole [37].
    run = noise_free_run(tuned, parameters, trajectory, controller)
    low_pass = LowPassErrors(standard_model(tuned), run, parameters, CUTOFF_DATA_HZ, order, filter_force)
    cutoff = lowest_within(low_pass.errors, low_pass.scan(_CUTOFFS), max_lowpass_error, track)
    model = compiled(derive(tuned, measured))
    differences = max(model.highest_derivatives.values())
    first = first_sampling_frequency(cutoff.frequency_hz, differences)
    settings = Preparation(
        cutoff_hz=cutoff.frequency_hz, order=order, decimation=1, held=False, difference_order=2
    )
    at = partial(_sampling_errors, model, run, parameters, settings, kind)
    rates = np.geomspace(max(first / 20, 2.2 * cutoff.frequency_hz), 2 * first, _RATES)
    sampling = lowest_within(at, [float(rate) for rate in rates], max_sampling_error, track)
    used: ParameterKind = "physical" if sampling.errors.keys() <= parameters.keys() else "minimal"
    status, message = tuning_status({"cutoff": cutoff, "sampling frequency": sampling})
    return Tuning(
        axis=axis.name,
        measured=model.measured,
        order=order,
        cutoff=cutoff,
        differences=differences,
        first_sampling_hz=first,
        sampling=sampling,
        kind=used,
        left_out=left_out,
        status=status,
        message=message,
    )


def without_jumps(axis: Axis) -> Axis:
    """The axis without laws that jump at standstill, such as Coulomb friction.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> list(without_jumps(load_axis("emps")).physical_parameters)
    ['M', 'Fv', 'OF']
    """
    jumping = (
        law
        for law in axis.laws
        if not all(is_smooth(law_expression(term.expression)) for term in law.terms())
    )
    return axis.without(*jumping)


def noise_free_run(
    axis: Axis,
    parameters: Mapping[str, float],
    trajectory: Trajectory | Sequence[Trajectory] | None = None,
    controller: Controller | Sequence[Controller] | None = None,
) -> ExactRun:
    """Run along the trajectory under the controller, by default along `tuning_chirp` under cascades of 10 Hz."""
    plant = plant_of(axis, parameters)
    return exact_run(
        axis,
        parameters,
        trajectory or tuning_chirp(plant, CONTROLLER_HZ),
        controller or tuned_cascades(plant, axis.controlled_signals, 10.0),
    )


def _sampling_errors(
    model: GeneratedModel,
    run: ExactRun,
    parameters: Mapping[str, float],
    settings: Preparation,
    kind: ParameterKind,
    sampling_hz: float,
) -> dict[str, float]:
    """Errors of `identify`, percent, on the run sampled at a frequency; nan where a value is 0 or not found."""
    log = run.log(sampling_hz, model.measured)
    found = identify_by_least_squares(model, log, preparation=settings, nominal=parameters, examine=False)
    estimated, true = found.physical_parameters, dict(parameters)
    if kind == "minimal" or not estimated:
        values = model.minimal_parameters(*(parameters[name] for name in model.physical_units))
        estimated, true = found.minimal_parameters, dict(zip(model.minimal_units, values, strict=True))
    # Parameters of a log, such as the unknown zero of an encoder, are not properties of the axis.
    of_log = {*run.axis.log_parameters, *model.per_log}
    return {
        name: 100.0 * (value / true[name] - 1.0) if true[name] else math.nan
        for name, value in estimated.items()
        if name not in of_log
    }
