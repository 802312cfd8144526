"""Files are written as a whole or not at all; what is read is a file."""

import json
import os
import threading
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from symid.errors import SettingError
from symid.files import free_name, irregular, read_json, replacing, require_regular, write_whole
from symid.text import one_line, visible


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    file.write_text("old", encoding="utf-8")

    def fail() -> None:
        with replacing(file) as unfinished:
            unfinished.write_text("new, half", encoding="utf-8")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert [path.read_text(encoding="utf-8") for path in tmp_path.iterdir()] == ["old"]


def test_a_full_disk_is_named_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "page.html"

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"No space left on device: .*page\.html") as failed:
        write_whole(file, "text")
    assert failed.value.filename == str(file)
    assert list(tmp_path.iterdir()) == []


def test_rights_and_links_stay(tmp_path: Path) -> None:
    file, link = tmp_path / "a.txt", tmp_path / "link.txt"
    file.write_text("old", encoding="utf-8")
    file.chmod(0o640)
    link.symlink_to(file)
    write_whole(link, "new\n")
    assert (file.read_bytes(), link.is_symlink(), file.stat().st_mode & 0o777) == (b"new\n", True, 0o640)


def test_a_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    while True:
        try:
            write_whole(pipe, "through")
            break
        except OSError:  # the reader has not opened it yet
            continue
    reader.join()
    assert (read, irregular(pipe)) == (["through"], "a pipe")


def test_a_pipe_that_nobody_reads_is_an_error_and_no_wait(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="pipe"):
        write_whole(tmp_path / "pipe", "text")


@pytest.mark.parametrize("name", ["pipe", "folder", "gone", "null\0byte", "/dev/zero"])
def test_what_is_no_file_is_not_read(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    with pytest.raises(SettingError, match=r"give a regular file|check the path"):
        require_regular(tmp_path / name)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[" * 100_000, "nested too deep"),
        ("{'a': 1}", "is not JSON"),
        ("", "is not JSON"),
        ("\xff\xfe", "is not JSON"),
    ],
)
def test_json_that_is_none_is_refused_with_its_name(text: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "x.json"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(SettingError, match=says) as refused:
        read_json(file)
    assert str(file) in str(refused.value)


def test_long_integers_are_infinite(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text("[1, " + "9" * 5000 + "]", encoding="utf-8")
    assert read_json(tmp_path / "x.json") == [1, float("inf")]


def test_a_name_that_stands_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text('{"M": 5, "Fs": {"value": 1, "value": 2}}', encoding="utf-8")
    with pytest.raises(SettingError, match=r"x\.json: holds value more than once"):
        read_json(tmp_path / "x.json")


def test_free_names_are_counted(tmp_path: Path) -> None:
    file, names = tmp_path / "r.csv", []
    for _ in range(3):
        names.append(free_name(file, ".before").name)
        (tmp_path / names[-1]).write_text("", encoding="utf-8")
    assert names == ["r.csv.before", "r.csv.before2", "r.csv.before3"]


@given(st.text())
def test_visible_text_holds_no_control_character_and_can_be_written(text: str) -> None:
    shown = visible(text)
    assert not any((ord(sign) < 32 and sign not in "\t\n") or 126 < ord(sign) < 160 for sign in shown)
    shown.encode("utf-8")
    assert "\n" not in one_line(text)
    assert json.loads(json.dumps(shown)) == shown
