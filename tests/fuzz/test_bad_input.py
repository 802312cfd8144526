"""A quick slice of benchmarks/bad_input.py: strange options, JSON fields, tables and headers."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.bad.cases import Case, cases
from benchmarks.bad.outcome import good_folder, outcome_in_a_copy


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    folder = tmp_path_factory.mktemp("good")
    return folder, good_folder(folder)


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_drawn_cases(good: tuple[Path, dict[str, str]], data: st.DataObject) -> None:
    folder, texts = good
    case = data.draw(cases(texts))
    outcome = outcome_in_a_copy(case, folder)
    assert not outcome.is_failure, f"{case}: {outcome}"


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
