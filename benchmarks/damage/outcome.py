"""Results of `symid identify` of damaged logs, judged against the truth."""

from __future__ import annotations

import io
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from benchmarks.commands import Outcome, run_command
from benchmarks.damage.kinds import OF_COLUMNS
from benchmarks.damage.log import AXIS, FORMS, TRUTH, as_bytes, good_log, write
from benchmarks.damage.of_files import OF_BYTES, OF_FRAME, OF_TEXT

KINDS = ("none", *OF_COLUMNS, *OF_BYTES, *OF_TEXT, *OF_FRAME, "wrong_suffix")

UNTOLD = ("wrong_unit",)
"""Damage that no log shows: a channel that is scaled as a whole gives a valid log of another axis."""

TOLERANCE = 0.05
DEVIATIONS = 6.0
"""A parameter is right within 5 % of the truth, or within 6 printed deviations."""


@dataclass(frozen=True, order=True)
class Damage:
    """A damaged log, as it can be made again."""

    kind: str  # one of `KINDS`
    form: str  # csv, parquet or mat, where the kind does not say it
    blocks: bool  # whether the log is read in blocks
    extent: float  # from 0 to 1
    seed: int  # of everything else

    @classmethod
    def parse(cls, text: str) -> Damage:
        """The damage that `str` wrote."""
        kind, form, blocks, extent, seed = text.split(":")
        return cls(kind, form, blocks == "blocks", float(extent), int(seed))

    def __str__(self) -> str:
        return f"{self.kind}:{self.form}:{'blocks' if self.blocks else 'whole'}:{self.extent!r}:{self.seed}"

    def file(self, folder: Path) -> Path:
        """Write the damaged log into a folder."""
        columns, rng = good_log(self.seed), np.random.default_rng(self.seed)
        if self.kind in OF_TEXT:
            return write(folder, OF_TEXT[self.kind](columns, rng, self.extent), "csv")
        if self.kind in OF_FRAME:
            out = io.BytesIO()
            OF_FRAME[self.kind](columns, rng, self.extent).write_parquet(out)
            return write(folder, out.getvalue(), "parquet")
        if self.kind in OF_COLUMNS:
            columns = OF_COLUMNS[self.kind](columns, rng, self.extent)
        content, suffix = as_bytes(columns, self.form), self.form
        if self.kind in OF_BYTES:
            content = OF_BYTES[self.kind](content, rng, self.extent)
        if self.kind == "wrong_suffix":
            suffix = str(rng.choice([*(form for form in FORMS if form != self.form), "txt", "CSV.gz", ""]))
        return write(folder, content, suffix)


damages = st.builds(
    Damage,
    kind=st.sampled_from(KINDS),
    form=st.sampled_from(FORMS),
    blocks=st.booleans(),
    extent=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32 - 1),
)


def outcome_of(damage: Damage) -> Outcome:
    """Write the log, identify it in this process, and judge the result.

    Verdicts are those of `Outcome`, "ok" with right parameters, and "untold": wrong parameters that nothing in the log
    contradicts.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = damage.file(Path(folder))
        blocks = ["--memory", "1kB"] if damage.blocks else []
        ended = run_command(["identify", AXIS, str(file), "--json", "-", *blocks])
    return ended if isinstance(ended, Outcome) else _judged(damage, ended.code, ended.out, ended.err)


def _judged(damage: Damage, code: object, out: str, err: str) -> Outcome:
    if code == 2:
        lines = err.splitlines()
        fine = len(lines) == 1 and lines[0].startswith("symid: ") and not out
        return Outcome("refused" if fine else "several lines", err)
    if code != 0:
        return Outcome("traceback", f"exit code {code}: {err}")
    record = json.loads(out)
    if record["status"] != "ok":
        return Outcome(record["status"], record["message"])
    off = {
        name: record["physical"][name]
        for name, true in TRUTH.items()
        if not _right(record["physical"][name], true)
    }
    said = ", ".join(f"{name} {p['value']} ({p['deviation']})" for name, p in off.items())
    if not off:
        return Outcome("ok", "")
    residual = ", ".join(f"{r['relative']:.3g}" for r in record["residual"].values())
    return Outcome(
        "untold" if damage.kind in UNTOLD else "wrong", f"{said}; residual {residual}; {record['notes']}"
    )


def _right(parameter: dict[str, float | None], true: float) -> bool:
    value, deviation = parameter["value"], parameter["deviation"]
    return value is not None and abs(value - true) <= max(TOLERANCE * true, DEVIATIONS * (deviation or 0.0))
