"""Printed results: all of a case, and the final table."""

import math
from collections.abc import Iterator, Sequence

from symid.diagnosis import Diagnosis, Level

from .case import Case
from .row import Row


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


def print_case(case: Case, found: Diagnosis) -> None:
    print(f"\n=== {case.name}: {case.model}\n{found.verdict}: {found.sentence}")
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


def print_script(row: Row) -> None:
    """Print what the plain script found: in its own band, then in that of the diagnosis."""
    own = row["plain_in_own_band"]
    there = [(row["band_hz"], row["plain"])] if "plain" in row else []
    for band, script in ((own["band_hz"], own), *there):
        values = ", ".join(f"{name} {value:.4g}" for name, value in script["best"].items())
        shape = "" if script["shape"] is None else " (shape {:.4g}, {:.3g})".format(*script["shape"])
        before, after = (f"{100 * script[x]['relative']:.2f} %" for x in ("before", "after"))
        print(f"  plain script below {band:.1f} Hz: {before} -> {after} held out; {values}{shape}")


def print_table(rows: Sequence[Row]) -> None:
    """Print the closing table.

    Errors are rms of the force on the held-out log, in its unit and in percent of the force, in the band of the
    diagnosis. The ratio is that of both errors there; then that in the script's own band, on the rows of both.
    """
    heading = "case, published, verdict, first effect, p, right, before, after, unit, "
    heading += "plain before, plain after, ratio, own band, CPU s, MB, absurd"
    lines = [tuple(heading.split(", ")), *(_line(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    print()
    for line in lines:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
    judged = [row["right"] for row in rows if row["right"] != "-"]
    counts = ", ".join(f"{judged.count(word)} {word}" for word in ("yes", "tie", "script", "no"))
    close = [row["ratio_in_own_band"] <= 1.1 for row in rows if "plain" in row]
    absurd = sum(bool(row["absurd"]) for row in rows)
    print(
        f"\nfirst effect right: {counts}, of {len(judged)}; absurd: {absurd} of {len(rows)}; error at most 1.1 times "
        f"that of the script, in its band: {sum(close)} of {len(close)}"
    )


def _line(row: Row) -> tuple[str, ...]:
    published = " or ".join(name for name, _ in row["right_effects"]) or "-"
    end = f"{row['cpu_s']:.1f}", f"{row['peak_mb']:.0f}", "; ".join(row["absurd"])
    if "plain" not in row:
        return row["case"], published, row["verdict"], "-", "", row["right"], *[""] * 7, *end
    first = row["effects"][0] if row["effects"] else None
    return (
        row["case"],
        published,
        row["verdict"],
        f"{first['effect']} at {first['at']}" if first else "-",
        f"{first['probability']:.2f}" if first else "",
        row["right"],
        _size(row["before"]),
        _size(row["after"]),
        row["unit"],
        _size(row["plain"]["before"]),
        _size(row["plain"]["after"]),
        f"{row['ratio']:.2f}",
        f"{row['ratio_in_own_band']:.2f}",
        *end,
    )


def _size(level: Row) -> str:
    return f"{level['rms']:.3g} ({100 * level['relative']:.1f} %)"
