"""A diagnosis as JSON record and as printed tables."""

import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_example import KINDS, diagnosis_example, without_nominal
from rich.console import Console

from symid.cli.options import write_json
from symid.diagnosis import Level
from symid.diagnosis.findings.gap import Removed
from symid.diagnosis.findings.waterfall import waterfall
from symid.report.tables.diagnosis import diagnosis_record, print_diagnosis

PROMISED = {
    "axis",
    "measured",
    "verdict",
    "gap",
    "location",
    "effects",
    "alternatives",
    "probabilities",
    "next_experiment",
}
"""Keys that interface.md fixes."""
GAP = {"signal", "unit", "nominal", "reidentified", "explained", "noise_floor", "closed_fraction"} | {
    "unexplained_share",
    "reversal",
    "motion",
}


def printed(record: dict[str, object]) -> str:
    console = Console(file=io.StringIO(), width=200, highlight=False, soft_wrap=True)
    print_diagnosis(record, console)
    return console.file.getvalue()


@pytest.mark.parametrize("kind", KINDS)
def test_record_has_the_keys_that_programs_rely_on(kind):
    record = diagnosis_record(diagnosis_example(kind))
    assert set(record) >= PROMISED
    assert set(record["gap"]) >= GAP
    for level in ("nominal", "reidentified", "explained", "noise_floor"):
        assert set(record["gap"][level]) == {"rms", "relative"}
    assert all(set(place) == {"at", "share", "band_hz", "regime"} for place in record["location"])
    assert all(set(other) >= {"effect", "at", "probability"} for other in record["alternatives"])
    assert set(record["probabilities"]) == {"no_gap", "parameters", "unexplained"}
    assert bool(record["effects"]) == (record["verdict"] in ("effect", "partly"))
    assert all(set(effect["removes"]) == {"share", "low", "high"} for effect in record["effects"])
    assert record["gap"]["motion"] is None


def test_record_of_an_effect():
    record = diagnosis_record(diagnosis_example("two effects"))
    first, second = record["effects"]
    assert (first["effect"], first["at"]) == ("stribeck_friction", "motor")
    assert first["parameters"]["vs"] == {"value": 0.0203, "std": 0.0005, "unit": "m/s"}
    assert second["gap_after"].keys() == {"rms", "relative"}
    assert second["indistinguishable_from"] == [{"effect": "actuator_lag", "at": "actuator"}]


def test_record_of_a_part_says_what_stays():
    record = diagnosis_record(diagnosis_example("partly"))
    assert record["verdict"] == "partly"
    assert 0.1 < record["gap"]["unexplained_share"] < 1
    assert record["effects"][0]["removes"] == {"share": 0.71, "low": 0.66, "high": 0.75}
    assert set(record["gap"]["reversal"]) == {"reidentified", "explained"}
    assert set(record["gap"]["reversal"]["explained"]) == {"rms", "relative"}


def test_record_of_a_damaged_recording_names_the_fault_and_no_effect():
    record = diagnosis_record(diagnosis_example("recording"))
    assert record["verdict"] == "recording"
    assert record["effects"] == []
    (fault,) = record["faults"]
    assert fault in record["sentence"]


def test_a_part_is_printed_with_its_interval_and_the_error_at_reversals():
    text = printed(diagnosis_record(diagnosis_example("partly")))
    assert "71 % (66 to 75 %)" in text
    assert "within 50 ms of reversals: " in text
    assert "the motion repeats every 2.5 s: " in text
    found = diagnosis_example("partly")
    still = replace(found, gap=replace(found.gap, reversal=None))
    assert diagnosis_record(still)["gap"]["reversal"] is None
    assert "reversals" not in printed(diagnosis_record(still))


def test_a_share_that_is_not_known_is_left_open():
    found = diagnosis_example("effect")
    (effect,) = found.effects
    unknown = replace(effect, removes=Removed(math.nan, math.nan, math.nan))
    assert "nan" not in printed(diagnosis_record(replace(found, effects=(unknown,))))


def test_numbers_that_are_not_known_are_null_in_the_file(tmp_path):
    file = tmp_path / "diagnosis.json"
    write_json(diagnosis_record(without_nominal(diagnosis_example("parameters"))), str(file))
    record = json.loads(file.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert record["gap"]["nominal"] is None
    assert record["gap"]["closed_fraction"] is None
    assert record["parameters"]["Mm"]["nominal"] is None


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_stages_take_away_and_the_floor_add_up_to_the_nominal_gap(kind):
    found = diagnosis_example(kind)
    stages = waterfall(found)
    assert stages[0].level == found.gap.nominal
    assert math.isnan(stages[0].removed)
    taken = sum(stage.removed for stage in stages[1:])
    assert taken + found.gap.noise_floor.rms == pytest.approx(found.gap.nominal.rms)


def test_waterfall_without_nominal_values_begins_with_the_identified_ones():
    stages = waterfall(without_nominal(diagnosis_example("effect")))
    assert stages[0].level is None
    assert math.isnan(stages[0].multiple)
    assert math.isnan(stages[1].removed)
    assert stages[2].removed > 0


def test_a_floor_of_zero_gives_no_multiples():
    found = diagnosis_example("effect")
    stages = waterfall(replace(found, gap=replace(found.gap, noise_floor=Level(0.0, 0.0))))
    assert np.isnan([stage.multiple for stage in stages]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_verdict_is_printed_first_and_all_else_after_it(kind):
    found = diagnosis_example(kind)
    text = printed(diagnosis_record(found))
    assert text.startswith(found.sentence)
    for level in (found.gap.nominal, found.gap.explained):
        assert f"{level.rms:.4g}" in text
    for part in (*(change.name for change in found.parameters), *found.assumptions, *found.faults):
        assert part in text
    assert f"next: {found.next_experiment}" in text


def test_names_that_look_like_markup_are_printed_as_they_are():
    found = diagnosis_example("effect")
    place = replace(found.location[0], at="[red]motor[/red]")
    text = printed(diagnosis_record(replace(found, logs=("run [1].csv",), location=(place,))))
    assert "run [1].csv" in text
    assert "[red]motor[/red]" in text


def test_missing_nominal_values_are_reported():
    assert "none given" in printed(diagnosis_record(without_nominal(diagnosis_example("effect"))))
