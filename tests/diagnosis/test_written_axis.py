"""The axis that a diagnosis writes is derived from its declaration; it leaves no more than the diagnosis left."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run
from hand_made import rigid_log

from symid import Log, load_axis
from symid.axis import Between, Body, Spring
from symid.diagnosis import diagnose, explained_axis
from symid.errors import SettingError
from symid.simulation import chirp, plant_of, simulate, tuned_cascade


def swinging() -> Log:
    """The motor with 30 kg of its mass on a spring of 12 Hz."""
    axis = load_axis("rigid_1m").with_signal("F", noise=2.0).with_signal("q", noise=2e-8)
    hung = Body("hung", mass="m")
    axis = axis.with_effect(
        hung, Spring("tower", Between(first=axis.bodies[0], second=hung), stiffness="k", damping="c")
    )
    w = 2 * np.pi * 12
    parameters = {"M": 70.0, "Fv": 150.0, "Fs": 8.0, "m": 30.0, "k": 30 * w**2, "c": 2 * 0.05 * w * 30}
    reference = chirp(1.0, 25.0, 6.0, 2.0, quantity="acceleration", sampling_period=1 / 2000)
    return simulate(
        axis, parameters, reference, tuned_cascade(plant_of(axis, parameters), "q", 10.0), seed=1
    ).log


LOGS = {
    "quadratic_drag": lambda: rigid_log(lambda t, q, v, a, path: 300 * v * np.abs(v)),
    "stribeck_friction": lambda: rigid_log(
        lambda t, q, v, a, path: 25 * np.sign(v) * np.exp(-((v / 0.02) ** 2))
    ),
    "cogging": lambda: rigid_log(lambda t, q, v, a, path: 12 * np.sin(2 * np.pi * q / 0.024)),
    "flexible_mode": swinging,
}


@pytest.mark.parametrize("effect", LOGS)
def test_what_is_written_explains_the_log(effect: str) -> None:
    log = LOGS[effect]()
    late = {"F": -0.5 / 2000} if effect == "flexible_mode" else {}  # the simulation holds its force
    found = diagnose(load_axis("rigid_1m"), log, late=late)
    assert found.effects[0].effect == effect
    explained = explained_axis(found)
    assert set(explained.values) == set(explained.axis.physical_parameters)
    assert explained.left_out == ()
    again = diagnose(explained.axis, log, nominal=explained.values, late=late)
    assert again.gap.nominal is not None
    before, after = found.gap.explained, again.gap.nominal
    assert after.rms / again.gap.noise_floor.rms < 1.1 * max(before.rms / found.gap.noise_floor.rms, 1.0)


def test_a_delay_is_no_element_and_says_how_to_identify_with_it() -> None:
    log = rigid_log()
    late = Log(log.source, 0.0, log.sampling_period, {"F": log["F"][4:], "q": log["q"][:-4]})
    found = diagnose(load_axis("rigid_1m"), late)
    assert found.effects[0].effect in ("delay", "actuator_lag")
    with pytest.raises(SettingError, match=r"--late F=-20\d\dus"):
        explained_axis(found)


def test_the_file_is_an_axis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    log = LOGS["quadratic_drag"]()
    pl.DataFrame({"t": log.time, "q": log["q"], "F": log["F"]}).write_csv("run.csv")
    assert run("diagnose", "rigid_1m", "run.csv", "--write-axis", "drag.py") == 0
    values = json.loads(Path("drag.json").read_text())
    assert values["motor_c"] == pytest.approx(300, rel=0.05)
    assert set(load_axis("drag.py").physical_parameters) == set(values)
    assert run("generate", "drag.py", "--measured", "q") == 0
    capsys.readouterr()
    assert run("identify", "drag.py", "run.csv", "--json", "-") == 0
    identified = json.loads(capsys.readouterr().out)["physical"]
    assert identified["motor_c"]["value"] == pytest.approx(300, rel=0.05)
