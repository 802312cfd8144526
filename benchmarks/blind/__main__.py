"""Draw, diagnose and score sealed cases: `python -m benchmarks.blind COMMAND --help`, from the root of the repository.

python -m benchmarks.blind draw /a/new/folder --cases 300
python -m benchmarks.blind diagnose /a/new/folder
python -m benchmarks.blind score /a/new/folder --json score.json

Cases nearer to machines as they are: draw /another/folder --cases 45 --worldly, then as above.
"""

import json
import secrets
from pathlib import Path
from typing import Any

import click

from . import answers, laws, plan, score, seal, table
from .axes import KINDS

FOLDER = click.argument("folder", type=click.Path(path_type=Path))
JOBS = click.option("--jobs", default=2, show_default=True, help="Processes at a time.")


@click.group()
def blind() -> None:
    """Axes with hidden effects, diagnosed from their logs alone."""


@blind.command()
@FOLDER
@click.option("--cases", default=300, show_default=True)
@click.option("--seed", type=int, help="Fresh unless given; printed.")
@click.option("--group", type=click.Choice([*plan.SHARES, *plan.WORLDLY]), help="Cases of one group only.")
@click.option(
    "--worldly", is_flag=True, help="One strong effect and three small ones, or none, in a rough record."
)
@click.option("--kind", type=click.Choice(list(laws.LAWS)), help="Cases with this effect only.")
@click.option("--at", help="Cases with the effect at this place only.")
@click.option(
    "--axis", "axes", type=click.Choice(list(KINDS)), multiple=True, help="Cases of these axes only."
)
@click.option(
    "--size", type=(float, float), help="Bounds of the effect's size, in place of those of its ratio."
)
@JOBS
def draw(folder: Path, cases: int, seed: int | None, jobs: int, **wish: Any) -> None:
    """Simulate cases into a new FOLDER and seal their labels."""
    seed = secrets.randbelow(1 << 31) if seed is None else seed
    print(f"seed {seed}", flush=True)
    try:
        sha256 = plan.draw_set(folder, cases, seed, jobs, plan.Wish(**wish))
    except ValueError as wrong:
        raise click.UsageError(str(wrong)) from None
    print(f"SHA-256 of the sealed labels {sha256}")


@blind.command()
@FOLDER
@click.option("--timeout", default=120.0, show_default=True, help="Processor seconds a case.")
@JOBS
def diagnose(folder: Path, timeout: float, jobs: int) -> None:
    """Diagnose every case of FOLDER in a separate process; labels, if there are any, remain sealed."""
    if (folder / seal.SEALED).exists():
        print(f"SHA-256 of the sealed labels {seal.fingerprint(folder)}", flush=True)
    found = answers.diagnose_set(folder, jobs, timeout)
    print(f"{len(found)} answers, {sum(record['answer'] is None for record in found)} of them none")


@blind.command()
@click.argument("folders", type=click.Path(path_type=Path, exists=True), nargs=-1, required=True)
@click.option("--beside", type=click.Path(path_type=Path, exists=True), help="A checkout of other code.")
@click.option("--first", type=int, help="So many cases of each folder.")
@click.option("--timeout", default=600.0, show_default=True, help="Processor seconds a case.")
def costs(folders: tuple[Path, ...], beside: Path | None, first: int | None, timeout: float) -> None:
    """Print processor time and peak memory of the diagnosis of each case of FOLDERS, with start-up.

    Beside other code both run in turn, and the largest relative difference of their answers is printed. A loop that
    a case is the first to need is compiled in it, once for a checkout: the second run of this command counts.
    """
    cases = [case for folder in folders for case in answers.cases_of(folder)[:first]]
    trees = [Path(__file__).parents[2], *([beside] if beside else [])]
    for tree in trees:  # the first run after a change compiles
        answers.diagnose(cases[0], timeout, tree=tree)
    found = []
    for case in cases:
        own = [answers.diagnose(case, timeout, tree=tree) for tree in trees]
        found.append(own)
        print(table.cost_line(f"{case.parent.name}/{case.name}", own), flush=True)
    print(table.cost_summary(found))


@blind.command("score")
@FOLDER
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the score here.")
def print_score(folder: Path, target: Path | None) -> None:
    """Open the labels of FOLDER, once every case is answered, and print the table."""
    try:
        labels = seal.open_labels(folder)
    except PermissionError as closed:
        raise click.ClickException(str(closed)) from None
    given, sha256 = answers.read(folder), seal.fingerprint(folder)
    verdicts = [score.verdict(label, given[name]) for name, label in labels.items()]
    print(f"SHA-256 of the sealed labels {sha256}\n\n{table.text(verdicts)}")
    if target:
        target.write_text(json.dumps(table.record(verdicts, sha256), indent=1))


@blind.command()
@FOLDER
@click.option("--timeout", default=120.0, show_default=True, help="Processor seconds a case.")
@JOBS
def rerun(folder: Path, timeout: float, jobs: int) -> None:
    """Simulate what was written of each case found right, beside the true simulator's run with other noise."""
    from . import rerun as again  # symid is loaded only here

    print(again.HEAD)
    cases = []
    for case in again.rerun_set(folder, jobs, timeout):
        print(again.line(case), flush=True)
        cases.append(case)
    print(f"\n{again.table(cases)}")


@blind.command()
@FOLDER
def peek(folder: Path) -> None:
    """Print the labels of a FOLDER that serves development, not a score; in worldly cases the strongest effect first.

    In brackets the gap-to-noise ratio of each effect alone and its numbers.
    """
    for name, label in seal.read(folder).items():
        axis, sensors, removed = label["axis"], "+".join(label["sensors"]), label.get("removed") or {}
        words = list(map(_in_words, label["effects"], label["ratios"]))
        words += [f"the first removes {removed['0']:.0%}"] if removed else []
        head = f"{name}  {axis:15} {sensors:8} {label['group']:12} {label['ratio']:7.1f}"
        print(f"{head}  {'; '.join(words)}".rstrip())


def _in_words(effect: dict[str, Any], ratio: float) -> str:
    numbers = " ".join(f"{name}={value:.3g}" for name, value in effect["numbers"].items())
    return f"{effect['effect']} at {effect['at']} ({ratio:.1f}, {numbers})"


if __name__ == "__main__":
    blind()
