"""Diagnoses of real logs, case by case.

Usage: python -m benchmarks.diagnosis.real [CASE ...]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator

from symid.diagnosis import Diagnosis, Level

from .case import Case
from .machines import MACHINES


def modes(found: Diagnosis) -> Iterator[tuple[float, float]]:
    """Antiresonance and resonance, Hz, of each flexible mode found at the driven body.

    The mass m of the mode on its spring has the frequency f while the driven body stands, the antiresonance. The
    declared mass M is the total one, so that both swing against each other at f sqrt(M / (M - m)).
    """
    body = found.axis.free_bodies[0]
    total = next(p.explained for p in found.parameters if p.name in (body.mass, body.inertia))
    for effect in found.effects:
        if effect.effect == "flexible_mode":
            mass, frequency = effect.parameters["m"].value, effect.parameters["f"].value
            yield frequency, frequency * math.sqrt(total / (total - mass)) if mass < total else math.nan


def print_case(case: Case, found: Diagnosis, seconds: float) -> None:
    """Print everything of a case."""
    print(f"\n=== {case.name}: {case.model} ({seconds:.1f} s)\n{found.verdict}: {found.sentence}")
    print_gap(found)
    for effect in found.effects:
        values = ", ".join(f"{n} {p.value:.4g} ± {p.std:.2g} {p.unit}" for n, p in effect.parameters.items())
        doubt = "".join(f", or {name} at {at}" for name, at in effect.indistinguishable_from)
        print(f"  found {effect.effect} at {effect.at}{doubt} ({effect.probability:.2f}): {values}")
    for antiresonance, resonance in modes(found):
        print(f"  a mode with antiresonance {antiresonance:.2f} Hz and resonance {resonance:.2f} Hz")
    for other in found.alternatives[:3]:
        print(
            f"  considered {other.effect} at {other.at} ({other.probability:.2f}), gain {other.log_likelihood:.0f}"
        )
    for change in found.parameters:
        moved = " absorbed what was missing" if change.absorbed else ""
        print(f"  {change.name} {change.reidentified:.5g} -> {change.explained:.5g} {change.unit}{moved}")
    for fault in found.faults:
        print(f"  {fault}")
    print(f"  published: {case.published}")


def print_gap(found: Diagnosis) -> None:
    """Print the gap in steps."""
    gap = found.gap
    names = [effect.effect for effect in found.effects]
    steps = [(f"with {name}", level) for name, level in zip(names, gap.steps, strict=True)]
    rows: list[tuple[str, Level | None]] = [
        ("nominal", gap.nominal),
        ("re-identified", gap.reidentified),
        *steps,
    ]
    for name, level in (*rows, ("noise", gap.noise_floor)):
        if level is not None:
            times = level.rms / gap.noise_floor.rms
            print(
                f"  {name:32}{level.rms:10.4g} {gap.unit:4}{100 * level.relative:9.3f} %{times:9.1f} x noise"
            )


def main() -> None:
    """Diagnose all logs, or those named."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", help="names, or their beginnings [all]")
    wanted = tuple(parser.parse_args().cases)
    for machine, cases in MACHINES.items():
        if wanted and not any(name.startswith(machine) for name in wanted):
            continue
        for case in cases():
            if wanted and not case.name.startswith(wanted):
                continue
            begin = time.perf_counter()
            found = case.found()
            print_case(case, found, time.perf_counter() - begin)


if __name__ == "__main__":
    main()
