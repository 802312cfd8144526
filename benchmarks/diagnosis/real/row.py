"""Result of one case: the answer and that of the plain script, their correctness, time and memory."""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from symid import SymidError
from symid.diagnosis import Diagnosis, FoundEffect, Level

from .case import Case
from .judge import absurdities, rightness
from .plain import Error, Plain, low_passed

Row = dict[str, Any]
_MEGABYTE = 1024.0
"""Linux gives the peak in kilobytes."""


def diagnosed(case: Case) -> tuple[Diagnosis | None, Row]:
    """The diagnosis of a case, None if it was refused, and its row of the table."""
    row, found = _without_answer(case), None
    begin = time.process_time()
    try:
        found = case.found()
    except SymidError as error:
        row |= {"verdict": "refused", "message": str(error)}
    row["cpu_s"] = time.process_time() - begin
    row["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MEGABYTE
    own = case.plain()
    row["plain_in_own_band"] = {"band_hz": case.band_hz} | script_of(own)
    return found, row | (_answer(case, found, own) if found else {})


def _answer(case: Case, found: Diagnosis, own: Plain) -> Row:
    gap = found.gap
    script = case.plain(gap.band_hz)
    return {
        "verdict": found.verdict,
        "effects": [_effect(effect) for effect in found.effects],
        "right": rightness(case, found),
        "absurd": list(absurdities(case, found, own)),
        "unit": gap.unit,
        "band_hz": gap.band_hz,
        "before": _level(gap.reidentified),
        "after": _level(gap.explained),
        "plain": script_of(script),
        "ratio": gap.explained.rms / script.after.rms,
        "ratio_in_own_band": ratio(found, own),
        "unexplained_share": getattr(gap, "unexplained_share", None),
    }


def _effect(effect: FoundEffect) -> Row:
    removes = getattr(effect, "removes", None)
    return {
        "effect": effect.effect,
        "at": effect.at,
        "probability": effect.probability,
        "removes": None if removes is None else removes.share,
        "parameters": {name: [p.value, p.std, p.unit] for name, p in effect.parameters.items()},
    }


def _level(level: Level | Error) -> Row:
    return {"rms": level.rms, "relative": level.relative}


def script_of(script: Plain) -> Row:
    """Errors and values of the plain script."""
    return {
        "before": _level(script.before),
        "after": _level(script.after),
        "removed": script.removed,
        "base": dict(script.base.values),
        "best": dict(script.best.values),
        "shape": script.best.shape,
    }


def ratio(found: Diagnosis, script: Plain) -> float:
    """Error that the diagnosis leaves over that of the script: in the script's band, on the rows that both compare."""
    seen, motion = found.signals, script.motion
    left = low_passed(seen.measured - seen.explained, float(seen.time[1] - seen.time[0]), motion.band)
    time = motion.time + motion.recording.start
    rows = seen.compared & (np.interp(seen.time, time, motion.rows) > 0.999)
    other = np.interp(seen.time, time, script.best.error(motion))
    return float(np.sqrt(np.mean(left[rows] ** 2) / np.mean(other[rows] ** 2)))


def isolated(case: Case) -> Row:
    """The row of a case from a separate process, so that memory is that of the case alone."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "row.json"
        command = [sys.executable, "-m", "benchmarks.diagnosis.real", case.name, "--row", str(file)]
        if subprocess.run(command, cwd=Path(__file__).parents[3], check=False).returncode:
            return _without_answer(case) | {"verdict": "crashed"}
        row: Row = json.loads(file.read_text())
    return row


def _without_answer(case: Case) -> Row:
    return {
        "case": case.name,
        "model": case.model,
        "published": case.published,
        "right_effects": case.right,
        "right": "no",
        "absurd": [],
        "cpu_s": float("nan"),
        "peak_mb": float("nan"),
    }
