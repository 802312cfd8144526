"""Joint estimation from groups of logs with different known values, such as the payload.

Each group of logs with the same known values gives minimal parameters X_g with covariance C_g, by the model in which
these values are known. The physical parameters theta that all groups share minimise
sum (X_g - X_g(theta))' C_g^-1 (X_g - X_g(theta)). A single log determines masses and friction in units of the drive's
constant only; two known payloads determine that constant.
"""

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import model_of
from symid.data import AnyLog
from symid.errors import SettingError
from symid.identification.identify import identify_by_least_squares
from symid.identification.parameters.constraints import Bounds, Constraints, Priors
from symid.identification.parameters.physical import negative_parameters
from symid.identification.parameters.starts import starts
from symid.identification.results.contradiction import against, constraint_notes
from symid.identification.results.identification_result import Identification
from symid.identification.results.shared_identification import SharedIdentification
from symid.identification.results.status import OPEN
from symid.identification.rows.settings import Preparation
from symid.identification.stacked import Stacked

_LEAST_PROBABILITY = 1e-3


def identify_with_known(
    axis: Axis,
    logs: Sequence[AnyLog],
    known: Sequence[Mapping[str, float]],
    signals: Sequence[str],
    *,
    preparation: Preparation | None = None,
    nominal: Mapping[str, float] | None = None,
    bounds: Bounds | str | None = None,
    prior: Priors | None = None,
    examine: bool = True,
) -> SharedIdentification:
    """Identify an axis from logs with known values of some parameters, which differ from log to log.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    logs : sequence of logs
        Runs of it.
    known : sequence of mapping of str to float
        For each log the values of the same parameters, SI.
    signals : sequence of str
        Sensors to use.
    preparation, examine
        As in `symid.identify`.
    nominal : mapping of str to float, optional
        Where to begin; found without it as a rule.
    bounds, prior : mapping, optional
        Bounds and priors of the shared parameters, as in `symid.identify`.

    Raises
    ------
    SettingError
        If the values are not those of one set of parameters for each log.
    """
    _check(logs, known)
    values = list(dict.fromkeys(tuple(sorted(one.items())) for one in known))
    constraints = Constraints.of(model_of(axis.with_known(known[0]), tuple(signals)), bounds, prior)
    found = []
    for group in values:
        runs = [log for log, one in zip(logs, known, strict=True) if tuple(sorted(one.items())) == group]
        model = model_of(axis.with_known(dict(group)), tuple(signals))
        found.append(identify_by_least_squares(model, runs, preparation=preparation, examine=examine))
    return _shared(axis, tuple(found), tuple(map(dict, values)), nominal, constraints)


def known_of_logs(
    known: Mapping[str, Mapping[str, float]] | None, logs: Sequence[str]
) -> list[Mapping[str, float]]:
    """Values known in each log, which are given by its path or its name; the same parameters in each.

    >>> known_of_logs({"a.csv": {"Ml": 0.0}, "runs/b.csv": {"Ml": 2.5}}, ["runs/a.csv", "runs/b.csv"])
    [{'Ml': 0.0}, {'Ml': 2.5}]
    """
    if not known:
        return [{} for _ in logs]
    found = [known.get(log) or known.get(os.path.basename(log)) or {} for log in logs]
    if missing := [log for log, values in zip(logs, found, strict=True) if not values]:
        raise SettingError(
            f"known values of {len(missing)} of {len(logs)} logs are missing, first those of {missing[0]}: "
            "give them by its path or its name"
        )
    _require_same(found)
    return found


def _check(logs: Sequence[AnyLog], known: Sequence[Mapping[str, float]]) -> None:
    if len(known) != len(logs):
        raise SettingError(
            f"known values are given for {len(known)} logs, there are {len(logs)}: give one set for each log"
        )
    _require_same(known)


def _require_same(known: Sequence[Mapping[str, float]]) -> None:
    names = set(known[0])
    if lacking := [one for one in known if set(one) != names]:
        raise SettingError(
            f"known values are of {', '.join(sorted(names))} in one log and of {', '.join(sorted(lacking[0]))} in "
            "another: give the same parameters for each"
        )


def _shared(
    axis: Axis,
    groups: tuple[Identification, ...],
    known: tuple[Mapping[str, float], ...],
    nominal: Mapping[str, float] | None,
    constraints: Constraints,
) -> SharedIdentification:
    """The parameters that groups of logs share, from the minimal parameters of each group."""
    model = groups[0].model
    units = {name: str(unit) for name, unit in model.physical_units.items()}
    nothing = np.full(len(units), np.nan)
    found = SharedIdentification(
        axis=axis,
        groups=groups,
        known=known,
        physical_units=units,
        values=nothing,
        covariance=np.diag(nothing),
        disagreement=np.nan,
        relations=0,
        status="ok",
        message="",
    )
    if bad := next((group for group in groups if group.fit.status != "ok"), None):
        return replace(found, status=bad.status, message=bad.message)
    stacked = Stacked(groups)
    fits = [stacked.fitted(guess) for guess in _guesses(stacked, list(units), nominal, model.signed)]
    parameters, cost = min((f for f in fits if f is not None), key=lambda one: one[1])
    alone = stacked.estimate(parameters, cost)
    estimate, covariance, outside = alone, stacked.covariance(alone), ""
    if constraints and (one := stacked.constrained(alone, constraints)) is not None:
        outside = against(units, one, np.sqrt(np.diag(covariance)))  # deviations without the constraints
        found = replace(found, constraint_notes=constraint_notes(units, one))
        estimate, covariance = one, stacked.covariance(one)
    found = replace(
        found,
        values=estimate.parameters,
        covariance=covariance,
        disagreement=alone.disagreement,
        relations=alone.relations,
    )
    status, message = _verdict(found, outside)
    return replace(found, status=status, message=message)


def _guesses(
    stacked: Stacked, names: Sequence[str], nominal: Mapping[str, float] | None, signed: Collection[str]
) -> list[FloatArray]:
    """Where the search begins: at nominal values of all parameters, or at those found without them."""
    if nominal and all(name in nominal for name in names):
        return [np.array([nominal[name] for name in names])]
    white, may_be_negative = stacked.white, np.array([name in signed for name in names])
    return list(
        starts(lambda p: white.model.minimal_parameters(*p), white.minimal, white.spread, may_be_negative)
    )


def _verdict(found: SharedIdentification, outside: str) -> tuple[str, str]:
    if loose := [name for name, value in found.physical_parameters.items() if np.isnan(value)]:
        return "no_physical_parameters", (
            f"the logs do not determine {', '.join(loose)}: give logs with another known payload, or one of them as "
            "known (`fixed`) or with a `prior`"
        )
    for group in found.groups:  # of a single one, other groups may determine the rest
        status, message = group.fault or (group.status, group.message)
        if group.fault or status not in OPEN:
            return status, f"{', '.join(group.logs)}: {message}"
    pairs = zip(found.physical_units, found.values, np.sqrt(np.diag(found.covariance)), strict=True)
    signed = found.groups[0].model.signed
    if vague := [name for name, value, deviation in pairs if name not in signed and not deviation < value]:
        return "undetermined", (
            f"the logs do not determine {', '.join(vague)}, whose deviations exceed their values: excite them more, or "
            "give logs whose known payloads differ more"
        )
    if negative := negative_parameters(found.groups[0].model, found.values):
        return (
            "not_physical",
            f"{', '.join(negative)} negative: correct the known values, the model or the logs",
        )
    if found.probability < _LEAST_PROBABILITY:
        return "contradicted", (
            f"the logs contradict each other with these known values (chi-square {found.disagreement:.3g} of "
            f"{found.relations}): correct the values, the model or the logs"
        )
    if outside:
        return (
            "contradicted",
            f"bounds or priors contradict the logs: {outside}: correct them, the model or the logs",
        )
    return "ok", ""
