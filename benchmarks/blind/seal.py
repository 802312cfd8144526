"""Labels closed up before a diagnosis runs and opened after it: compressed JSON with a nonce, named by its hash."""

import base64
import hashlib
import json
import secrets
import zlib
from pathlib import Path
from typing import Any

SEALED = "labels.sealed"


def close(folder: Path, labels: dict[str, Any]) -> str:
    """Write the labels so that nothing of them can be read in passing; SHA-256 of the file.

    The nonce keeps anyone from confirming a guess of the labels by its hash.
    """
    text = json.dumps({"nonce": secrets.token_hex(32), "labels": labels}, sort_keys=True)
    sealed = base64.b64encode(zlib.compress(text.encode()))
    (folder / SEALED).write_bytes(sealed)
    return fingerprint(folder)


def fingerprint(folder: Path) -> str:
    """SHA-256 of the sealed file."""
    return hashlib.sha256((folder / SEALED).read_bytes()).hexdigest()


def open_labels(folder: Path) -> dict[str, Any]:
    """The labels; only once every case has an answer."""
    cases = {path.name for path in folder.glob("case*") if path.is_dir()}
    answered = {path.stem for path in (folder / "answers").glob("case*.json")}
    if cases - answered:
        raise PermissionError(
            f"labels stay sealed: {len(cases - answered)} cases of {folder} have no answer yet; diagnose them"
        )
    return read(folder)


def read(folder: Path) -> dict[str, Any]:
    """The labels, whether or not there are answers: for sets that serve development."""
    sealed = (folder / SEALED).read_bytes()
    labels: dict[str, Any] = json.loads(zlib.decompress(base64.b64decode(sealed)))["labels"]
    return labels
