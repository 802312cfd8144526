"""`identify_output_error`: from logs of an axis to its parameters by maximum likelihood on the sampled axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from threadpoolctl import threadpool_limits

from symid.axis import Axis
from symid.codegen import GeneratedModel, declared_delays, passed_over
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Identification, Preparation, identify_with_steps
from symid.identification.rows import notes_on_declared
from symid.output_error.error_model import ErrorModel
from symid.output_error.fit_status import fault_by_regression, likelihood_status, remarks_on, undetermined
from symid.output_error.hidden_laws import Models, models_of
from symid.output_error.likelihood_fit import LikelihoodFit
from symid.output_error.likelihood_result import OutputErrorIdentification
from symid.output_error.rough_starts import plausible, rigid_start, spread, with_heavy_bodies
from symid.simulation import ClosedLoop, ForwardDynamics, feedthrough_of, forward_dynamics

_OPEN = "not_converged", "not_physical", "undetermined"
"""Statuses whose cause least squares may know, such as a wrong sign or a law that is missing."""
_MAY_LACK = "the model may lack an effect that moves them: run `symid diagnose`"


def identify_output_error(
    axis: Axis,
    model: GeneratedModel | Sequence[str],
    logs: Log | Sequence[Log],
    *,
    loop: ClosedLoop | None = None,
    preparation: Preparation | None = None,
    nominal: Mapping[str, float] | None = None,
) -> OutputErrorIdentification:
    """Identify an axis without differentiating its signals: simulate from sample to sample, compare, correct.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel or sequence of str
        The model of the axis for the sensors to use, or these sensors. Nonlinear laws, such as Coulomb friction, may
        then act at bodies that no sensor sees.
    logs : Log or sequence of Log
        Runs of one axis.
    loop : ClosedLoop, optional
        The axis under its known controller, along the reference of the log: what readings and force are compared with,
        instead of predicting each reading from earlier ones. The force between its samples need not be known then.
    preparation : Preparation, optional
        `late`, `held` and `standstill` are respected; a `late` of the force fixes its timing. If neither `held` nor the
        declaration of the drive says whether the force is held from each sample to the next, the likelihood decides
        between a held force and a smooth one whose timing is estimated.
    nominal : mapping of str to float, optional
        Nominal physical parameters to begin with; otherwise those of weighted least squares, and rough ones.

    Returns
    -------
    OutputErrorIdentification
        Its status and notes state what cannot be determined.

    Raises
    ------
    LogError, SettingError
        If a log does not have a signal, or a setting is not possible.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.codegen import load_generated
    >>> from symid.simulation import chirp, plant_of, simulate, tuned_cascade
    >>> axis, truth = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 0.0}
    >>> reference = chirp(1.0, 5.0, 4.0, 0.01, sampling_period=4e-3)
    >>> log = simulate(axis, truth, reference, tuned_cascade(plant_of(axis, truth), "q")).log
    >>> held = Preparation(held=True)
    >>> found = identify_output_error(axis, load_generated("rigid_1m"), log, preparation=held)
    >>> {name: round(value, 3) for name, value in found.physical_parameters.items() if name != "Fs"}
    {'M': 5.0, 'Fv': 3.0}
    """
    runs = (logs,) if isinstance(logs, Log) else tuple(logs)
    if not runs:
        raise SettingError("there is no log: give at least one")
    chosen = preparation or Preparation()
    delays = declared_delays(axis)
    prepared = Preparation(late=delays | dict(chosen.late), held=chosen.held, standstill=chosen.standstill)
    if loop is not None:
        for log in runs:
            loop.check(log)
    whole, visible = Models(model, model) if isinstance(model, GeneratedModel) else models_of(axis, model)
    held = prepared.held
    if held is None:
        is_timed = any(drive.signal in chosen.late for drive in axis.drives)
        held = axis.drives[0].held or (False if is_timed else None)
    comparisons = _comparisons(whole, forward_dynamics(axis), prepared, held, loop)
    with threadpool_limits(1):
        settings = replace(prepared, held=bool(held))
        judge = _Judge(axis, whole, visible, settings, nominal)
        regression = judge.least_squares(runs, settings)
        starts = _starts(whole, comparisons[0].dynamics, runs, regression, nominal)
        if regression is not None and regression.status == "recording":
            starts = starts[:1]  # a channel is damaged: no start leads to parameters that can be trusted
        notes = (
            *(note for log in runs for note in log.notes),
            *notes_on_declared(delays, prepared.late, () if loop else passed_over(axis)),
        )
        agreed = regression if visible is whole else None
        each = [judge.least_squares([run], settings) for run in runs if agreed and len(runs) > 1]
        result = judge.result(runs, _best_fit(comparisons, runs, starts), agreed, each, notes)
        if result.status == "not_physical" and agreed is not None and agreed.status == "ok":
            # a model whose force hardly acts can be likelier: it predicts smooth readings by themselves
            nearest = judge.result(runs, _best_fit(comparisons, runs, starts[:1]), agreed, each, notes)
            result = result if nearest.status in ("not_physical", "not_converged", "no_start") else nearest
    if result.status == "not_converged" and visible is not whole and loop is None:
        message = "predictions do not determine friction at hidden bodies: give `controller`, its gains"
        return replace(result, message=message)
    return result


@dataclass(frozen=True, eq=False)
class _Judge:
    """Results with their status, beside those of least squares on the same logs."""

    axis: Axis
    model: GeneratedModel
    visible: GeneratedModel  # without laws that no sensor sees
    settings: Preparation  # of least squares
    nominal: Mapping[str, float] | None

    def least_squares(self, logs: Sequence[Log], settings: Preparation) -> Identification | None:
        """Least-squares identification with all checks; None if the logs cannot be prepared for it."""
        try:
            return identify_with_steps(
                self.axis, self.visible, logs, feedthrough_of, preparation=settings, nominal=self.nominal
            )
        except SettingError:
            return None

    def result(
        self,
        logs: tuple[Log, ...],
        best: tuple[LikelihoodFit | None, ErrorModel, list[LikelihoodFit]],
        regression: Identification | None,
        each: Sequence[Identification | None] = (),
        notes: tuple[str, ...] = (),
    ) -> OutputErrorIdentification:
        """Result of a fit, with notes besides those given; `each` are the regressions of single logs."""
        fit, comparison, single_fits = best
        result = OutputErrorIdentification(
            axis=self.axis,
            model=self.model,
            logs=logs,
            comparison=comparison,
            fit=fit,
            status="ok",
            message="",
            notes=notes,
        )
        # of several logs with regressions, each is judged alone, too; a single log has neither `own` nor `each`
        singles = zip(logs, single_fits, each, strict=True) if each and len(single_fits) == len(each) else ()
        alone = [self.result((log,), (run, comparison, []), single) for log, run, single in singles]
        timed = self._in_time(result, regression)
        status, message = likelihood_status(result, timed, alone)
        if status == "ok" and timed is not None and timed.status == "ok" and timed.physical:
            is_timed = comparison.free_timing or comparison.force != "smooth"
            lacking = timed.by_lacking(timed.physical[0].sensitivity, delays=not is_timed)
            result = replace(result, lacking=lacking)
            status, message = undetermined(result, _MAY_LACK) or ("ok", "")
        elif status in _OPEN and timed is not None and timed.status not in ("ok", "undetermined"):
            message = f"{message}; least squares: {timed.message}"
        return replace(result, status=status, message=message, notes=(*notes, *remarks_on(result)))

    def _in_time(
        self, result: OutputErrorIdentification, regression: Identification | None
    ) -> Identification | None:
        """Least squares, with the timing of the force that output error found where that leads to a clearer status.

        An ignored delay makes parameters negative in least squares, and hides other faults.
        """
        course = result.comparison.force
        if regression is None or regression.status == "ok" or result.fit is None or course == "simulated":
            return regression
        late = dict.fromkeys(result.model.forces, result.late) if course == "smooth" else {}
        timed = replace(self.settings, held=course == "held", late={**self.settings.late, **late})
        again = self.least_squares(result.logs, timed) if timed != self.settings else None
        if again is None:
            return regression
        is_new = again.status == "poor_fit" and fault_by_regression(result, regression) is None
        return again if again.status == "ok" or is_new else regression


def _best_fit(
    comparisons: Sequence[ErrorModel], runs: Sequence[Log], starts: Sequence[Mapping[str, float]]
) -> tuple[LikelihoodFit | None, ErrorModel, list[LikelihoodFit]]:
    """Likeliest joint fit with its error model, and the fits of single runs that it started from."""
    fits: list[tuple[LikelihoodFit, ErrorModel, list[LikelihoodFit]]] = []
    for comparison in comparisons:
        alone = [comparison.fit([log], starts) for log in runs] if len(runs) > 1 else []
        results = [result for result in alone if result is not None]
        fit = comparison.fit(runs, [result.search.parameters for result in results] or starts)
        if fit is not None:  # other courses of the force need not begin at all starts again
            fits.append((fit, comparison, results))
            starts = [starts[0], fit.search.parameters, *map(dict, fit.promising)]
    return min(fits, key=lambda result: result[0].cost, default=(None, comparisons[0], []))


def _comparisons(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    preparation: Preparation,
    held: bool | None,
    loop: ClosedLoop | None,
) -> list[ErrorModel]:
    """Error models to compare: one if the course of the force is declared, else one for each course."""
    if loop is not None:
        return [ErrorModel(model, dynamics, preparation, "simulated", loop=loop)]
    if held is None:
        smooth = ErrorModel(model, dynamics, preparation, "smooth", free_timing=True)
        return [smooth, ErrorModel(model, dynamics, preparation, "held")]
    return [ErrorModel(model, dynamics, preparation, "held" if held else "smooth")]


def _starts(
    model: GeneratedModel,
    dynamics: ForwardDynamics,
    logs: Sequence[Log],
    regression: Identification | None,
    nominal: Mapping[str, float] | None,
) -> list[dict[str, float]]:
    """Start parameters: nominal and sound ones of least squares, else rough ones and plausible ones of the latter."""
    sound: list[dict[str, float]] = []
    if nominal is not None:
        dynamics.at(nominal)  # an error names what is missing or impossible
        positive = dynamics.parameters_of("mass") | dynamics.parameters_of("stiffness")
        if nothing := [name for name in nominal if name in positive and nominal[name] == 0]:
            raise SettingError(
                f"the nominal {nothing[0]} is 0, where a search cannot start: give a positive value, or fix it at 0"
            )
        known = [dict(nominal)]
        # a search may end where nominal values are off
        if regression is not None and regression.status == "ok":
            values = dict(nominal) | regression.physical_parameters
            sound = [plausible(model, dynamics, values, dict(nominal))]
    else:
        rough = rigid_start(model, dynamics, logs)
        identified = regression.physical_parameters if regression is not None else {}
        is_sound = regression is not None and regression.status == "ok"
        # accepted masses are not compared with rough ones, which do not know what a gear makes of a mass
        masses = {
            name: identified[name]
            for name in dynamics.parameters_of("mass")
            if is_sound and name in identified
        }
        better = plausible(model, dynamics, identified, rough | masses)
        heavy = with_heavy_bodies(dynamics, rough)
        known = [
            values for i, values in enumerate((better, rough, heavy)) if values not in (better, rough)[:i]
        ]
    rates = dict.fromkeys(log.sampling_frequency for log in logs)
    return [start for rate in rates for values in known for start in spread(dynamics, values, rate)] + sound
