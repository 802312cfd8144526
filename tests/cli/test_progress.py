"""Long work shows how fast it goes and how long it takes yet, on a terminal and nowhere else."""

import io
import time
from collections.abc import Iterator

import pytest

from symid.cli import terminal


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def slowly(items: range) -> Iterator[int]:
    for item in items:
        time.sleep(0.05)
        yield item


def test_a_terminal_is_shown_rate_and_remaining_time(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setattr(terminal, "_PATIENCE", 0.0)
    monkeypatch.setenv("TERM", "xterm")
    assert list(terminal.tracked(slowly(range(12)), "logs", total=12)) == list(range(12))
    shown = screen.getvalue()
    for part in ("logs", "/12", "/s", "0:00:0"):
        assert part in shown


def test_short_work_shows_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    assert list(terminal.tracked(range(5), "logs")) == list(range(5))
    assert screen.getvalue() == ""


def test_a_file_gets_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setattr(terminal, "_PATIENCE", 0.0)
    assert list(terminal.tracked(slowly(range(3)), "logs")) == [0, 1, 2]
    assert screen.getvalue() == ""
