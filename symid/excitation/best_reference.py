"""`design`: the reference of a few dozen that promises the smallest worst relative deviation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symid.errors import SettingError
from symid.excitation.expectation import Expectation, IdentificationTrial
from symid.excitation.references import DEFAULTS, references, references_apart
from symid.simulation import Trajectory, plant_of

Paths: TypeAlias = tuple[Trajectory, ...]
"""Reference of each drive."""
_FINALISTS, _RUNS = 6, 4
"""Simulated runs that judge the best candidates and the defaults; one run shows little of systematic errors."""


@dataclass(frozen=True)
class Design:
    """The reference that was chosen, beside those of `symid simulate` within the same limits and time.

    Parameters
    ----------
    best : Expectation
        Of the reference that was chosen.
    defaults : dict of str to (Expectation or None)
        Of the default trapezoids and the default chirp; None if they do not determine the parameters.
    tried : int
        References that were simulated.
    """

    best: Expectation
    defaults: dict[str, Expectation | None]
    tried: int


def design(
    experiment: IdentificationTrial,
    seconds: float,
    rate: float,
    *,
    seeds: int = 2,
    track: Callable[[Sequence[Paths]], Iterable[Paths]] = iter,
) -> Design:
    """Choose the reference whose largest relative deviation of a physical parameter is smallest.

    Parameters
    ----------
    experiment : IdentificationTrial
        Axis, noise, controller and limits.
    seconds, rate : float
        Duration, s, and samples per second of controller and log, Hz.
    seeds : int
        Multisines with random phases, for each band.
    track : callable, optional
        Passes on the references that are tried, and may show how far it is.

    Raises
    ------
    SettingError
        If no reference determines the parameters within the limits.
    """
    mode = plant_of(experiment.axis, experiment.parameters).highest_mode
    drives, limits = len(experiment.axis.drives), experiment.limits
    tried = [(one,) * drives for one in references(limits, seconds, rate, mode, seeds)]
    if experiment.apart is not None and drives > 1:
        tried += references_apart(limits, experiment.apart, drives, seconds, rate, mode)
    found = {paths[0].name: experiment.expectation(paths) for paths in track(tried)}
    ranked = sorted((one for one in found.values() if one), key=lambda one: one.worst)
    again = {
        one.trajectory.name: experiment.expectation(one.references, _RUNS)
        for i, one in enumerate(ranked)
        if i < _FINALISTS or one.trajectory.name in DEFAULTS
    }
    best = min((one for one in again.values() if one), key=lambda one: one.worst, default=None)
    if best is None:
        is_common = drives > 1 and experiment.apart is None
        apart = ", or that drives differ by apart=..." if is_common else ""
        raise SettingError(
            f"none of {len(tried)} references within the limits determines the parameters of axis "
            f"{experiment.axis.name!r}: allow more travel, speed, force or --seconds{apart}, or lower the noise"
        )
    return Design(best, {name: again.get(name) for name in DEFAULTS}, len(tried))
