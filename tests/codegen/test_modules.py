"""Generated modules as files: the same everywhere, usable alone, fresh or refused."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from axes.catalogue import cases, every_set, generated

from symid.axis import load_axis
from symid.codegen import GeneratedModel, load_generated
from symid.codegen.generated_models import compile_module
from symid.codegen.generation.generate import plan
from symid.codegen.generation.module import module_text
from symid.codegen.store import module_name, planned_file, write_stale
from symid.errors import GeneratedModuleError
from symid.symbolic import derive

SHIPPED = [(name, chosen) for name, chosen in every_set() if cases()[name].shipped]
AXIS_FILE = """
from symid import Acceleration, Axis, Body, Drive, Position, ViscousFriction
body = Body("body", mass="M")
axis = Axis("mine", (body, ViscousFriction(body, "{friction}")), Drive("F", body), {sensors})
"""


def declare(folder: Path, friction: str = "Fv", sensors: str = '(Position("q", body),)') -> Path:
    (folder / "models").mkdir(exist_ok=True)
    path = folder / "models" / "mine.py"
    path.write_text(AXIS_FILE.format(friction=friction, sensors=sensors), encoding="utf-8")
    return path


def run_python(program: str, *arguments: str, seed: str = "0") -> str:
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program, *arguments],
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout


def test_committed_modules_are_what_the_models_give_now() -> None:
    files = plan()
    assert [file.path.name for file in files if not file.is_current] == []
    assert {file.path.stem for file in files} >= {module_name(name, chosen) for name, chosen in SHIPPED}


def test_text_is_the_same_for_every_hash_seed() -> None:
    program = (
        "import hashlib\n"
        "from symid.axis import load_axis\n"
        "from symid.codegen.generation.module import module_text\n"
        "from symid.symbolic import derive\n"
        "for name in ('direct_3m2s', 'ballscrew_2m1s', 'emps_asymmetric'):\n"
        "    axis = load_axis(name)\n"
        "    for chosen in axis.sensor_sets:\n"
        "        print(name, chosen, hashlib.sha256(module_text(derive(axis, chosen)).encode()).hexdigest())\n"
    )
    texts = {run_python(program, seed=seed) for seed in ("0", "4242")}
    assert len(texts) == 1
    assert texts.pop().count("\n") == 7


@pytest.mark.parametrize(("name", "chosen"), SHIPPED)
def test_text_names_no_machine_and_no_day(name: str, chosen: tuple[str, ...]) -> None:
    text = module_text(derive(load_axis(name), chosen))
    assert str(Path.home()) not in text
    assert str(Path(__file__).parents[2]) not in text
    assert re.search(r"20\d\d-\d\d|/home/|/tmp/|[A-Z]:\\", text) is None
    assert re.findall(r"^(?:import|from) .*$", text, re.MULTILINE) == ["import numpy as np"]


def test_a_module_works_alone_with_numpy_only() -> None:
    """symid, sympy and scipy are blocked; the paper's axis at Table 1 gives [16] and comes back."""
    path = Path(__file__).parents[2] / "generated" / "direct_2m1s__q2.py"
    program = (
        "import sys\n"
        "sys.modules.update(dict.fromkeys(['symid', 'sympy', 'scipy', 'flint'], None))\n"
        "import runpy\n"
        "m = runpy.run_path(sys.argv[1])\n"
        "import numpy as np\n"
        "X = m['minimal_parameters'](3899.0, 3949.17, 1e9, 362.58, 88.6, 146.0)\n"
        "print(np.allclose(X[[0, 5]], [4.26158e-6, 1.80946605e-3], rtol=1e-6))\n"
        "print(np.allclose(m['physical_parameters'](*X), [3899.0, 3949.17, 1e9, 362.58, 88.6, 146.0], rtol=1e-8))\n"
        "W = m['regressor'](*np.ones((7, 5)))\n"
        "print(W.shape, m['output'](*np.ones((7, 5))).shape, W[0, 0].tolist())\n"
    )
    assert (
        run_python(program, str(path))
        == "True\nTrue\n(1, 5, 7) (1, 5) [-1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\n"
    )


def test_identification_reads_modules_without_sympy() -> None:
    program = (
        "import sys, symid\n"
        "from symid.codegen import load_generated\n"
        "model = load_generated('direct_2m1s', ('q2', 'ddq1'))\n"
        "print(model.output_names, 'sympy' in sys.modules)\n"
    )
    assert run_python(program) == "('Fm', '-Fm_d2') False\n"


@pytest.mark.parametrize(("name", "chosen"), every_set())
@pytest.mark.parametrize("samples", [1, 7])
def test_shapes(name: str, chosen: tuple[str, ...], samples: int) -> None:
    model = generated(name, chosen)
    values = np.random.default_rng(0).normal(size=(len(model.signals), samples))
    equations, parameters = len(model.output_names), len(model.minimal_units)
    assert model.regressor(*values).shape == (equations, samples, parameters)
    assert model.output(*values).shape == (equations, samples)
    velocities = model.sliding_velocities(*values)
    assert velocities.shape[1] == samples
    assert len(model.sliding) == equations
    assert {i for rows in model.sliding for i in rows} == set(range(len(velocities)))
    assert model.minimal_parameters(**cases()[name].values).shape == (parameters,)


def test_scalars_and_integers_are_samples_too() -> None:
    model = generated("emps", ("q",))
    signals = dict.fromkeys(model.signals, 3)
    W = model.regressor(*signals.values())
    assert (W.dtype, W[0, 0].tolist()) == (np.dtype(float), [3.0, 3.0, 1.0, 1.0])
    integers = [np.array([2, -2]) for _ in model.signals]
    assert model.regressor(*integers)[0].tolist() == [[2.0, 2.0, 1.0, 1.0], [-2.0, -2.0, -1.0, 1.0]]
    assert model.output(*integers).tolist() == [[2.0, -2.0]]


def test_constant_columns_and_scalar_signals_broadcast() -> None:
    """A weight is a constant beside an acceleration, an offset a column of its own."""
    model = generated("inclined", ("q",))
    assert model.signals == ("F", "q_d1", "q_d2")
    W = model.regressor(0.0, np.array([1.0, -1.0, 2.0]), 0.0)
    gravity = 9.80665 * np.sin(np.radians(25))
    rows = [[gravity, 1.0, 1.0, 1.0], [gravity, -1.0, -1.0, 1.0], [gravity, 2.0, 1.0, 1.0]]
    assert pytest.approx(np.array(rows)) == W[0]


def test_sliding_velocities_are_those_under_a_sign() -> None:
    model = generated("friction_in_the_spring", ("d", "qm"))
    signals = {name: np.full(3, float(i + 1)) for i, name in enumerate(model.signals)}
    velocities = model.sliding_velocities(*signals.values())
    assert velocities.tolist() == [signals["d_d1"].tolist()]
    assert generated("accelerometer_only", ("ddq2",)).sliding == ((),)


def test_a_model_knows_the_highest_derivatives_it_needs() -> None:
    assert load_generated("direct_3m2s", ("q2",)).highest_derivatives == {"Fm": 4, "q2": 6}


def test_a_missing_module_is_refused_with_the_command_that_makes_it(folder: Path) -> None:
    declare(folder)
    with pytest.raises(GeneratedModuleError) as refused:
        load_generated("mine")
    assert (
        str(refused.value) == "there is no generated module mine__q.py; run: symid generate mine --measured q"
    )


def current(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder whose axis `mine` has its module."""
    declare(tmp_path)
    monkeypatch.chdir(tmp_path)
    write_stale(plan(("mine",)))
    assert load_generated("mine").output_names == ("F",)
    return tmp_path / "generated" / "mine__q.py"


def test_a_stale_module_is_refused_until_it_is_generated_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    current(tmp_path, monkeypatch)
    declare(tmp_path, friction="Fviscous")
    with pytest.raises(
        GeneratedModuleError, match=r"is older than the declaration of 'mine'; run: symid generate mine"
    ):
        load_generated("mine")
    write_stale(plan(("mine",)))
    assert list(load_generated("mine").physical_units) == ["M", "Fviscous"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[: len(text) // 2],
        lambda text: text.replace("def regressor", "def refressor"),
        lambda text: text.replace("FORMAT = ", "FORMAT = 9"),
        lambda text: text.replace('SIGNATURE = "', 'SIGNATURE = "0'),
        lambda text: text.replace("MINIMAL_UNITS", "MINIMAL"),
        lambda _: "",
        lambda _: "raise SystemError('no')",
    ],
)
def test_a_damaged_module_is_refused_in_one_line_with_its_cure(
    damage: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = current(tmp_path, monkeypatch)
    path.write_text(damage(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(GeneratedModuleError) as refused:
        load_generated("mine")
    assert "run: symid generate mine --measured q" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_module_that_is_not_text_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = current(tmp_path, monkeypatch)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(GeneratedModuleError, match="run: symid generate mine"):
        load_generated("mine")
    write_stale(plan(("mine",)))
    assert load_generated("mine").output_names == ("F",)


def test_a_failure_while_writing_leaves_the_old_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = current(tmp_path, monkeypatch)
    before = path.read_text(encoding="utf-8")
    declare(tmp_path, friction="Fviscous")
    files = plan(("mine",))

    def full(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="no space left"):
        write_stale(files)
    assert path.read_text(encoding="utf-8") == before
    assert sorted(path.parent.iterdir()) == [path.parent / "mine__dynamics.json", path]


def test_what_fails_in_deriving_one_axis_writes_nothing(folder: Path) -> None:
    declare(folder)
    (folder / "models" / "zzz.py").write_text("axis = 1", encoding="utf-8")
    with pytest.raises(Exception, match=r"zzz\.py defines no axis"):
        write_stale(plan(("mine", "zzz")))
    assert not (folder / "generated").exists()


def test_modules_that_nothing_declares_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of sensors that the axis has lost, and those of axes that are gone; not those of other axes."""
    declare(tmp_path, sensors='(Position("q", body), Acceleration("ddq", body))')
    (tmp_path / "models" / "other.py").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    write_stale(plan(("mine",)))
    folder = tmp_path / "generated"
    for name in ("other__q.py", "gone__q.py", "gone__dynamics.json", "notes.py"):
        (folder / name).write_text("", encoding="utf-8")
    declare(tmp_path)
    write_stale(plan(("mine",)))
    left = {"mine__dynamics.json", "mine__q.py", "notes.py", "other__q.py"}
    assert {path.name for path in folder.iterdir()} == left


def test_one_set_of_sensors_touches_no_other_module(folder: Path) -> None:
    declare(folder, sensors='(Position("q", body), Acceleration("ddq", body))')
    write_stale(plan(("mine",), ("q", "ddq")))
    assert [path.name for path in (folder / "generated").iterdir()] == ["mine__q_ddq.py"]
    write_stale(plan(("mine",), ("q",)))
    assert {path.name for path in (folder / "generated").iterdir()} == {"mine__q.py", "mine__q_ddq.py"}


def test_a_file_that_is_current_is_not_written_again(tmp_path: Path) -> None:
    path = tmp_path / "a__q.py"
    write_stale([planned_file(path, "text\n")])
    path.chmod(0o444)
    before = path.stat().st_mtime_ns
    write_stale([planned_file(path, "text\n")])
    assert path.stat().st_mtime_ns == before
    assert planned_file(path, "other\n").diff().splitlines()[-2:] == ["-text", "+other"]


def test_an_axis_in_memory_is_read_from_a_given_folder(tmp_path: Path) -> None:
    axis = cases()["triangle"].declared
    path = tmp_path / f"{module_name(axis.name, ('qa',))}.py"
    write_stale([planned_file(path, module_text(derive(axis, ("qa",))))])
    model = load_generated(axis, ("qa",), folder=tmp_path)
    assert isinstance(model, GeneratedModel)
    assert model.axis == "triangle"


def test_units_in_a_module_cannot_be_changed() -> None:
    model = compile_module(module_text(derive(load_axis("rigid_1m"))), "rigid")
    with pytest.raises(TypeError):
        model.minimal_units["X1"] = "m"
