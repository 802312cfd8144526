"""A quick slice of benchmarks/bad_input.py: strange options, JSON fields, tables and headers."""

import json
import time
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings, strategies as st

from benchmarks.bad.cases import BASES, READ_BY, Case, cases, fields, with_changed_field, with_each_option
from benchmarks.bad.outcome import good_folder, outcome_in_a_copy


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    folder = tmp_path_factory.mktemp("good")
    return folder, good_folder(folder)


MOST_SECONDS, SPENT = 1.0, Counter[str]()
"""Processor time after which the other options of a slow command are left to another run, and that of each so far."""


def check(case: Case, folder: Path) -> None:
    outcome = outcome_in_a_copy(case, folder)
    assert not outcome.is_failure, f"{case}: {outcome}"


@settings(max_examples=20, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_drawn_cases(good: tuple[Path, dict[str, str]], data: st.DataObject) -> None:
    folder, texts = good
    check(data.draw(cases(texts)), folder)


@pytest.mark.parametrize("base", [base for base in BASES if base != "demo"])  # run in tests/cli
@settings(max_examples=2, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(st.data())
def test_each_option_of_each_command(
    base: str, good: tuple[Path, dict[str, str]], data: st.DataObject
) -> None:
    for case in data.draw(with_each_option(base).flatmap(st.permutations)):
        if SPENT[base] > MOST_SECONDS:
            break
        begin = time.process_time()
        check(case, good[0])
        SPENT[base] += time.process_time() - begin


@pytest.mark.parametrize("file", READ_BY)
@settings(max_examples=2, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(st.data())
def test_each_field_of_each_file(file: str, good: tuple[Path, dict[str, str]], data: st.DataObject) -> None:
    folder, texts = good
    for field in fields(json.loads(texts[file])):
        check(data.draw(with_changed_field(file, texts[file], field)), folder)


def test_a_traceback_and_a_loss_would_be_seen(
    good: tuple[Path, dict[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, _ = good

    def broken(arguments: list[str]) -> None:
        if arguments == ["fail"]:
            raise ValueError
        Path("run.csv").unlink()

    monkeypatch.setattr("benchmarks.commands.main", broken)
    assert outcome_in_a_copy(Case(("fail",)), folder).verdict == "traceback"
    assert outcome_in_a_copy(Case(("lose",)), folder).verdict == "lost"
