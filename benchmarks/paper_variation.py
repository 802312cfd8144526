"""How the tables of the paper depend on the choices that it leaves open (`paper_tables --vary`)."""

import math
from collections.abc import Iterator
from dataclasses import replace

from benchmarks.paper_tables import (
    DEFAULT,
    LINEAR,
    Setup,
    chirp_run,
    error,
    identified,
    low_pass_errors,
    rigid_estimate,
    trapezoid_run,
    tuned_rate,
    worst,
)
from benchmarks.paper_values import CUTOFF, METHODS, NOMINAL, PHYSICAL, TABLE_7, TABLE_9, TABLE_11
from symid.simulation import simulate
from symid.tuning.bound import lowest_within


def variants() -> Iterator[tuple[str, Setup]]:
    yield "as chosen", DEFAULT
    for name, values in {
        "bandwidth_hz": (5.0, 20.0, 50.0),
        "seconds": (5.0, 20.0),
        "sweep": ("linear",),
        "quantity": ("position",),
        "rate": (40_000.0,),
        "order": (2, 6),
        "acceleration": (10.0,),
        "jerk": (500.0, 5000.0),
        "slow_cutoff_hz": (40.0, 120.0),
    }.items():
        for value in values:
            yield f"{name} {value}", replace(DEFAULT, **{name: value})


def print_variation() -> None:
    """One line a choice: what is required of the tables, and the frequencies that tuning finds."""
    titles = ("T2", "fc [35]", "fd 1", "fd 2", "fd 3", "T7", "T8", "T9", "Ms T10", "Ks T10", "T11")
    print("\nlargest error in %, tuned frequencies in Hz\n" + " " * 24 + "".join(f"{t:>9}" for t in titles))
    for title, setup in variants():
        low_pass = low_pass_errors(setup)
        cutoff = lowest_within(low_pass.errors, low_pass.scan(17), 0.01).frequency_hz
        fast = identified(1, trapezoid_run(setup).log(8000.0, METHODS[1]), CUTOFF, setup)
        slow = identified(1, trapezoid_run(setup).log(250.0, METHODS[1]), setup.slow_cutoff_hz, setup)
        figures = [
            max(map(abs, low_pass.errors(CUTOFF).values())),
            cutoff,
            *(tuned_rate(method, setup) for method in METHODS),
            worst(fast, TABLE_7),
            worst(fast, PHYSICAL),
            worst(slow, TABLE_9),
            abs(error("Ms", slow["Ms"])),
            abs(error("Ks", slow["Ks"])),
            worst(rigid_estimate(setup), TABLE_11),
        ]
        print(f"{title:24}" + "".join(f"{figure:9.4g}" for figure in figures), flush=True)
        for cached in (chirp_run, trapezoid_run):
            cached.cache_clear()
    print_held_force()


def print_held_force() -> None:
    """Table 7 and 8 with a controller at 8 kHz whose force is held: as recorded, and moved by half a sample."""
    rate = 8000.0
    run = simulate(LINEAR, NOMINAL, DEFAULT.trapezoids(rate), DEFAULT.controller(LINEAR))
    for title, late in (("as recorded", 0.0), ("half a sample earlier (--held Fm)", -0.5 / rate)):
        found = identified(1, run.log, CUTOFF, late=late)
        errors = ", ".join(f"{name} {error(name, found.get(name, math.nan)):.4g}" for name in PHYSICAL)
        print(f"force held at 8 kHz, {title}: errors in % {errors}")
