"""The command line: a module NAME_command for each command, loaded when it is called."""

import errno
import gc
import os
import sys
from importlib import import_module
from typing import Any

import click

from symid.cli.terminal import fail, finish_output, prepare_streams, say
from symid.errors import SymidError
from symid.text import similar

COMMANDS = {
    "demo": "Identify the shipped EMPS axis from its real log, diagnose its gap and write a report.",
    "new": "Write a commented axis file to edit.",
    "import": "Look at a foreign log: guess its columns, units and sampling, write the mapping.",
    "show": "Equations, regressor and parameter maps of an axis.",
    "generate": "Write the generated modules of axes.",
    "excite": "The reference that identifies an axis best, within limits.",
    "simulate": "A log of an axis under its controller.",
    "identify": "Parameters and their deviations from logs.",
    "batch": "Many logs, one row each: parameters, deviations, verdicts.",
    "diagnose": "Why simulation and machine differ: where, which effect, how far it shrinks.",
    "compare": "Two results side by side: which parameters differ, and by how many deviations.",
    "fleet": "Review a batch: spread between runs, changes over time, outliers.",
    "export": "An identified axis as C, MuJoCo model, URDF, FMU, Structured Text or JSON, and what is lost.",
    "tune": "Cutoff frequency and sampling period of an axis.",
}


_TRACE = "SYMID_TRACE"
"""Environment variable that shows the trace of a fault of symid itself."""


class _UnreadError(Exception):
    """The reader of the output has closed it."""


class _Commands(click.Group):
    """A group that imports a command when it is needed: `--help` and typing errors need no sympy."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = import_module(f"symid.cli.{cmd_name}_command").command
        if not gc.isenabled():  # the program starts: what its modules made is no garbage
            gc.freeze()
            gc.enable()
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            ctx.fail(f"No such command {args[0]!r}{similar(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BrokenPipeError as error:  # for which click would exit with 1
            raise _UnreadError from error


@click.group(
    cls=_Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
    invoke_without_command=True,
    no_args_is_help=False,
    subcommand_metavar="COMMAND [ARGS]...",
)
@click.version_option(package_name="symid")
@click.pass_context
def group(context: click.Context) -> None:
    """Declare a machine axis, derive its regressors, identify it from logs."""
    if context.invoked_subcommand is None:
        say(context.get_help())


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; a user's mistake is one line on standard error and code 2."""
    prepare_streams()
    try:
        if any("\0" in text for text in (arguments or ())):
            return fail("an argument holds a null byte: no name does, leave it out")
        code = _run(arguments)
        finish_output()
    except BrokenPipeError:
        return 0  # the reader has closed the output
    except OSError as error:
        return fail(_refused_by_system(error))
    return code


def _refused_by_system(error: OSError) -> str:
    """Message of an error of the operating system: file, reason and cure."""
    cures = {errno.EACCES: ": check its permissions", errno.ENOSPC: ": free some space"}
    where = f"{error.filename}: " if error.filename else ""
    return f"{where}{error.strerror or error}{cures.get(error.errno or 0, '')}"


def _run(arguments: list[str] | None) -> int:
    try:
        code = group.main(arguments, prog_name="symid", standalone_mode=False)
    except click.UsageError as error:
        hint = f" (see {error.ctx.command_path} --help)" if error.ctx else ""
        return fail(error.format_message() + hint)
    except _UnreadError:
        return 0
    except click.Abort as abort:
        if isinstance(abort.__context__, EOFError):  # click turns the end of the input into this
            print(file=sys.stderr)
            return fail(
                "the input ended before the last answer: give options in place of answers, or --no-ask"
            )
        return fail("interrupted", 130)
    except SymidError as error:
        return fail(str(error))
    except MemoryError:
        return fail("there is not enough memory: use a shorter log, or a smaller --memory")
    except OSError:
        raise
    except Exception as error:
        if os.environ.get(_TRACE):
            raise
        cause = f"{type(error).__name__}: {error}"
        return fail(f"a fault of symid, please report it ({cause}); {_TRACE}=1 shows where", 70)
    return code if isinstance(code, int) else 0
