"""Completion of commands, options and names of axes in a shell."""

import pytest
from click.shell_completion import ShellComplete

from symid.axis import axis_names
from symid.cli.command_line import group


@pytest.mark.parametrize("command", ["identify", "show", "batch", "diagnose", "export", "simulate"])
def test_names_of_axes_are_completed(command: str) -> None:
    found = ShellComplete(group, {}, "symid", "_SYMID_COMPLETE").get_completions([command], "direct_")
    assert [item.value for item in found] == [name for name in axis_names() if name.startswith("direct_")]
    assert len(found) > 1


def test_the_path_of_an_axis_is_completed_as_a_file() -> None:
    shell = ShellComplete(group, {}, "symid", "_SYMID_COMPLETE")
    (found,) = shell.get_completions(["identify"], "models/own")
    assert found.type == "file"
