"""Nothing that a file names or holds is run, and nothing that it holds commands a terminal."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest
from command_line import run
from fleet_logs import write_log

from symid.cli.terminal import is_closed, prepare_streams
from symid.codegen import load_generated
from symid.codegen.vetting import signed, vetted
from symid.errors import GeneratedModuleError

EVIL = "from pathlib import Path\nPath('PWNED').write_text('')\n"
MODULE = "import numpy as np\n\n\ndef regressor(q):\n    return {body}\n"


@pytest.mark.parametrize(
    "name", ["evil.py", "sec/evil.py", "../evil", "sec/evil", "/etc/evil", "models/evil.py"]
)
def test_a_table_names_no_file(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for place in ("evil.py", "sec/evil.py", "models/evil.py"):
        Path(place).parent.mkdir(exist_ok=True)
        Path(place).write_text(EVIL, encoding="utf-8")
    write_log(Path("a.csv"), 1)
    assert run("batch", "rigid_1m", "a.csv", "-o", "r.parquet", "--joint") == 0
    pl.read_parquet("r.parquet").with_columns(axis=pl.lit(name)).write_parquet("evil.parquet")
    capsys.readouterr()
    assert run("fleet", "evil.parquet", "--joint") == 2
    assert "which is not a name" in capsys.readouterr().err
    assert not Path("PWNED").exists()


@pytest.mark.parametrize("name", ["../evil", "a/b", "/evil", "..", "con.txt", "a b", ""])
def test_a_new_axis_is_written_into_models(name: str, folder: Path) -> None:
    assert run("new", name) == 2
    assert list(folder.parent.glob("evil.py")) == []
    assert list(folder.rglob("*.py")) == []


def test_an_axis_is_a_name_or_a_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("models").mkdir()
    Path("evil.py").write_text(EVIL, encoding="utf-8")
    assert run("show", "../evil") == 2
    assert "there is no axis '../evil'" in capsys.readouterr().err
    assert not Path("PWNED").exists()


def own_module(folder: Path) -> Path:
    assert run("new", "own", "--bodies", "1") == 0
    assert run("generate", "own") == 0
    return (
        folder / "generated" / "own__q.py"
        if (folder / "generated" / "own__q.py").exists()
        else next((folder / "generated").glob("own__*.py"))
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("import numpy as np", "import numpy as np\n" + EVIL),
        lambda text: re.sub(r"W\[0, 0\] = (\w+)", r"W[0, 0] = 2*\1", text),
        lambda text: text.replace("SIGNED = ()", "SIGNED = ('m',)"),
        lambda text: text[: text.rindex("# SHA-256")],
        lambda text: signed(text[: text.rindex("# SHA-256")].replace("import numpy as np", EVIL, 1)),
    ],
)
def test_a_changed_module_is_refused(change: object, folder: Path) -> None:
    module = own_module(folder)
    sensors = re.search(r'MEASURED = \("(\w+)"', module.read_text(encoding="utf-8"))[1]
    assert load_generated("own", (sensors,)).axis == "own"
    text = module.read_text(encoding="utf-8")
    changed = change(text)
    assert changed != text
    module.write_text(changed, encoding="utf-8")
    with pytest.raises(GeneratedModuleError, match="run: symid generate own"):
        load_generated("own", (sensors,))
    assert not Path("PWNED").exists()


@pytest.mark.parametrize(
    "body",
    [
        "__import__('os')",
        "open('x')",
        "np.load('x')",
        "np.fromfile('x')",
        "np.ctypeslib",
        "q.tofile('x')",
        "(lambda: 0)()",
        "[x for x in q]",
        "9**9**9**9",
        "9**999999",
        "q.__class__",
        "eval('1')",
        "f'{q}'",
        "np.lib.npyio",
        "(q := 1)",
        "map(exec, q)",
    ],
)
def test_no_code_but_arithmetic_runs(body: str) -> None:
    with pytest.raises(GeneratedModuleError, match=r"line \d"):
        vetted(signed(MODULE.format(body=body)))


@pytest.mark.parametrize(
    "text",
    [
        "import os\n",
        "from numpy import *\n",
        "import numpy as np, os\n",
        "while 1: pass\n",
        "class A: pass\n",
        "@np.sin\ndef f(q): return q\n",
        "def f(q=open('x')): return q\n",
        "np = 1\n",
        "del q\n",
        "a = exec\n",
    ],
)
def test_no_statement_but_those_of_modules_runs(text: str) -> None:
    with pytest.raises(GeneratedModuleError, match=r"line \d"):
        vetted(signed(text))


def test_arithmetic_runs() -> None:
    vetted(signed(MODULE.format(body="np.select([q > 0, True], [np.sin(q)**2/3, q**0.5], -np.inf)")))


ESCAPE = "\x1b[2J\x9b31m\x07"


def test_names_command_no_terminal(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = write_log(Path("a.csv"), 1)
    text = log.read_text(encoding="utf-8")
    names = (f"{ESCAPE}.csv", "[/b][bold].csv", "[red]x.csv")
    Path("[").mkdir()
    for name in names:
        Path(name).write_text(text, encoding="utf-8")
    Path("header.csv").write_text(text.replace("t,q,F", f"t,q,F{ESCAPE}", 1), encoding="utf-8")
    for name in names:
        run("identify", "rigid_1m", name)
        run("import", name, "--axis", "rigid_1m")
    run("identify", "rigid_1m", "header.csv")
    run("import", "header.csv")
    run("identify", f"{ESCAPE}axis", "a.csv")
    run("batch", "rigid_1m", "header.csv", *names, "-o", "r.parquet", "--jobs", "1")
    run("fleet", "r.parquet")
    out, err = capfd.readouterr()
    assert not any(sign in out + err for sign in "\x1b\x9b\x07")
    assert r"\x1b[2J\x9b31m\x07" in out
    assert "[/b][bold].csv" in out
    assert "fault of symid" not in err


def test_names_that_are_not_utf_8(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = write_log(Path("a.csv"), 1).read_bytes()
    frame = write_log(Path("a.parquet"), 1).read_bytes()
    for name, content in ((b"caf\xe9.csv", text), (b"caf\xe9.parquet", frame)):
        Path(os.fsdecode(name)).write_bytes(content)
        assert run("identify", "rigid_1m", os.fsdecode(name), "--json", "found.json") == 0
        assert json.loads(Path("found.json").read_text(encoding="utf-8"))["log"] == [os.fsdecode(name)]
    for reused in (0, 4):
        assert run("batch", "rigid_1m", ".", "-o", "r.parquet", "--json", "r.json", "--jobs", "1") == 0
        record = json.loads(Path("r.json").read_text(encoding="utf-8"))
        assert (record["status"], record["reused"]) == ({"ok": 4}, reused)
    assert r"caf\xe9.csv" in pl.read_parquet("r.parquet")["log"].to_list()
    assert "Traceback" not in capsys.readouterr().err


def symid(arguments: str, redirection: str = "", **environment: str) -> subprocess.CompletedProcess[str]:
    command = f'"{sys.executable}" -c "from symid.cli import main; main()" {arguments} {redirection}'
    return subprocess.run(
        command, shell=True, capture_output=True, text=True, check=False, env={**os.environ, **environment}
    )


@pytest.mark.parametrize(
    ("redirection", "environment", "code"),
    [
        (">&-", {}, 0),
        (">&- 2>&-", {}, 0),
        (">/dev/full", {}, 2),
        ("| head -c 10", {}, 0),
        ("", {"PYTHONIOENCODING": "ascii"}, 0),
        ("--json - ", {"PYTHONIOENCODING": "ascii"}, 0),
    ],
)
def test_streams_of_any_kind(redirection: str, environment: dict[str, str], code: int, folder: Path) -> None:
    done = symid("show rigid_1m", redirection, **environment)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    if "--json" in redirection:
        assert json.loads(done.stdout)["axis"] == "rigid_1m"


def test_a_reader_that_has_read_enough_is_no_failure(folder: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-c", "from symid.cli import main; main()", "show", "rigid_1m"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_closed_stream_can_be_flushed_as_worker_processes_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    prepare_streams()
    with sys.stdout as stream:
        stream.flush()
        assert is_closed(stream)


def test_the_bare_command_prints_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 0
    shown = capsys.readouterr()
    assert (shown.err, shown.out.splitlines()[0]) == ("", "Usage: symid [OPTIONS] COMMAND [ARGS]...")
