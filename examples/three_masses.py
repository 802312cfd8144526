"""Three masses and two springs: two accelerometers resolve the ambiguity that the motor's scale alone leaves."""

import numpy as np

from symid import Preparation, derive, identify, load_axis, simulate
from symid.simulation import multisine, plant_of, trapezoids, tuned_cascade

TRUE = {
    "Ms": 2000.0, "Fvs": 8000.0, "Ks": 1.2e8, "Mm": 250.0, "Fvm": 90.0, "Fsm": 60.0, "Kl": 4e6, "Fl": 900.0, "Ml": 80.0,
}  # fmt: skip


def main() -> None:
    """Print who is determined by which sensors, then identify with three of them."""
    axis = load_axis("direct_3m2s")
    for measured in (("q2",), ("q2", "ddq1", "ddql")):
        solutions = derive(axis, measured).parameter_map.identifiability
        several = [name for name, kind in solutions.items() if kind == "several"]
        print(
            f"{', '.join(measured)}: {'several solutions for ' + ', '.join(several) if several else 'unique'}"
        )
    for signal, noise in (("q2", 2e-9), ("ddq1", 2e-3), ("ddql", 2e-3), ("Fm", 1.0)):
        axis = axis.with_signal(signal, noise=noise)
    lines = np.arange(2, 160, 2) / 2.0
    period = (
        1 / 80_000
    )  # of the controller: accelerometers feel the steps of its force, which the log does not show
    moves = trapezoids([0.2], [0.1, 0.5], acceleration=10.0, jerk=2000.0, sampling_period=period)
    shaking = multisine(lines, 1.0, sampling_period=period, quantity="acceleration", seconds=4.0)
    reference = moves.then(shaking)  # friction shows in the moves, springs in the multisine
    controller = tuned_cascade(plant_of(axis, TRUE), "q2", bandwidth_hz=40.0)
    log = simulate(axis, TRUE, reference, controller, frequency_hz=8000.0).log
    held = Preparation(
        late={"Fm": -period / 2}
    )  # held over a period of the controller, it acts half of it late
    found = identify(derive(axis, ("q2", "ddq1", "ddql")), log, preparation=held)
    print(found.status)
    for name, value in found.physical_parameters.items():
        print(f"{name:4} {value:9.3g}  true {TRUE[name]:9.3g}")


if __name__ == "__main__":
    main()
