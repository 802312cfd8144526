"""`symid import` of units at the end of names: read, or asked for, never taken for another."""

import json
from pathlib import Path

import pytest
from command_line import run
from recorded_run import TRUE, table

KGF, LBF, INCH = 9.80665, 4.4482216152605, 0.0254  # N, N, m


@pytest.mark.parametrize(
    ("position", "metre", "force", "newton", "asked", "answers"),
    [
        ("pos_inch", INCH, "force_lbf", LBF, (), ()),
        ("POS_MM", 1e-3, "force_kgf", KGF, (), ()),
        ("enc_cnt", 1 / 80e3, "force_N", 1.0, ("give it with --unit q=UNIT",), ("--unit", "q=80 counts/mm")),
        ("pos_ticks", 1 / 5e6, "FORCE_KN", 1e3, ("--unit q=UNIT",), ("--unit", "q=5000 counts/mm")),
        (
            "pos_in",
            INCH,
            "force_lb",
            LBF,
            ("may be inches", "give --gain F in N per unit of 'force_lb'"),
            ("--unit", "q=in", "--gain", f"{LBF}"),
        ),
    ],
)
def test_units_at_the_end_of_names_give_the_true_parameters(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str], position, metre, force, newton, asked, answers
) -> None:
    columns = {"TIME_MS": 1e3 * recorded.time, position: recorded["q"] / metre, force: recorded["F"] / newton}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    look = ("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json")
    assert run(*look) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert all(question in printed for question in asked)
    assert ("Missing" in printed) is bool(asked)
    if asked:
        assert run("identify", "rigid_1m", "a.csv", "--mapping", "m.json") == 2
        (folder / "m.json").unlink()
        assert run(*look, *answers) == 0
    identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json", "--held", "F", "--json", "o.json")
    assert run(*identify) == 0
    found = json.loads((folder / "o.json").read_text())["physical"]
    assert {name: found[name]["value"] for name in TRUE} == pytest.approx(TRUE, rel=0.02)


def test_a_long_stroke_is_no_length_of_an_axis_that_turns(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "\n".join(f"{k},{30 * (k % 7)},{31 * (k % 7)},{k % 5}" for k in range(60))
    (folder / "a.csv").write_text(
        "Time (ms),ActualPosition,CommandPosition,Current (A)\n" + rows.replace(",0", ",0.5")
    )
    assert run("new", "servo.py", "--rotary", "--bodies", "1") == 0
    printed = {}
    for axis in ((), ("--axis", "rigid_1m"), ("--axis", "servo.py")):
        assert run("import", "a.csv", *axis) == 0
        printed[axis[1:]] = " ".join(capsys.readouterr().out.split())
    assert "mm or deg (guessed)" in printed[()]
    assert "position mm (guessed)" in printed[("rigid_1m",)]
    assert " mm" not in printed[("servo.py",)]
    assert "reference is not taken: 'CommandPosition' has no unit" in printed[("servo.py",)]
