"""The console that reports print on."""

from __future__ import annotations

import sys

from rich.console import Console

_WIDTH_OF_FILES = 160


def report_console() -> Console:
    """Console on standard output: as wide as the terminal, and 160 columns where the output goes to a file or pipe."""
    width = None if sys.stdout.isatty() else _WIDTH_OF_FILES
    return Console(highlight=False, soft_wrap=True, width=width)
