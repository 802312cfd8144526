"""The first moments of a command, and what `import symid` loads."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

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
    assert done.stdout.split() == ["symid", "symid.cli", "symid.lazy_face"]


LOADED = """
import gc

from symid.cli.command_line import run

gc.disable()  # as `main` does at the start of the program
run(["show", "--help"])
print(gc.isenabled(), gc.get_freeze_count() > 10_000)
"""


def test_what_modules_make_is_not_searched_for_garbage() -> None:
    """The search took a quarter of the start of a command."""
    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True)
    assert done.stdout.split()[-2:] == ["True", "True"]


WITHOUT = """
import sys

import symid.simulation

print("polars" in sys.modules, "sympy" in sys.modules)
"""


def test_a_simulation_loads_no_reader_of_files() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_each_kind_of_element_is_a_name_of_symid_that_loads_when_it_is_used() -> None:
    kinds = {name for part in (drive_imperfections, imperfections, laws, sensors) for name in part.__all__}
    assert kinds <= set(symid.__all__)
    assert all(getattr(symid, name) is not None for name in symid.__all__)


@pytest.mark.parametrize(
    "face", sorted(Path(symid.__file__).parent.rglob("__init__.py")), ids=lambda file: file.parent.name
)
def test_each_listed_name_of_a_package_exists(face: Path) -> None:
    place = face.parent.relative_to(Path(symid.__file__).parents[1])
    package = importlib.import_module(".".join(place.parts))
    assert [name for name in getattr(package, "__all__", ()) if not hasattr(package, name)] == []
