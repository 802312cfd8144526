"""The paper's axis at 250 Hz under a drive that runs at 8 kHz: output error of the simulated closed loop.

The log contains every 32nd sample of position, force and commanded position. The controller feeds the noise of the
encoder back, so that the logged force is a point sample of chatter; one-step prediction, which takes it as the force
between samples, fails here. The gains and the rate of the controller are known. Its reference is either the logged one,
by splines, or the exact one (a trajectory given in Python). Table 10 of the paper: Ms 24 %, Ks 92 %. For several levels
of noise of force sensor and encoder, it prints errors and standard deviations of the parameters in %. Takes 4 to 8
minutes.

Usage: python -m benchmarks.closed_loop [--quick]
"""

import time
from collections.abc import Mapping

import numpy as np

import symid
from benchmarks.options import parser_of
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.simulation import ClosedLoop, Trajectory, plant_of, simulate, trapezoids, tuned_cascade

PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
DRIVE_HZ, LOG_HZ = 8000.0, 250.0
NOISES = ((1.0, 20e-9), (5.0, 100e-9))  # N, m


def reference(speeds: tuple[float, ...] = (0.1, 0.25, 0.5)) -> Trajectory:
    """Back and forth at several speeds."""
    return trapezoids(
        [0.3], speeds, acceleration=10.0, jerk=2000.0, dwell=0.2, sampling_period=1.0 / DRIVE_HZ
    )


def found(
    noise: tuple[float, float],
    *,
    exact: bool,
    speeds: tuple[float, ...] = (0.1, 0.25, 0.5),
    nominal: Mapping[str, float] | None = None,
    seed: int = 1,
) -> OutputErrorIdentification:
    """Estimate from a log of the axis with noise of force and encoder."""
    axis, path = symid.load_axis("direct_2m1s"), reference(speeds)
    controller = tuned_cascade(plant_of(axis, PAPER), "q2")
    noisy = axis.with_signal("Fm", noise=noise[0]).with_signal("q2", noise=noise[1])
    log = simulate(noisy, PAPER, path, controller, frequency_hz=LOG_HZ, seed=seed).log
    loop = ClosedLoop(axis, controller, DRIVE_HZ, path if exact else None)
    model = symid.load_generated("direct_2m1s", ("q2",))
    return identify_output_error(axis, model, log, loop=loop, nominal=nominal)


def print_row(label: str, estimate: OutputErrorIdentification, seconds: float) -> None:
    """Errors and deviations of all parameters in percent."""
    deviations = np.sqrt(np.diag(estimate.physical_covariance(corrected=True)))
    cells = (
        f"{name} {100 * (value / PAPER[name] - 1):+.2f} ({100 * std / PAPER[name]:.2f})"
        for (name, value), std in zip(estimate.physical_parameters.items(), deviations, strict=True)
    )
    print(f"{label:32} {estimate.status:8} {'  '.join(cells)}  {seconds:.0f} s", flush=True)


def main() -> None:
    quick = parser_of(__doc__, quick=False).parse_args().quick
    for noise in NOISES[: 1 if quick else None]:
        for exact in (True,) if quick else (True, False):
            begin = time.perf_counter()
            estimate = found(noise, exact=exact)
            label = f"{noise[0]:g} N, {1e9 * noise[1]:g} nm, {'exact' if exact else 'logged'} reference"
            print_row(label, estimate, time.perf_counter() - begin)


if __name__ == "__main__":
    main()
