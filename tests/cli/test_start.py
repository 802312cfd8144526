"""The first moments of a command, and what `import symid` loads."""

import ast
import subprocess
import sys
from pathlib import Path

import symid
from symid.axis import drive_imperfections, imperfections, laws, sensors

INTERRUPTED = """
import sys

class Interrupt:
    def find_spec(self, name, *_):
        if name == "symid.cli.terminal":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupt())
from symid.cli import main

print(*sorted(name for name in sys.modules if name.startswith("symid")))
main(["show", "rigid_1m"])
"""


def test_an_interrupt_while_modules_load_is_one_line() -> None:
    """It was a traceback in the first 0.1 s; before `main`, next to nothing is loaded."""
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "\nsymid: interrupted\n")
    assert done.stdout.split() == ["symid", "symid.cli", "symid.errors"]


def test_names_that_are_loaded_when_used_are_those_that_types_know() -> None:
    tree = ast.parse(Path(symid.__file__).read_text(encoding="utf-8"))
    lists = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    (listed,) = map(ast.literal_eval, lists)
    of_laws = [name for part in (drive_imperfections, imperfections, laws, sensors) for name in part.__all__]
    assert sorted(symid.__all__) == sorted([*listed, *of_laws])
    modules = ("axis", "drive_imperfections", "errors", "imperfections", "laws", "sensors")
    assert all(getattr(symid, name) is not None for name in (*symid.__all__, *modules))
