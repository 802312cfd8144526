"""Methods of identification, each with its settings: from an axis and its logs to a result."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, Generic, Literal, TypeVar

from symid.arrays import FloatArray
from symid.axis import AnyAxis, Axis, axis_of
from symid.codegen import GeneratedModel, compiled, model_of
from symid.data import AnyLog, first_block, in_memory
from symid.errors import SettingError, SymidError
from symid.identification import (
    Constraints,
    Identification,
    IdentificationResult,
    Preparation,
    identify_with_steps,
    with_fixed,
)
from symid.identification.parameters import Bounds, Priors

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification
    from symid.simulation import ClosedLoop

Result_co = TypeVar("Result_co", bound=IdentificationResult, covariant=True)


@dataclass(frozen=True, eq=False)
class IdentificationProblem:
    """An axis to be identified from its logs."""

    # as it was given
    axis: AnyAxis
    logs: Sequence[AnyLog]
    # the sensors to use
    signals: tuple[str, ...]
    # values of parameters that are known
    fixed: Mapping[str, float]
    # settings of every method
    preparation: Preparation | None
    nominal: Mapping[str, float] | None
    examine: bool

    @cached_property
    def declared(self) -> Axis:
        """The declaration, in which fixed values are known."""
        return axis_of(self.axis).with_known(self.fixed) if self.fixed else axis_of(self.axis)

    @cached_property
    def model(self) -> GeneratedModel:
        """The model that was given, or that of the axis and the sensors."""
        if self.fixed:
            return model_of(self.declared, self.signals)
        return (
            model_of(self.axis, self.signals) if isinstance(self.axis, (Axis, str)) else compiled(self.axis)
        )

    @property
    def settings(self) -> dict[str, Any]:
        """Settings of every method by name."""
        return {"preparation": self.preparation, "nominal": self.nominal, "examine": self.examine}

    def loop(self, given: ClosedLoop | None) -> ClosedLoop | None:
        """A closed loop, in which fixed values are known."""
        return replace(given, axis=self.declared) if given and self.fixed else given


class IdentificationMethod(ABC, Generic[Result_co]):
    """A method of identification for `symid.identify`. Its fields are its settings."""

    @abstractmethod
    def solve(self, problem: IdentificationProblem) -> Result_co:
        """Identify an axis from its logs."""


@dataclass(frozen=True, kw_only=True)
class _Regression(IdentificationMethod[Identification]):
    """A method that estimates minimal parameters, and physical ones from these under bounds and priors."""

    bounds: Bounds | Literal["physical"] | None = None
    prior: Priors | None = None

    def solve(self, problem: IdentificationProblem) -> Identification:
        found = self._estimate(problem, Constraints.of(problem.model, self.bounds, self.prior))
        if problem.fixed:
            found = with_fixed(found, self._estimate(replace(problem, fixed={}), Constraints()))
        elif isinstance(
            problem.axis, GeneratedModel
        ):  # its axis is a name, whose declaration may be another one
            return found
        return replace(found, axis=problem.declared, runs=tuple(map(first_block, problem.logs)))

    @abstractmethod
    def _estimate(self, problem: IdentificationProblem, constraints: Constraints) -> Identification: ...


@dataclass(frozen=True, kw_only=True)
class WeightedLeastSquares(_Regression):
    """Weighted least squares: every equation of every log is weighted by its noise.

    Parameters
    ----------
    ddof : int, optional
        Subtracted from the number of rows in the residual's deviation; the number of parameters by default.
    bounds : mapping of str to (low, high), or "physical", optional
        Bounds of parameters, None for no bound; "physical" keeps masses, inertias, springs and frictions from being
        negative.
    prior : mapping of str to (mean, deviation), optional
        Prior value of parameters, with its standard deviation.
    """

    ddof: int | None = None
    _weighting: ClassVar[Literal["wls", "ols"]] = "wls"

    def _estimate(self, problem: IdentificationProblem, constraints: Constraints) -> Identification:
        try:
            declared = problem.declared
        except SymidError:  # of a generated model whose axis file is elsewhere
            declared = None
        own: dict[str, Any] = {"method": self._weighting, "ddof": self.ddof, "constraints": constraints}
        return identify_with_steps(
            declared, problem.model, problem.logs, _feedthrough, **own, **problem.settings
        )


@dataclass(frozen=True, kw_only=True)
class OrdinaryLeastSquares(WeightedLeastSquares):
    """Ordinary least squares, with the settings of `WeightedLeastSquares`."""

    _weighting = "ols"


@dataclass(frozen=True, kw_only=True)
class InstrumentalVariables(_Regression):
    """Instrumental variables from the simulated axis: noise of the sensors does not bias the parameters.

    Parameters
    ----------
    loop : ClosedLoop, optional
        The axis under its known controller; without it a cascade is read from the log, or tuned to the parameters.
    bounds, prior : optional
        As in `WeightedLeastSquares`.
    """

    loop: ClosedLoop | None = None

    def _estimate(self, problem: IdentificationProblem, constraints: Constraints) -> Identification:
        from symid.instrumental import identify_by_instruments  # takes 0.1 s to load
        from symid.simulation import ClosedLoop

        loop = problem.loop(self.loop) or ClosedLoop(problem.declared)
        logs = list(map(in_memory, problem.logs))
        return identify_by_instruments(problem.model, logs, loop, constraints=constraints, **problem.settings)


@dataclass(frozen=True, kw_only=True)
class OutputError(IdentificationMethod["OutputErrorIdentification"]):
    """Output error: maximum likelihood on the sampled axis, without derivatives of its signals.

    Of the preparation it uses only ``late``, ``held`` and ``standstill``. It always examines.

    Parameters
    ----------
    loop : ClosedLoop, optional
        The axis under its known controller, simulated along the reference; without it each reading is predicted from
        earlier ones.
    """

    loop: ClosedLoop | None = None

    def solve(self, problem: IdentificationProblem) -> OutputErrorIdentification:
        """Identify an axis from its logs."""
        from symid.output_error import identify_output_error  # takes 0.3 s to load

        return identify_output_error(
            problem.declared,
            problem.signals,
            list(map(in_memory, problem.logs)),
            loop=problem.loop(self.loop),
            preparation=problem.preparation,
            nominal=problem.nominal,
        )


METHODS: Final[dict[str, type[IdentificationMethod[Any]]]] = {
    "wls": WeightedLeastSquares,
    "ols": OrdinaryLeastSquares,
    "iv": InstrumentalVariables,
    "oe": OutputError,
}


def method_of(name: str, settings: Mapping[str, object]) -> IdentificationMethod[Any]:
    """The method of a short name with its settings; None or {} is none.

    Raises
    ------
    SettingError
        If there is no such method, or it lacks a setting.

    Examples
    --------
    >>> method_of("oe", {})
    OutputError(loop=None)
    """
    if name not in METHODS:
        raise SettingError(f"there is no method {name!r}: choose from {', '.join(METHODS)}")
    given = {setting: value for setting, value in settings.items() if value is not None and value != {}}
    for setting in given:
        possible = [short for short, method in METHODS.items() if hasattr(method, setting)]
        if name not in possible:
            raise SettingError(
                f"{setting} is not possible with method {name!r}: leave it out, or take {' or '.join(possible)}"
            )
    return METHODS[name](**given)


def _feedthrough(axis: Axis, values: Mapping[str, float]) -> Mapping[str, FloatArray]:
    from symid.simulation import feedthrough_of  # takes 0.1 s to load

    return feedthrough_of(axis, values)
