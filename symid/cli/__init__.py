"""The command line. Nothing is imported before `main` runs: an interrupt while modules load is one line, too."""

import gc
import sys

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    try:
        from symid.cli.command_line import run

        code = run(arguments)
    except KeyboardInterrupt:  # one within a command has been reported there
        print("\nsymid: interrupted", file=sys.stderr)
        code = 130
    gc.freeze()  # the end of a process would look for garbage in all that its modules made
    sys.exit(code)
