"""Choice of the reference for an identification: the candidate with the smallest largest relative deviation.

For each candidate the axis is simulated, checked against its limits and identified with the filter and differences that
`identify` chooses. The deviations of that estimate are those to expect. Since the true parameters are known,
systematic errors are detected as well.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symid.errors import SettingError
from symid.excitation.identification_trial import Expectation, IdentificationTrial
from symid.excitation.references import DEFAULTS, references, references_apart
from symid.identification.parameters import open_by_structure
from symid.simulation import Trajectory, plant_of

Paths: TypeAlias = tuple[Trajectory, ...]
"""Reference of each drive."""
_FINALISTS, LEAST_RUNS = 6, 4
"""The best candidates and the defaults are simulated several times: one run shows little bias."""
FINAL_RUNS = 150
"""Runs of the chosen reference, whose errors then tell more than printed deviations: of an error that varies from run
to run they give the rms to 6 %."""
_SHARE_OF_DEFAULTS = 5
"""Number of runs of the chosen reference for each run of the default ones."""


@dataclass(frozen=True)
class Design:
    """The chosen reference, compared with the defaults of `symid simulate` within the same limits and time."""

    best: Expectation
    """Expectation for the chosen reference."""
    defaults: dict[str, Expectation | None]
    """Expectations for the default trapezoids and the default chirp; None if they do not determine the parameters."""
    tried: int
    """Number of references that were simulated."""


def design(
    experiment: IdentificationTrial,
    seconds: float,
    rate: float,
    *,
    seeds: int = 2,
    runs: int = FINAL_RUNS,
    track: Callable[[Sequence[Paths]], Iterable[Paths]] = iter,
) -> Design:
    """Choose the reference whose largest relative deviation of a physical parameter is smallest.

    Parameters
    ----------
    experiment : IdentificationTrial
        Axis, noise, controller and limits.
    seconds, rate : float
        Duration, s, and sampling rate of controller and log, Hz.
    seeds : int
        Number of multisines with random phases for each band.
    runs : int
        Number of simulated identifications of the chosen reference, 4 at least: the expected errors come from them. The
        defaults get a fifth.
    track : callable, optional
        Passes on the references that are tried, and may show progress.

    Raises
    ------
    SettingError
        If no reference determines the parameters within the limits, or there are fewer than 4 runs.
    """
    if runs < LEAST_RUNS:
        raise SettingError(f"runs is {runs}: it must be at least {LEAST_RUNS}")
    mode = plant_of(experiment.axis, experiment.parameters).highest_mode
    drives, limits = len(experiment.axis.drives), experiment.limits
    tried = [(one,) * drives for one in references(limits, seconds, rate, mode, seeds)]
    if experiment.apart is not None and drives > 1:
        tried += references_apart(limits, experiment.apart, drives, seconds, rate, mode)
    found = {paths[0].name: experiment.expectation(paths) for paths in track(tried)}
    ranked = sorted((one for one in found.values() if one), key=lambda one: one.worst)
    again = {
        one.trajectory.name: experiment.expectation(one.references, LEAST_RUNS)
        for i, one in enumerate(ranked)
        if i < _FINALISTS or one.trajectory.name in DEFAULTS
    }
    best = min((one for one in again.values() if one), key=lambda one: one.worst, default=None)
    if best is None:
        if unseen := open_by_structure(experiment.model):
            raise SettingError(
                f"no motion determines {', '.join(unseen)} of axis {experiment.axis.name!r} by these sensors: declare "
                "what is known as a number, or measure more"
            )
        if beyond := experiment.beyond_at_rest(tried[0]):
            raise SettingError(
                f"axis {experiment.axis.name!r} reaches {beyond} already at rest, by noise in its loop or by "
                "weights: lower the bandwidth of the controller or the noise, or allow more"
            )
        is_common = drives > 1 and experiment.apart is None
        apart = ", or that drives differ by apart=..." if is_common else ""
        raise SettingError(
            f"none of {len(tried)} references within the limits determines the parameters of axis "
            f"{experiment.axis.name!r}: allow more travel, speed, force or time{apart}, or lower the noise"
        )
    fewer = max(LEAST_RUNS, runs // _SHARE_OF_DEFAULTS)
    defaults = {name: _repeated(experiment, again.get(name), fewer) for name in DEFAULTS}
    return Design(_repeated(experiment, best, runs) or best, defaults, len(tried))


def _repeated(trial: IdentificationTrial, expected: Expectation | None, runs: int) -> Expectation | None:
    """Expectation of the same reference from more runs."""
    if expected is None or runs <= LEAST_RUNS:
        return expected
    return trial.expectation(expected.references, runs)
