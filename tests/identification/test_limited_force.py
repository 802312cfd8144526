"""A force that is cut off, most of it faster than the cutoff."""

import numpy as np

from benchmarks.promise.faults import damaged
from benchmarks.promise.machines import draw_case
from symid import Log, identify, load_generated


def test_a_force_that_is_cut_off_faster_than_the_cutoff_is_named() -> None:
    generator = np.random.default_rng([112303, 46, 1])
    case = draw_case(generator)
    for recorded, is_named in ((case, False), (damaged(case, generator, "clipped_then_noise"), True)):
        log = Log.from_arrays(recorded.signals, sampling_period=1 / case.rate)
        found = identify(load_generated(case.axis, case.measured), log)
        is_stated = "its largest values explain" in found.message
        assert (is_stated, found.status == "ok") == (is_named, not is_named), found.message
