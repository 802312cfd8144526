"""A quick slice of benchmarks/damaged_logs.py: every kind of damage, refused in one line, with a status, or right."""

import pytest
from hypothesis import given, settings

from benchmarks.commands import FAILURES, Outcome
from benchmarks.damage.log import FORMS
from benchmarks.damage.outcome import KINDS, Damage, damages, outcome_of

FOUND_BY_FUZZING = (
    "denormal:mat:blocks:0.35836626032870417:1978297227",
    "few_rows:parquet:whole:1.1125369292536007e-308:19814097",
    "garbage:csv:whole:0.404830305436667:2847",
    "huge:csv:whole:0.6210982102283721:7470",
    "lost_rows_untold:csv:whole:0.2858569477890192:984",
    "other_unit_midway:csv:whole:0.3570750270341459:523",
    "clipped:mat:blocks:0.8042720918478803:41",
    "few_rows:parquet:blocks:0.0615447314771196:732980",
    "clipped:parquet:whole:0.15923751929217425:4294967294",
    "huge:csv:blocks:0.049874934542639485:7160",
    "other_unit_midway:parquet:whole:0.95:15",
    "other_unit_midway:csv:blocks:0.95:126914",
)


@settings(max_examples=25)
@given(damages)
def test_drawn_damage(damage: Damage) -> None:
    outcome = outcome_of(damage)
    assert not outcome.is_failure, f"{damage}: {outcome}"


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_damage(kind: str) -> None:
    damage = Damage(kind, FORMS[len(kind) % 2], len(kind) % 3 == 0, 0.5, 11)
    outcome = outcome_of(damage)
    assert not outcome.is_failure, f"{damage}: {outcome}"


@pytest.mark.parametrize("text", FOUND_BY_FUZZING)
def test_what_was_found_before(text: str) -> None:
    damage = Damage.parse(text)
    assert str(damage) == text
    refusals = "refused", "recording", "poor_fit", "not_physical", "too_few_rows", "timing"
    assert outcome_of(damage).verdict in refusals


@pytest.mark.parametrize("form", FORMS)
def test_a_good_log_is_identified(form: str) -> None:
    assert outcome_of(Damage("none", form, blocks=False, extent=0.0, seed=3)) == Outcome("ok", "")


def test_a_wrong_number_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.damage.outcome.UNTOLD", ())
    assert outcome_of(Damage("wrong_unit", "csv", False, 0.5, 1)).verdict in FAILURES
