"""Weights make noise white with unit variance; autoregressions; what is made of gains and errors."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hand_made import RIGID, motion

from symid import Log, load_axis
from symid.diagnosis.findings.comparison import Comparison
from symid.diagnosis.findings.shares import closed_fraction, removed_share, surely_decreases
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.record import record_of
from symid.diagnosis.prediction.weighting import _rests
from symid.diagnosis.selection import evidence
from symid.diagnosis.selection.evidence import Errors, outcome
from symid.estimation.autoregression import autoregression
from symid.simulation import forward_dynamics

LINEAR = {**RIGID, "Fs": 0.0}


def linear_log(noise: dict[str, float], seed: int = 0) -> Log:
    """A log without Coulomb friction: what is left of it by true values is noise alone."""
    t, path, rng = np.arange(16_000) / 2000, motion(5), np.random.default_rng(seed)
    force = (
        LINEAR["M"] * path.at(t, 2) + LINEAR["Fv"] * path.at(t, 1) + noise["F"] * rng.standard_normal(t.size)
    )
    position = path.at(t) + noise["q"] * rng.standard_normal(t.size)
    return Log("by hand", 0.0, 1 / 2000, {"F": force, "q": position})


@pytest.mark.parametrize("noise", [{"F": 1.0, "q": 1e-9}, {"F": 1.0, "q": 3e-6}, {"F": 1.0, "q": 3e-7}])
def test_noise_alone_leaves_rows_of_unit_variance(noise: dict[str, float]) -> None:
    found = []
    for seed in range(3):
        state, weighting = first_state(
            record_of(forward_dynamics(load_axis("rigid_1m")), linear_log(noise, seed), 40.0), LINEAR
        )
        found.append(np.mean(state.rows[:, weighting.kept] ** 2))
    assert np.mean(found) == pytest.approx(1.0, abs=0.3)


def test_standstill_and_ends_are_left_out() -> None:
    log = linear_log({"F": 1.0, "q": 1e-9})
    q = log["q"]
    q = np.concatenate([q[:6000], np.full(2000, q[6000]), q[6000:-2000]])
    one = record_of(
        forward_dynamics(load_axis("rigid_1m")), Log("x", 0.0, 1 / 2000, {"F": log["F"], "q": q}), 40.0
    )
    weighting = first_state(one, LINEAR)[1]
    at = one.row_time
    assert not weighting.kept[(at > 3.1) & (at < 3.9)].any()
    assert not weighting.kept[(at < 0.02) | (at > one.duration - 0.02)].any()
    assert weighting.kept[(at > 0.1) & (at < 2.9)].mean() > 0.5


def test_back_is_the_adjoint_of_rows() -> None:
    one = record_of(forward_dynamics(load_axis("rigid_1m")), linear_log({"F": 1.0, "q": 1e-7}), 40.0)
    weighting, rng = first_state(one, LINEAR)[1], np.random.default_rng(1)
    course, rows = rng.standard_normal(one.n_rows), rng.standard_normal((1, one.n_rows))
    spectrum = one.from_grid(course)
    course = one.rows(spectrum)  # what of it lies in the band
    assert np.sum(weighting.rows(spectrum[None]) * rows) == pytest.approx(
        np.sum(course * one.rows(weighting.adjoint(rows))[0]), rel=1e-6
    )


def known_autoregression(n: int = 20_000) -> np.ndarray:
    x, noise = np.zeros(n), 0.5 * np.random.default_rng(2).standard_normal(n)
    for k in range(2, n):
        x[k] = 1.2 * x[k - 1] - 0.5 * x[k - 2] + noise[k]
    return x


def test_autoregression_finds_the_known_one_and_whitens() -> None:
    x = known_autoregression()
    kept = np.ones(x.size, dtype=bool)
    kept[5000:7000] = False
    found = autoregression(np.where(kept, x, 1e3)[None], kept, 2)
    assert found.coefficients.ravel() == pytest.approx([1.2, -0.5], abs=0.02)
    assert 1 / found.whitening[0, 0] == pytest.approx(0.5, rel=0.02)
    white = found.apply(x[None])
    assert white.size == x.size - 2 - 2000 - 2
    assert np.mean(white**2) == pytest.approx(1.0, rel=0.02)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.03


@pytest.mark.parametrize(
    ("before", "after", "share"), [(5.0, 2.0, 0.75), (3.0, 1.0, 1.0), (3.0, 0.9, 1.0), (2.0, 4.0, -2.0)]
)
def test_closed_fraction(before: float, after: float, share: float) -> None:
    assert closed_fraction(np.full(4, before**2), np.full(4, after**2)) == pytest.approx(share)


def test_an_excess_in_few_blocks_is_surely_removed() -> None:
    before = np.random.default_rng(1).chisquare(1, 2400)
    after = 0.95 * before
    before[1200:1260] += 40.0
    # Draws without these blocks have no excess, of which nothing can be removed, but smaller squares all the same.
    assert removed_share(np.stack([before, before, after]), 1.5).low <= 0
    assert surely_decreases(before, after)
    assert not surely_decreases(after, before)


@pytest.mark.parametrize(("falls", "better"), [(0.01, False), (0.5, True)])
def test_a_further_effect_must_remove_more_than_some_percent_of_the_noise(falls: float, better: bool) -> None:
    """However sure the fall: a constant force at a base took 0.1 % of the noise, from the ringing as the log begins."""
    before = 1.5 + np.random.default_rng(1).chisquare(1, 2400)
    squares = {2: before, 3: before - falls}
    stub = SimpleNamespace(
        output_of=lambda model: 0,
        floors=np.ones(1),
        squares=lambda model, output: squares[model],
        excess=lambda model, output: squares[model].mean() - 1.0,
    )
    assert surely_decreases(squares[2], squares[3])
    assert Comparison._surely_better(cast(Comparison, stub), 3) == better


def test_nothing_to_close_has_no_fraction() -> None:
    assert np.isnan(closed_fraction(np.ones(4), np.ones(4)))


@pytest.mark.parametrize(
    ("nominal", "left", "verdict"),
    [
        (1.0, 1.0, "no_gap"),
        (1.02, 1.0, "no_gap"),
        (3.0, 1.0, "parameters"),
        (None, 1.0, "no_gap"),
        (9.0, 6.0, "unexplained"),
    ],
)
def test_verdict_without_any_candidate(nominal: float | None, left: float, verdict: str) -> None:
    found = outcome((), 0, Errors(nominal, left, left, float("nan")))
    assert found.verdict == verdict
    assert sum(found.as_mapping.values()) == pytest.approx(1.0)
    assert found.effect == 0.0


@pytest.mark.parametrize(
    ("stationary", "relative", "verdict"),
    [(True, 0.03, "no_gap"), (False, 0.03, "unexplained"), (True, 0.2, "unexplained")],
)
def test_noise_of_any_colour_is_no_gap_unless_it_knows_of_the_motion_or_is_large(
    stationary: bool, relative: float, verdict: str
) -> None:
    assert outcome((), 0, Errors(3.0, 3.0, 3.0, float("nan"), stationary, relative)).verdict == verdict


def test_an_error_of_a_thousandth_of_the_force_is_no_gap_however_quiet_the_sensors() -> None:
    loud = Errors(3.0, 3.0, 3.0, float("nan"), relative=0.02)
    assert outcome((), 0, loud).verdict == "unexplained"
    assert outcome((), 0, replace(loud, relative=0.001)).verdict == "no_gap"


def test_effects_below_noise_and_a_thousandth_of_the_force_are_no_cause() -> None:
    """Instants of reversals that are known to a fraction of a sample look like an effect on a quiet log."""
    step = SimpleNamespace(accepts=True)
    small = Errors(200.0, 1.42, 1.03, 0.06, relative=0.00075)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence, "probability_of_presence", lambda _: 1.0)
        patch.setattr(evidence, "_is_likeliest", lambda *_: True)
        assert outcome((step,), 1, small).verdict == "parameters"  # type: ignore[arg-type]  # of a step it is all
        assert outcome((step,), 1, replace(small, relative=0.01)).verdict == "effect"  # type: ignore[arg-type]


def test_an_axis_that_sticks_briefly_rests_and_one_that_reverses_does_not() -> None:
    through = np.abs(np.linspace(-10.0, 10.0, 21) + 0.3)
    stuck = np.concatenate([through[:9], np.full(5, 0.1), through[12:]])
    for speed, rests in ((through, 0), (stuck, 5)):
        assert _rests(speed, speed > 1.5, long=20, short=2).sum() == rests
    assert _rests(through, through > 1.5, long=3, short=2).sum() == 3
