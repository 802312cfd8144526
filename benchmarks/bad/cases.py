"""Drawn cases: a valid command with a few of its options, JSON fields, columns or lines made strange."""

import contextlib
import functools
import io
import json
import operator
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import polars as pl
from hypothesis import strategies as st

from symid.cli.command_line import group

WORDS = (
    "", " ", "0", "-0", "-1", "1", "2", "1e-9", "1e9", "1e300", "1e-300", "1e400", "nan", "inf", "-inf", "²", "½", "١٢",
    "0x10", "1_000", "+5", " 5 ", "1,5", "1;2", "1,2,3", ",", "=", "a=", "=b", "q", "F", "t", "q=q", "q=", "F=nan",
    "F=1e9", "F=-500us", "F=9**9**9**9", "q=m", "q=Grad", "q=9**9**9**9", "q=1e9s", "q=1e-320", "Kpp=30", "Kpp=nan",
    "Kpp=-1", "Kxx=1", "M", "q,ddq", "1e300GB", "1kB", "1e-9MB", "-5GB", "nanGB", "run.csv", "P.json", "M.json",
    "R.json", "nowhere.csv", ".", "..", "/dev/null", "/dev/zero", "pipe", "../x", "a/b", "a" * 300, "\x1b[2J",
    "caf\udce9", "\x00", "[/bold]", "$x_{$", "None", "lambda: 0", "wls", "oe", "all", "motion", "trapezoids", "chirp",
    "multisine", "0.5,20", "20,0.5", "0,0", "nan,1", "1,1e9", "M=5", "M=-5", "M=nan",
    "M=0,1", "Fv=3+-1", "M=1..9", "M=5kg", "M=5N", "jerk=0", "speed=0.1", "speed=-1", "lowest=nan", "ok,biased",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 1e308, -1e308, 1e-320, 10**400, "", "12", "x", [], [1], {}, {"value": 1},
    {"value": None}, {"a": {"b": []}}, [[1, 2], [3]], ["q"], "hex", "rot13", "utf-16", ";", "\n", "\x1b[2J",
    "9**9**9**9", {"q": 5}, [None], float("nan"), float("inf"), "[" * 2000,
)  # fmt: skip

BASES = (
    "identify rigid_1m run.csv",
    "compare R.json P.json",
    "import foreign.csv --axis rigid_1m",
    "simulate rigid_1m --parameters P.json --rate 500 --output out/s.csv --overwrite",
    "export rigid_1m --parameters R.json --to json",
    "export rigid_1m --parameters P.json --to c",
    "export rigid_1m --parameters P.json --to mjcf",
    "export rigid_1m --parameters P.json --to st",
    "export rigid_1m --parameters R.json --to urdf",
    "batch rigid_1m run.csv --output out/r.parquet --jobs 1",
    "fleet results.parquet",
    "fleet results.parquet --joint",
    "show rigid_1m",
    "new own",
    "generate own_axis.py",
    "tune rigid_1m --parameters P.json --rate 4000 --seconds 1",
    "diagnose rigid_1m run.csv",
    "excite rigid_1m --parameters P.json --noise q=1e-6 --noise F=0.1 --limits travel=0.1,speed=0.5,acceleration=5 "
    "--seconds 2 --rate 500 --seeds 0 --runs 4 --output out/e.csv",
    "demo",
)
"""Commands that work and are quick."""
_LEFT_OUT = ("--help", "--scheduler", "--dark", "--light")


def _options_of(base: str) -> tuple[tuple[str, bool], ...]:
    """Every option of a command, and whether it is a flag."""
    command = group.get_command(click.Context(group), base.split()[0])
    assert command is not None
    found = [
        (name, bool(getattr(parameter, "is_flag", False)))
        for parameter in command.params
        for name in (*parameter.opts, *parameter.secondary_opts)
    ]
    return tuple((name, flag) for name, flag in found if name.startswith("--") and name not in _LEFT_OUT)


READ_BY = {
    "P.json": ("export rigid_1m --parameters P.json --to json", "simulate rigid_1m --parameters P.json --rate 500 "
               "--travel 0.01 --output out/s.csv --overwrite", "identify rigid_1m run.csv --nominal P.json",
               "compare R.json P.json", "diagnose rigid_1m run.csv --nominal P.json"),
    "R.json": ("export rigid_1m --parameters R.json --to json", "identify rigid_1m run.csv --nominal R.json",
               "compare R.json R.json", "compare P.json R.json", "identify rigid_1m run.csv --prior R.json"),
    "Q.json": ("identify rigid_1m run.csv --prior Q.json",),
    "M.json": ("identify rigid_1m foreign.csv --mapping M.json", "batch rigid_1m foreign.csv --mapping M.json --output "
               "out/m.parquet --jobs 1"),
}  # fmt: skip
"""Commands that read a JSON file."""
COLUMNS = (
    "log",
    "axis",
    "status",
    "measured",
    "M",
    "M_std",
    "Fv",
    "X1",
    "recorded",
    "factors",
    "key",
    "samples",
)
LINES = (
    "t,q,F", 't,"q,F', "t;q;F", "t,q [9**9**9**9],F", "t,q [],F", "t,q,q", ",,", "t,q,F\x00", "t\tq\tF",
    "t,q [µm],F [Nm]", '"' * 70_000, "t,q,F" + "," * 3000, "1,2,3", "t,q,F\x1b[2J", "", "{}",
    "t [min],q [Grad],F [kN]", "caf\udce9,q,F",
)  # fmt: skip


_ROWS = "".join(f"{i / 100},{i % 9},{i % 7}\n" for i in range(300))


@dataclass(frozen=True)
class Case:
    """A command and the changes of its files."""

    arguments: tuple[str, ...]  # of the command line
    file: str = ""  # file that is changed; empty for none
    # its new text; for a table of results ``COLUMN`` and a JSON value that all its cells get
    change: str = ""

    def prepare(self, folder: Path) -> None:
        if self.file.endswith(".parquet"):
            _change_table(folder / self.file, *self.change.split(" ", 1))
        elif self.file:
            (folder / self.file).write_text(self.change, encoding="utf-8", errors="surrogateescape")


def _change_table(file: Path, column: str, value: str) -> None:
    table = pl.read_parquet(file)
    with contextlib.suppress(TypeError, OverflowError, ValueError, pl.exceptions.PolarsError):
        cells = pl.Series(column, [json.loads(value)] * table.height, strict=False)
        changed = io.BytesIO()
        table.with_columns(cells).write_parquet(changed)
        file.write_bytes(changed.getvalue())


@st.composite
def _options(draw: st.DrawFn) -> Case:
    base = draw(st.sampled_from(BASES))
    arguments = base.split()
    for option, flag in draw(st.lists(st.sampled_from(_options_of(base)), min_size=1, max_size=3)):
        word = draw(st.sampled_from(WORDS) | st.text(max_size=12))
        arguments += [option] if flag else [option, word]
    if len(base.split()) > 1 and draw(st.integers(0, 9)) == 0:
        arguments[draw(st.integers(1, len(base.split()) - 1))] = draw(st.sampled_from(WORDS))
    return Case(tuple(arguments))


def with_each_option(base: str) -> st.SearchStrategy[tuple[Case, ...]]:
    """A command with each of its options in turn."""
    command = tuple(base.split())
    return st.tuples(
        *(
            st.just(Case((*command, name)))
            if flag
            else st.sampled_from(WORDS).map(lambda word, name=name: Case((*command, name, word)))
            for name, flag in _options_of(base)
        )
    )


def fields(record: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Keys that lead to each field of a record.

    >>> list(fields({"a": [1, 2]}))
    [('a',), ('a', 0), ('a', 1)]
    """
    for key in record if isinstance(record, dict) else range(len(record)):
        yield (*place, key)
        if isinstance(record[key], (dict, list)):
            yield from fields(record[key], (*place, key))


@st.composite
def with_changed_field(draw: st.DrawFn, file: str, text: str, field: tuple[Any, ...]) -> Case:
    """A command that reads a JSON file in which one field is changed, renamed or gone, or whose end is cut off."""
    record = json.loads(text)
    place = functools.reduce(operator.getitem, field[:-1], record)
    key = field[-1]
    how = draw(st.integers(0, 9))
    if how == 0:
        del place[key]
    elif how == 1 and isinstance(place, dict):
        place[draw(st.sampled_from(WORDS))] = place.pop(key)
    else:
        place[key] = draw(st.sampled_from(VALUES))
    text = json.dumps(record)
    if how == 2:
        text = text[: draw(st.integers(0, len(text)))]
    return Case(tuple(draw(st.sampled_from(READ_BY[file])).split()), file, text)


_tables = st.builds(
    lambda column, value, joint: Case(
        ("fleet", "results.parquet", *joint, "--report", "out/f.html"), "results.parquet", f"{column} {value}"
    ),
    st.sampled_from(COLUMNS),
    st.sampled_from([json.dumps(value) for value in VALUES if value != 10**400]),
    st.sampled_from([(), ("--joint",), ("--by", "folder")]),
)
_journals = st.builds(
    lambda name, value: Case(
        ("batch", "rigid_1m", "run.csv", "--output", "out/j.parquet", "--jobs", "1"),
        "out/j.parquet.journal",
        json.dumps({"log": "run.csv", "status": "ok", "key": "k", "axis": "rigid_1m", name: value}) + "\n",
    ),
    st.sampled_from(COLUMNS),
    st.sampled_from(VALUES),
)
_headers = st.builds(
    lambda line, command: Case(
        (*command, "changed.csv"),
        "changed.csv",
        line + "\n" + "".join(f"{i / 100},{i % 9},{i % 7}\n" for i in range(300)),
    ),
    st.sampled_from(LINES) | st.text(max_size=20),
    st.sampled_from([("identify", "rigid_1m"), ("import", "--axis", "rigid_1m"), ("import",)]),
)


def cases(texts: dict[str, str]) -> st.SearchStrategy[Case]:
    """Cases; `texts` are those of the JSON files as they should be."""
    options = _options()
    places = [(file, texts[file], field) for file in READ_BY for field in fields(json.loads(texts[file]))]
    changed = st.sampled_from(places).flatmap(lambda place: with_changed_field(*place))
    return st.one_of(options, options, options, changed, changed, _tables, _journals, _headers)
