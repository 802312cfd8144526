"""Time and memory of `symid generate` as a whole process: shipped axis, chains of 1 to 8 masses, general graphs, gears.

Every chain nM-(n-1)S has viscous friction in every joint, Coulomb friction in the driven one, and a sensor at the motor
only. Geared chains, trees and loops consist of inertias on springs with dampers, with ratios of 0.35 and 0.00159 in
turn, and an encoder on the first body, or on the last body too: then modules for both sets of sensors are written. Each
process imports, declares, derives, eliminates, inverts the parameter map, and writes its modules into a temporary
folder; its processor time includes the start of Python. An axis is refused if elimination has too many terms.

Usage: python -m benchmarks.derivation
"""

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from symid import Axis, Between, Body, Drive, Position, Spring, ViscousFriction, axis_source
from symid.axis import Element, axis_file

COMMAND = (sys.executable, "-c", "from symid.cli import main; main()", "generate")

CHAIN = '''"""Chain of {masses} masses."""

from symid import chain

axis = chain("{name}", {masses}, driven={driven})
'''

HEADER = '''"""General graph: {text}."""

from symid import Axis, Between, Body, Drive, Position, Spring, ViscousFriction

a, b, c = Body("a", mass="Ma"), Body("b", mass="Mb"), Body("c", mass="Mc")
frictions = tuple(ViscousFriction(body, f"F{{body.name}}") for body in (a, b, c))
ab, bc, ca = Between(first=a, second=b), Between(first=b, second=c), Between(first=c, second=a)
'''

TRIANGLE = """
springs = (Spring("ab", ab, stiffness="Kab"), Spring("bc", bc, stiffness="Kbc"), Spring("ca", ca, stiffness="Kca"))
axis = Axis("triangle", (a, b, c, *frictions, *springs), Drive("F", a), (Position("qa", a),))
"""

TWO_TO_GROUND = """
springs = (Spring("ab", ab, stiffness="Kab"), Spring("bc", bc, stiffness="Kbc"))
grounded = (Spring("b0", b, stiffness="Kb"), Spring("c0", c, stiffness="Kc"))
axis = Axis("two_to_ground", (a, b, c, *frictions, *springs, *grounded), Drive("F", a), (Position("qa", a),))
"""

GRAPHS = {
    "triangle": HEADER.format(text="three masses, each joined to both others") + TRIANGLE,
    "two_to_ground": HEADER.format(text="three masses, two of them with a spring to ground") + TWO_TO_GROUND,
}


@dataclass(frozen=True)
class Cost:
    """Time and memory of one process."""

    seconds: float
    peak_mb: float


@dataclass(frozen=True)
class Limit:
    """Limits of a process."""

    seconds: float
    peak_mb: float = 2000.0

    def verdict(self, cost: Cost) -> str:
        """Measured values beside the limits."""
        met = cost.seconds < self.seconds and cost.peak_mb < self.peak_mb
        return f"limit {self.seconds:g} s, {self.peak_mb:g} MB: {'met' if met else 'MISSED'}"


SHAPES = [
    (shape, n, encoders) for shape in ("chain", "tree", "loop") for n in (4, 6, 8) for encoders in (1, 2)
]
"""Geared axes: shape, number of bodies, number of encoders."""
LIMITS = {"direct_2m1s": Limit(2.0), "6M5S": Limit(5.0), "8M7S": Limit(5.0, 1000.0)}
LIMITS |= {f"{shape}_{n}_{encoders}": Limit(5.0, 1000.0) for shape, n, encoders in SHAPES}


def geared(shape: str, n: int, encoders: int) -> Axis:
    """An axis of n inertias; a loop is a chain whose last body has a spring to the first."""
    bodies = [Body(f"b{i}", inertia=f"J{i}") for i in range(n)]
    ends = [((i - 1) // 2 if shape == "tree" else i - 1, i, 0.35 if i % 2 else 0.00159) for i in range(1, n)]
    if shape == "loop":
        ends.append((0, n - 1, 0.7))
    springs = [
        Spring(
            f"s{k}",
            Between(first=bodies[i], second=bodies[j], ratio=ratio),
            stiffness=f"K{k}",
            damping=f"D{k}",
        )
        for k, (i, j, ratio) in enumerate(ends)
    ]
    sensors = tuple(Position(f"q{i}", bodies[i]) for i in (0, n - 1)[:encoders])
    elements: tuple[Element, ...] = (*bodies, ViscousFriction(bodies[0], "Fv"), *springs)
    return Axis(f"{shape}_{n}_{encoders}", elements, Drive("T", bodies[0]), sensors)


def generate(file: Path) -> Cost | None:
    """Run `symid generate` on an axis file; None if the axis is refused."""
    process = subprocess.Popen(
        [*COMMAND, str(file)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    said = process.stderr.read() if process.stderr else ""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode and "too many terms" not in said:
        raise SystemExit(f"symid generate {file.name} failed: {said}")
    return None if process.returncode else Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000.0)


def axis_files(folder: Path) -> dict[str, Path]:
    """Axis files of the table, by the name of its row; what is not shipped is written into a folder."""
    folder.mkdir()
    texts = {}
    for masses in range(1, 9):
        name = f"{masses}M{masses - 1}S"
        texts[name] = CHAIN.format(name=f"axis_{name.lower()}", masses=masses, driven=min(masses, 2))
    texts["direct_2m1s"] = axis_file("direct_2m1s").read_text(encoding="utf-8")
    texts |= GRAPHS
    texts |= {axis.name: axis_source(axis) for axis in (geared(*shape) for shape in SHAPES)}
    files = {}
    for name, text in texts.items():
        stem = name if name[0].isalpha() else f"axis_{name.lower()}"
        files[name] = folder / f"{stem}.py"
        files[name].write_text(text, encoding="utf-8")
    return files


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        print(f"{'axis':16}{'time':>8}{'peak':>9}{'text':>9}  limit")
        print(f"{'':16}{'s':>8}{'MB':>9}{'kB':>9}")
        for name, file in axis_files(Path(folder) / "models").items():
            cost = generate(file)
            if cost is None:
                print(f"{name:16}  REFUSED: too many terms", flush=True)
                continue
            written = (Path(folder) / "generated").glob(f"{file.stem}*.py")
            size = sum(module.stat().st_size for module in written) / 1000
            line = f"{name:16}{cost.seconds:8.2f}{cost.peak_mb:9.0f}{size:9.1f}"
            print(f"{line}  {LIMITS[name].verdict(cost) if name in LIMITS else ''}".rstrip(), flush=True)


if __name__ == "__main__":
    main()
