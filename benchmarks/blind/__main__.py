"""Draw, diagnose and score sealed cases: `python -m benchmarks.blind COMMAND --help`."""

from __future__ import annotations

import secrets
from pathlib import Path

import click

from . import plan, seal


@click.group()
def blind() -> None:
    """Axes with one hidden effect, diagnosed from their logs alone."""


@blind.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=False))
@click.option("--cases", default=300, show_default=True)
@click.option("--seed", type=int, help="Fresh unless given; printed.")
@click.option("--jobs", default=2, show_default=True)
@click.option("--group", type=click.Choice(list(plan.SHARES)), help="Cases of one group only.")
def draw(folder: Path, cases: int, seed: int | None, jobs: int, group: str | None) -> None:
    """Simulate CASES into FOLDER and seal their labels."""
    seed = secrets.randbelow(1 << 31) if seed is None else seed
    print(f"seed {seed}")
    print(f"SHA-256 of the sealed labels {plan.draw_set(folder, cases, seed, jobs, group)}")


@blind.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
def peek(folder: Path) -> None:
    """Print the labels of a set that is meant for development, not for a score."""
    for name, label in seal.read(folder).items():
        effects = ", ".join(f"{e['effect']} at {e['at']}" for e in label["effects"])
        print(f"{name}  {label['axis']:15} {'+'.join(label['sensors']):8} {label['group']:10} {label['ratio']:7.1f}  {effects}")


if __name__ == "__main__":
    blind()
