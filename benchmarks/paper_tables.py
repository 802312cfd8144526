"""Tables 2 to 11 of the paper: its figures, ours and the difference.

The paper leaves open what follows; it is chosen once, in `Setup`, and `--vary` shows which conclusions depend on it.

- Controller: a PI velocity loop (a cascade without position gain) of 10 Hz, integral at a fifth of it. It runs at
  20 kHz and its force is taken as a continuous one (the held force stands in the log at the middle of each hold), so
  that a sample has no delay: with a force that is held from sample to sample and recorded when it is sent, the phase
  of half a sample at 80 Hz exceeds the damping of the structure many times, and Fvs is lost (see `--vary`).
- Chirp: 0.1 to 100 Hz in 10 s, the frequency rising exponentially, of constant velocity.
- Filter: Butterworth of order 4, forward and backward. In Table 2 the force does not pass it: the four equal errors of
  Table 2 say so, since with a filtered force every error is zero at every cutoff. Elsewhere it does.
- Trapezoids: moves of 0.2 m at 0.1, 0.25 and 0.5 m/s with 5 m/s^2 and a jerk of 1e5 m/s^3, that is with accelerations
  that jump; smoother ones hardly move the structure. At 250 Hz the cutoff is 100 Hz, since 164.42 Hz is beyond Nyquist.
- Integration: exact between two samples of the controller (matrix exponential); there is no integration step.

Usage: python -m benchmarks.paper_tables [--vary]
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.options import parser_of
from benchmarks.paper_values import (
    CUTOFF,
    LAST_DIGITS,
    METHODS,
    NOMINAL,
    PHYSICAL,
    TABLE_2,
    TABLE_3,
    TABLE_4,
    TABLE_5,
    TABLE_5_INITIAL,
    TABLE_6,
    TABLE_6_INITIAL,
    TABLE_7,
    TABLE_8,
    TABLE_9,
    TABLE_10,
    TABLE_11,
    Printed,
)
from symid import Axis, Log, Preparation, compiled, derive, identify, load_axis, load_generated
from symid.codegen import GeneratedModel
from symid.simulation import Cascade, Trajectory, chirp, plant_of, trapezoids, tuned_cascade
from symid.tuning import exact_run, without_jumps
from symid.tuning.bound import lowest_within
from symid.tuning.exact_run import ExactRun
from symid.tuning.low_pass import LowPassErrors, standard_model


@dataclass(frozen=True)
class Setup:
    """Choices that the paper does not state; see the module."""

    bandwidth_hz: float = 10.0
    seconds: float = 10.0
    quantity: str = "velocity"
    sweep: str = "logarithmic"
    rate: float = 20_000.0
    order: int = 4
    acceleration: float = 5.0
    jerk: float = 1e5
    slow_cutoff_hz: float = 100.0

    def chirp(self) -> Trajectory:
        """The chirp; its size does not matter, since the axis is linear."""
        return chirp(
            0.1,
            100.0,
            self.seconds,
            0.01 if self.quantity == "velocity" else 1e-4,
            sampling_period=1 / self.rate,
            quantity=self.quantity,
            sweep=self.sweep,
        )

    def trapezoids(self, rate: float) -> Trajectory:
        """Moves there and back at three speeds."""
        speeds, limits = (0.1, 0.25, 0.5), {"acceleration": self.acceleration, "jerk": self.jerk}
        return trapezoids([0.2], speeds, dwell=0.2, sampling_period=1 / rate, **limits)

    def controller(self, axis: Axis) -> Cascade:
        """PI velocity loop."""
        plant = plant_of(axis, NOMINAL)
        return tuned_cascade(plant, "q2", self.bandwidth_hz).with_gains(position_gain=0.0)


DEFAULT = Setup()
FULL = load_axis("direct_2m1s")
LINEAR = without_jumps(FULL)


@cache
def model(method: int) -> GeneratedModel:
    """Model of a method without Coulomb friction, as [38]-[44]."""
    return compiled(derive(LINEAR, METHODS[method]))


@cache
def chirp_run(setup: Setup = DEFAULT) -> ExactRun:
    return exact_run(LINEAR, NOMINAL, setup.chirp(), setup.controller(LINEAR))


@cache
def trapezoid_run(setup: Setup = DEFAULT, coulomb: bool = False) -> ExactRun:
    axis = FULL if coulomb else LINEAR
    return exact_run(axis, NOMINAL, setup.trapezoids(setup.rate), setup.controller(axis))


def nominal(name: str) -> float:
    """Nominal value of a physical or minimal parameter, or of the rigid model."""
    rigid = {"M": NOMINAL["Mm"], "Fv": NOMINAL["Fvm"], "Fs": NOMINAL["Fsm"]}
    if name in NOMINAL or name in rigid:
        return {**NOMINAL, **rigid}[name]
    of_method_1 = model(1)
    values = of_method_1.minimal_parameters(*(NOMINAL[n] for n in of_method_1.physical_units))
    return float(dict(zip(of_method_1.minimal_units, values, strict=True))[name])


def error(name: str, value: float) -> float:
    return 100.0 * (value / nominal(name) - 1.0)


def worst(found: Mapping[str, float], names: Mapping[str, object] | tuple[str, ...]) -> float:
    return max(abs(error(name, found[name])) for name in names)


def low_pass_errors(setup: Setup = DEFAULT, filter_force: bool = False) -> LowPassErrors:
    """Errors of the standard model by cutoff, with exact derivatives at 10 kHz [35]."""
    return LowPassErrors(
        standard_model(LINEAR), chirp_run(setup), NOMINAL, 10_000.0, setup.order, filter_force
    )


def identified(
    method: int, log: Log, cutoff_hz: float, setup: Setup = DEFAULT, late: float = 0.0
) -> dict[str, float]:
    """Minimal and physical parameters of a log by a method."""
    settings = Preparation(
        cutoff_hz=cutoff_hz, order=setup.order, decimation=1, late={"Fm": late}, difference_order=2
    )
    found = identify(model(method), log, preparation=settings, examine=False)
    return {**found.minimal_parameters, **found.physical_parameters}


def tuned_rate(method: int, setup: Setup = DEFAULT, cutoff_hz: float = CUTOFF) -> float:
    """Sampling frequency at which the largest error is 1 %, of the minimal parameters for method 1 [37]."""

    def errors(rate: float) -> dict[str, float]:
        found = identified(method, chirp_run(setup).log(rate, METHODS[method]), cutoff_hz, setup)
        return {name: error(name, found[name]) for name in (TABLE_3 if method == 1 else PHYSICAL)}

    return lowest_within(errors, [float(f) for f in np.geomspace(1000, 16000, 9)], 1.0).frequency_hz


def rigid_estimate(setup: Setup = DEFAULT) -> dict[str, float]:
    """Rigid model [45] from the flexible axis with Coulomb friction, 20 Hz, 250 Hz."""
    log = trapezoid_run(setup, coulomb=True).log(250.0, ("q2",))
    renamed = Log.from_arrays({"q": log["q2"], "F": log["Fm"]}, sampling_period=log.sampling_period)
    settings = Preparation(cutoff_hz=20.0, order=setup.order, decimation=1, difference_order=2)
    return identify(load_generated("rigid_1m"), renamed, preparation=settings).physical_parameters


def inverse_intervals(table: int) -> dict[str, tuple[float, float, float]]:
    """Physical parameters of printed minimal ones: value, and the range that a unit of their last digits leaves."""
    printed = {3: TABLE_3, 7: TABLE_7, 9: TABLE_9}[table]
    values = np.array([value for value, _ in printed.values()])
    of_method_1 = model(1)
    corners = itertools.product((-1.0, 0.0, 1.0), repeat=len(values))
    found = np.array([
        of_method_1.physical_parameters(*(values + np.array(corner) * LAST_DIGITS[table]), branch=0)
        for corner in corners
    ])  # fmt: skip
    middle = of_method_1.physical_parameters(*values, branch=0)
    return {
        name: (float(middle[i]), float(found[:, i].min()), float(found[:, i].max()))
        for i, name in enumerate(of_method_1.physical_units)
    }


def print_table(title: str, printed: Printed, ours: Mapping[str, float]) -> None:
    """The paper's estimates and errors beside ours."""
    print(
        f"\n{title}\n{'':5}{'paper':>13}{'ours':>13}{'difference':>12}{'error, paper':>14}{'error, ours':>13}"
    )
    for name, (value, paper_error) in printed.items():
        difference = 100.0 * (ours[name] / value - 1.0)
        print(
            f"{name:5}{value:13.6g}{ours[name]:13.6g}{difference:10.4f} %{paper_error:12.5f} %"
            f"{abs(error(name, ours[name])):11.5f} %"
        )


def print_inverse(title: str, table: int, printed: Printed) -> None:
    """Physical parameters by the inverse map of the printed minimal ones, beside those printed."""
    print(f"\n{title}\n{'':5}{'paper':>13}{'inverse map':>13}{'range that the digits leave':>32}  within")
    for name, (value, _) in printed.items():
        middle, low, high = inverse_intervals(table)[name]
        within = low <= value * (1 + 1e-5) and value * (1 - 1e-5) <= high
        print(f"{name:5}{value:13.7g}{middle:13.7g}{low:18.7g} to {high:.7g}  {'yes' if within else 'NO'}")


def print_chirp_tables() -> None:
    """Tables 2 to 6."""
    low_pass = low_pass_errors()
    tuned = lowest_within(low_pass.errors, low_pass.scan(17), 0.01).frequency_hz
    for cutoff in (CUTOFF, tuned):
        errors = low_pass.errors(cutoff)
        ours = {name: NOMINAL[name] * (1 + errors[name] / 100) for name in PHYSICAL}
        whose = "the paper's" if cutoff == CUTOFF else "tuned by [35]"
        print_table(f"Table 2, standard model, cutoff {cutoff:.2f} Hz ({whose})", TABLE_2, ours)
    filtered = max(map(abs, low_pass_errors(filter_force=True).errors(CUTOFF).values()))
    print(f"\nWith the force filtered too the largest error is {filtered:.0e} %: then [35] decides nothing.")
    for method, tables, rates in (
        (1, ((3, TABLE_3), (4, TABLE_4)), (8397.99,)),
        (2, ((5, TABLE_5),), (8396.50,)),
        (3, ((6, TABLE_6),), (8036.35,)),
    ):
        for rate in (*rates, tuned_rate(method)):
            ours = identified(method, chirp_run().log(rate, METHODS[method]), CUTOFF)
            whose = "the paper's" if rate in rates else "tuned by [37]"
            for number, printed in tables:
                print_table(f"Table {number}, method {method}, {rate:.2f} Hz ({whose})", printed, ours)
    for method, number, printed, rate in ((2, 5, TABLE_5_INITIAL, 8791.62), (3, 6, TABLE_6_INITIAL, 8289.06)):
        ours = identified(method, chirp_run().log(rate, METHODS[method]), CUTOFF)
        print_table(f"Table {number}, method {method}, {rate:.2f} Hz ([36], its first guess)", printed, ours)
    print_inverse("Table 4 from the minimal parameters printed in Table 3", 3, TABLE_4)


def print_trapezoid_tables() -> None:
    """Tables 7 to 11."""
    for rate, cutoff, tables in (
        (8000.0, CUTOFF, ((7, TABLE_7), (8, TABLE_8))),
        (250.0, DEFAULT.slow_cutoff_hz, ((9, TABLE_9), (10, TABLE_10))),
    ):
        ours = identified(1, trapezoid_run().log(rate, METHODS[1]), cutoff)
        for number, printed in tables:
            print_table(
                f"Table {number}, method 1, trapezoids at {rate:g} Hz, cutoff {cutoff:g} Hz", printed, ours
            )
    print_inverse("Table 8 from the minimal parameters printed in Table 7", 7, TABLE_8)
    print_inverse("Table 10 from the minimal parameters printed in Table 9", 9, TABLE_10)
    print_table("Table 11, rigid model, 250 Hz, cutoff 20 Hz", TABLE_11, rigid_estimate())


WHY = """
What cannot be met, and why
- Tables 3 and 4: the rate at which the largest error is 1 % comes out within 1 % of the paper's. X3 has no such error
  here; X2 and X5 have the paper's size, X2 the other sign.
- Tables 5 and 6: the largest error is 1 % at a lower sampling frequency than the paper's. At 8 kHz the loss of repeated
  central differences, sin(w Td)/(w Td), explains 0.13 % of Ms, which the paper has too; its further errors of Fvm and
  Fvs are those "introduced by the simulation of the system", as it says itself. Ours is exact between samples;
  `fixed_step` has an integrator of third order in its place, and with it comes near the paper's frequencies.
- Tables 7 to 10 depend on how sharp the trapezoids are (see --vary), which the paper does not give; the order of
  magnitude at 8 kHz and the loss of the flexible mode at 250 Hz do not. At 250 Hz every figure of the flexible part is
  arbitrary: another cutoff gives other hundreds of percent. X2 is lost too, which the paper's 14 % does not show;
  its 93 % of Fvs does."""


def main(arguments: list[str] | None = None) -> None:
    parts: tuple[Callable[[], None], ...] = (print_chirp_tables, print_trapezoid_tables)
    vary = parser_of(__doc__, vary=False).parse_args(arguments).vary
    for part in parts:
        part()
    print(WHY)
    if vary:
        from benchmarks.paper_variation import print_variation  # it needs this module

        print_variation()


if __name__ == "__main__":
    main()
