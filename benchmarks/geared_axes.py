"""Time and memory of the derivation of geared chains, trees and loops of up to 8 bodies, each in a process of its own.

Inertias hang on geared springs with dampers, of ratio 0.35 and 0.00159 in turn; encoders are on the first, or on the
first and the last body. What is counted is the processor time of derivation and module text, without starting Python.

Usage: python -m benchmarks.geared_axes [--bodies N]
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time

from symid import Axis, Between, Body, Drive, Position, Spring, ViscousFriction

LIMIT_S, LIMIT_MB = 5.0, 1000.0


def geared(shape: str, n: int, encoders: int) -> Axis:
    """An axis of n inertias; a loop is a chain whose last body has a spring to the first."""
    bodies = [Body(f"b{i}", inertia=f"J{i}") for i in range(n)]
    ends = [((i - 1) // 2 if shape == "tree" else i - 1, i, 0.35 if i % 2 else 0.00159) for i in range(1, n)]
    if shape == "loop":
        ends.append((0, n - 1, 0.7))
    springs = [
        Spring(
            f"s{k}",
            Between(first=bodies[first], second=bodies[second], ratio=ratio),
            stiffness=f"K{k}",
            damping=f"D{k}",
        )
        for k, (first, second, ratio) in enumerate(ends)
    ]
    sensors = tuple(Position(f"q{i}", bodies[i]) for i in (0, n - 1)[:encoders])
    elements = (*bodies, ViscousFriction(bodies[0], "Fv"), *springs)
    return Axis("geared", elements, Drive("T", bodies[0]), sensors)


def measure(shape: str, n: int, encoders: int) -> str:
    """One line: processor time, peak memory, size of the text or why there is none."""
    from symid.codegen.module import module_text
    from symid.errors import EliminationError
    from symid.symbolic import derive

    axis = geared(shape, n, encoders)
    begin = time.process_time()
    try:
        model = derive(axis, tuple(sensor.signal for sensor in axis.sensors))
        said = f"{len(module_text(model)) / 1000:.0f} kB of text"
        if any("equation of its own" in text for text in model.assumptions):
            said += ", an equation for each sensor"
    except EliminationError:
        said = ""
    seconds = time.process_time() - begin
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    met = "met" if seconds < LIMIT_S and memory < LIMIT_MB else "MISSED"
    if not said:
        met, said = "REFUSED", "too many terms"
    return f"{seconds:8.2f} s {memory:6.0f} MB  {met:7s} {said}"


def main() -> None:
    """Print a line for each axis."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", type=int, default=8)
    parser.add_argument("--one", nargs=3)
    options = parser.parse_args()
    if options.one:
        shape, n, encoders = options.one
        print(measure(shape, int(n), int(encoders)))
        return
    print(f"aims: {LIMIT_S:g} s, {LIMIT_MB:g} MB")
    for shape in ("chain", "tree", "loop"):
        for n in range(3, options.bodies + 1):
            for encoders in (1, 2):
                command = [
                    sys.executable,
                    "-m",
                    "benchmarks.geared_axes",
                    "--one",
                    shape,
                    str(n),
                    str(encoders),
                ]
                line = subprocess.run(command, capture_output=True, text=True, check=True).stdout
                print(f"{shape:5s} of {n}, {encoders} encoder(s) {line}", end="", flush=True)


if __name__ == "__main__":
    main()
