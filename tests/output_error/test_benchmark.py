"""The quick part of benchmarks/output_error.py."""

from functools import cache

import numpy as np
import pytest

from benchmarks import cramer_rao, output_error as benchmark, output_error_bench as bench
from symid.identification import Preparation


def test_at_250_hz_mass_and_spring_of_the_structure_are_within_5_percent() -> None:
    """The paper's Table 10 has 24 % and 92 %."""
    found = benchmark.compared(benchmark.disturbed(benchmark.SMOOTH, benchmark.QUIET, 0), benchmark.SMOOTH)
    oe, wls = (benchmark.errors(found[method], benchmark.SMOOTH) for method in ("oe", "wls"))
    assert all(abs(oe[name]) < 5.0 for name in ("Ms", "Ks"))
    assert not any(abs(wls[name]) < 20.0 for name in ("Ms", "Ks"))


def test_the_bound_of_a_short_log_is_that_of_its_likelihood() -> None:
    """For known noise and from the mean alone it is generalised least squares with a vague initial state."""
    truth, period, n = benchmark.SMOOTH, 1 / 250.0, 120
    random = np.random.default_rng(0)
    force, levels = 4000.0 * np.sign(random.standard_normal(n)), np.array([5.0, 1e-7])
    _, S, free = cramer_rao.moments(truth, force, levels, period)
    vague = free[:, np.abs(free).max(axis=0) > 1e-12]  # a motor's place leaves no differences
    vague = vague / np.linalg.norm(vague, axis=0)
    factor = np.linalg.cholesky(S + 1e6 * np.trace(S) * vague @ vague.T)
    slopes = []
    for name in [key for key, value in truth.items() if value]:
        ahead, behind = (
            cramer_rao.moments({**truth, name: truth[name] * (1 + step)}, force, levels, period)[0]
            for step in (1e-5, -1e-5)
        )
        slopes.append(np.linalg.solve(factor, (ahead - behind) / 2e-5))
    of_means = np.stack(slopes, axis=1)
    least = 100 * np.sqrt(np.diag(np.linalg.inv(of_means.T @ of_means)))
    bound = np.array(list(cramer_rao.cramer_rao(truth, force, tuple(levels), period).values()))
    np.testing.assert_allclose(bound, least, rtol=0.02)  # the covariance tells hardly anything more


read = cache(bench.read)


@pytest.mark.parametrize("mean", [False, True])
def test_a_decimated_bench_keeps_its_frequencies(mean: bool) -> None:
    """5 s at 250 Hz instead of 2500: the authors name about 53 and 77 Hz."""
    log = bench.kept(read("A").window(0, 12_500), 10, mean=mean)
    found = bench.identify_output_error(
        bench.symid.load_axis("motor_bench"),
        bench.symid.load_generated("motor_bench", ("qm", "ql")),
        log,
        preparation=Preparation(held=True if mean else None),
    )
    antiresonance, resonance = bench.bench_frequencies(found.physical_parameters)
    assert antiresonance == pytest.approx(53.7, abs=1.5)
    assert resonance == pytest.approx(76.5, abs=2.5)
