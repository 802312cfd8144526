"""The command line. Nothing is imported before `main` runs: an interrupt while modules load is one line, too."""

import gc
import sys

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> None:
    """Run the command line, with given arguments or as the program, and exit with its code."""
    is_program = arguments is None
    if is_program:  # looking for garbage takes a quarter of the start, and modules make none
        gc.disable()
    try:
        from symid.cli.command_line import run

        code = run(arguments)
    except KeyboardInterrupt:  # one within a command has been reported there
        print("\nsymid: interrupted", file=sys.stderr)
        code = 130
    if is_program:  # its end would look for garbage in all that its modules made
        gc.freeze()
    sys.exit(code)
