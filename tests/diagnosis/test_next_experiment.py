"""The next experiment: the probability that it decides beside how often it does, and limits that the axis keeps."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.next_experiment import experiment, rivals, rows
from symid import Position, load_axis
from symid.diagnosis.experiment import design
from symid.diagnosis.experiment.design import next_experiment_of
from symid.diagnosis.experiment.discrimination import Rivals
from symid.diagnosis.experiment.simulated import simulated_experiment
from symid.diagnosis.findings.planned_experiment import Separation
from symid.report.tables.diagnosis import diagnosis_record
from symid.simulation import Limits
from symid.text import spoken


@pytest.fixture(scope="module")
def found():
    """A delay that a diagnosis has found, with a lag as its rival."""
    return rivals()


@pytest.fixture(scope="module")
def pair(found) -> Rivals:
    return found[1]


def test_the_probability_is_how_often_the_right_cause_is_chosen(pair: Rivals) -> None:
    (row,) = rows(pair, (0.01,), runs=12)
    deviation = math.sqrt(row.expected * (1 - row.expected) / row.runs)
    assert 0.6 < row.expected < 0.999  # else the comparison says nothing
    assert abs(row.share - row.expected) < 3 * deviation + 1 / row.runs


def test_it_does_not_count_on_a_sensor_that_the_log_lacks() -> None:
    axis = load_axis("rigid_1m")
    _, pair = rivals(replace(axis, sensors=(*axis.sensors, Position("second", axis.bodies[0]))))
    run = simulated_experiment(pair, experiment(0.01))
    assert [record.outputs for record in run.records] == [pair.record.outputs] * 2


def test_a_larger_motion_discriminates_more_and_none_nothing(pair: Rivals) -> None:
    small, large = (simulated_experiment(pair, experiment(size)) for size in (0.005, 0.03))
    assert large.probability > 0.999 > small.probability
    assert min(s.distance for s in large.separations) > max(s.distance for s in small.separations)


def test_two_gaussians_are_distinguished_as_drawn_samples_are() -> None:
    draw = np.random.default_rng(1)
    apart = np.array([0.9, -1.2, 0.4])
    d = float(np.linalg.norm(apart))
    readings = apart + draw.standard_normal((40_000, 3))
    likelier = np.sum(readings**2, axis=1) > np.sum((readings - apart) ** 2, axis=1)
    assert Separation(d**2 / 2, d).probability == pytest.approx(np.mean(likelier), abs=0.01)


def test_the_simulated_axis_keeps_the_limits(found) -> None:
    diagnosis, _ = found
    planned = next_experiment_of(
        diagnosis, acceleration=3.0, speed=0.15, jerk=100.0, force=400.0, seconds=3.0
    )
    run = planned.simulated
    assert run is not None
    low, high = 0.0, 0.1
    margin = 0.02 * (high - low)
    assert low - margin <= run.demand.lowest <= run.demand.highest <= high + margin
    assert run.demand.speed <= 1.02 * 0.15
    assert run.demand.acceleration <= 1.02 * 3.0
    assert run.demand.jerk <= 100.0 * (1 + 1e-6)
    assert run.force <= 1.02 * 400.0
    narrow = Limits((0.0, 0.5 * run.demand.highest), speed=1.0)
    assert "travel is exceeded" in run.exceeds(narrow, {"F": 1e9})
    assert "force reaches" in run.exceeds(Limits((-1.0, 1.0)), {"F": 0.5 * run.force})


def test_the_record_says_how_surely_it_decides(found) -> None:
    diagnosis, _ = found
    planned = next_experiment_of(diagnosis, acceleration=3.0, seconds=2.0)
    record = diagnosis_record(replace(diagnosis, next_experiment=planned.text, planned=planned))["experiment"]
    assert record["causes"] == [{"effect": effect, "at": at} for effect, at in planned.causes]
    assert record["probability"] == planned.probability == min(record["probability_if_right"])
    assert f"{100 * min(planned.probability, 0.999):.3g} %" in planned.text
    assert {(one["effect"], one["at"]) for one in record["further"]} == set(planned.further)
    assert json.dumps(record)
    assert "experiment" not in diagnosis_record(diagnosis)


def test_every_cause_that_remains_is_simulated_against(
    found, pair: Rivals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(design, "_LEAST_CHANCE", 0.0)  # the lag is all that remains of the delay's rivals
    diagnosis, _ = found
    planned = next_experiment_of(diagnosis, acceleration=3.0, seconds=2.0)
    others = {candidate.key for candidate in pair.step.confirmed} - set(planned.causes)
    assert planned.further
    assert set(planned.further) <= others
    for (effect, at), chance in planned.further.items():
        assert math.isnan(chance) or chance > 0.5
        assert f"{spoken(effect, at)} (" in planned.text
