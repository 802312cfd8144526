"""A case told again: from half of its logs, from the log held out, with every second sample, by other nominal values.

An answer that holds on the machine holds on each of them.
"""

from collections.abc import Iterator
from dataclasses import replace

from .case import Case
from .recordings import Recording

OFF = 0.15
"""Relative error of the nominal values, with alternating sign."""


def repeated(case: Case) -> Iterator[Case]:
    """The same question to the same machine, asked in five ways.

    Yields
    ------
    Case
        From the first half of each training log, from the second halves, with the log held out and the first training
        log exchanged, with every second sample of all logs, and with nominal values that are 15 % off.
    """
    yield _named(case, "first-half", training=tuple(_half(run, 0) for run in case.training))
    yield _named(case, "second-half", training=tuple(_half(run, 1) for run in case.training))
    yield _named(case, "exchanged", training=(case.held_out,), held_out=case.training[0])
    thinned = tuple(map(_every_second, case.training))
    yield _named(case, "every-second", training=thinned, held_out=_every_second(case.held_out))
    off = {name: value * (1 + OFF * (-1) ** i) for i, (name, value) in enumerate(case.nominal.items())}
    yield _named(case, "nominal-off", nominal=off)


def _named(case: Case, way: str, **changed: object) -> Case:
    return replace(case, name=f"{case.name}, {way}", **changed)  # type: ignore[arg-type]  # fields of a case


def _half(run: Recording, which: int) -> Recording:
    half = run.period * len(next(iter(run.signals.values()))) / 2
    return run.between(which * half, (which + 1) * half)


def _every_second(run: Recording) -> Recording:
    signals = {name: values[::2] for name, values in run.signals.items()}
    return Recording(f"{run.source}, every second sample", run.start, 2 * run.period, signals)
