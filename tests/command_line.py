"""The command line as tests call it."""

import re

import pytest

from symid.cli import main


def run(*arguments: str) -> int:
    """Exit code of a command."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


def follows(said: str, printed: str) -> bool:
    """Whether a text is what a page prints, lines wrapped anew and ``...`` for anything."""
    parts = [
        r"\s+".join(map(re.escape, part.split()))
        for part in re.split(r"^\.\.\.$", printed, flags=re.MULTILINE)
    ]
    return re.fullmatch(r"\s*" + r"[\s\S]*".join(parts) + r"\s*", said.strip()) is not None
