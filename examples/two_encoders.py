"""Two incremental encoders around a coupling: the zero between them is unknown and differs from log to log."""

from math import pi, sqrt
from pathlib import Path

from symid import identify, load_axis, load_generated, read_axis_log

BENCH = Path(__file__).parents[1] / "data" / "flex_motor_bench"


def main() -> None:
    """Identify the flexible bench from each of its two logs; masses and spring must agree, the zeros need not."""
    axis = load_axis("motor_bench")  # declares UnknownZero between both encoders
    model = load_generated(axis, ("qm", "ql"))
    for which in ("A", "B"):
        log = read_axis_log(
            axis,
            BENCH / f"MultisineType{which}.mat",
            columns={"t": "time", "iq": "iq_adx", "qm": "theta_mx", "ql": "theta_my"},
            units={"t": "us"},
            gains={"ql": -1.0},  # this encoder counts the other way
        )
        p = identify(model, log).physical_parameters
        resonance = sqrt(p["Kt"] * (1 / p["Jm"] + 1 / p["Jl"])) / (2 * pi)
        print(
            f"log {which}: Jm {p['Jm']:.2e}, Jl {p['Jl']:.2e}, Kt {p['Kt']:.0f}, resonance {resonance:.0f} Hz"
        )


if __name__ == "__main__":
    main()
