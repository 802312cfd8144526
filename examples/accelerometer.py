"""An accelerometer on the structure: the same log of the paper's axis, without its reading and with it."""

from symid import Log, Preparation, identify, load_axis, load_generated, simulate
from symid.simulation import chirp, plant_of, trapezoids, tuned_cascade

TRUE = {"Ms": 3899.0, "Fvs": 39491.7, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}


def main() -> None:
    """Identify from q2 alone, method 1 of the paper, and from q2 and ddq1, method 2."""
    axis = load_axis("direct_2m1s")
    for signal, noise in (("q2", 1e-9), ("ddq1", 5e-3), ("Fm", 1.0)):
        axis = axis.with_signal(signal, noise=noise)
    moves = trapezoids([0.2], [0.1, 0.5], acceleration=10.0, jerk=2000.0, sampling_period=1 / 10000)
    sweep = chirp(5.0, 110.0, 4.0, 0.15, sampling_period=1 / 10000, quantity="velocity")
    reference = moves.then(sweep)  # friction shows in the moves, the structure in the sweep
    controller = tuned_cascade(plant_of(axis, TRUE), "q2", bandwidth_hz=40.0)
    log = simulate(axis, TRUE, reference, controller).log
    shown("q2", log)
    shown("q2, ddq1", log)


def shown(sensors: str, log: Log) -> None:
    """Print the errors of what is identified from some sensors."""
    held = Preparation(held=True)  # from sample to sample, so that it acts half a sample late
    found = identify(load_generated("direct_2m1s", tuple(sensors.split(", "))), log, preparation=held)
    values = found.physical_parameters
    errors = ", ".join(f"{name} {100 * (values[name] / TRUE[name] - 1):.1f}" for name in TRUE)
    print(f"{sensors} ({found.status}): errors in %: {errors}")


if __name__ == "__main__":
    main()
