"""A payload known in each of two logs tells the constant of the drive, beside hand calculations and the truth."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Log,
    Position,
    Spring,
    ViscousFriction,
    Weight,
    derive,
    identify,
    load_axis,
    write_axis,
)
from symid.codegen.generated_models import compiled
from symid.data import write_log
from symid.errors import DeclarationError, SettingError
from symid.identification import IdentificationResult, identify_with_known
from symid.identification.parameters.physical import open_by_structure
from symid.simulation import Cascade, plant_of, simulate, trapezoids

TABLE = Body("table", mass="M")
LOAD = Body("load", mass="Ml", geared=Geared(to=TABLE, ratio=1.0))
AXIS = Axis(
    "current",
    (TABLE, LOAD, ViscousFriction(TABLE, "Fv"), CoulombFriction(TABLE, "Fs")),
    Drive("iq", TABLE, gain="Kt", unit="A", held=True, noise=0.02),
    (Position("q", TABLE, noise=1e-7),),
)
TRUE = {"M": 40.0, "Fv": 120.0, "Fs": 30.0, "Kt": 55.0}
PATH = trapezoids([0.3, 0.1] * 3, 0.4, acceleration=4.0, jerk=80.0, dwell=0.1, sampling_period=1e-3)


def log_with(payload: float, seed: int, axis: Axis = AXIS, true: dict[str, float] = TRUE) -> Log:
    """A run with a payload."""
    loop = Cascade(axis.controlled, position_gain=20.0, velocity_gain=100.0, integral_gain=10.0)
    values = true | {"Ml": payload}
    return replace(simulate(axis, values, PATH, loop, seed=seed).log, source=f"with {payload:g} kg")


def test_two_payloads_tell_the_constant_of_the_drive() -> None:
    found = identify_with_known(
        AXIS, [log_with(0.0, 1), log_with(12.5, 2)], [{"Ml": 0.0}, {"Ml": 12.5}], ("q",)
    )
    assert found.status == "ok", found.message
    deviations = dict(zip(found.physical_units, found.standard_deviations, strict=True))
    for name, true in TRUE.items():
        assert abs(found.physical_parameters[name] - true) < 3.5 * deviations[name], name
        assert deviations[name] < 0.01 * true
    # by hand: both masses over Kt are minimal parameters, so that Kt is the payload over their difference
    empty, loaded = (group.minimal_parameters["X3"] for group in found.groups)
    assert found.physical_parameters["Kt"] == pytest.approx(12.5 / (loaded - empty), rel=5e-3)
    assert found.physical_parameters["M"] == pytest.approx(12.5 * empty / (loaded - empty), rel=5e-3)


def test_bounds_and_priors_of_shared_parameters_are_noted_with_their_cost() -> None:
    runs, known = [log_with(0.0, 1), log_with(12.5, 2)], {"Ml": [0.0, 12.5]}
    free = identify(AXIS, runs, known=known)
    mass, deviation = free.values[0], free.standard_deviations[0]
    bound = mass - 0.7 * deviation
    held = identify(AXIS, runs, known=known, bounds={"M": (None, bound)})
    assert held.status == "ok"
    assert held.physical_parameters["M"] == pytest.approx(bound, rel=1e-9)
    assert held.notes[0].startswith(f"M is held at its bound {bound:g} kg: that costs 0.49")
    assert "in chi-square (0.7 deviations)" in held.notes[0]
    doubted = identify(AXIS, runs, known=known, prior={"Kt": (70.0, 1.0)})
    away = (70.0 - free.physical_parameters["Kt"]) / np.hypot(1.0, free.standard_deviations[-1])
    assert f"the prior of Kt, 70 +- 1 N/A, is {away:.2g} deviations from the" in doubted.notes[0]


def test_the_verb_takes_one_value_for_each_log() -> None:
    logs = [log_with(0.0, 1), log_with(12.5, 2)]
    found = identify(AXIS, logs, known={"Ml": (0.0, 12.5)}, fixed={"Fv": 120.0}, examine=False)
    assert list(found.physical_parameters) == ["M", "Fs", "Kt"]
    assert found.status == "ok", found.message
    assert found.physical_parameters["Kt"] == pytest.approx(55.0, rel=5e-3)
    assert "Ml = 12.5: with 12.5 kg" in found.summary()
    assert isinstance(found, IdentificationResult)
    assert found.predict(logs[1]).residuals[0].relative < 0.02
    heavier = log_with(30.0, 3)  # a payload of none of the logs
    assert found.predict(heavier, {"Ml": 30.0}).residuals[0].relative < 0.02
    assert found.predict(heavier, {"Ml": 12.5}).residuals[0].relative > 0.1
    with pytest.raises(SettingError, match="with 30 kg has no known Ml"):
        found.predict(heavier)
    for wrong in ({"Ml": 12.5}, {"Ml": (0.0,)}):
        with pytest.raises(SettingError, match="a list of one value for each log"):
            identify(AXIS, logs, known=wrong)
    with pytest.raises(SettingError, match="take wls without ddof"):
        identify(AXIS, logs, known={"Ml": (0.0, 12.5)}, ddof=3)


def gantry_log(payload: float, seed: int) -> Log:
    """A gantry of two motors with constants of their own, 50 and 62 N/A, whose currents balance a motion, by hand."""
    t, motions = np.arange(3000) * 1e-3, []
    for sines in (((0.03, 0.6), (3e-3, 3.1)), ((0.03, 0.6), (3e-3, 3.1), (2e-4, 7.3))):
        w = [(a, 2 * np.pi * f) for a, f in sines]
        motions.append([sum(a * o**k * np.sin(o * t + k * np.pi / 2) for a, o in w) for k in range(3)])
    (q1, v1, a1), (q2, v2, a2) = motions
    beam = 3e5 * (q2 - q1) + 200.0 * (v2 - v1)
    i1 = ((40.0 + payload) * a1 + 60.0 * v1 - beam) / 50.0
    i2 = ((40.0 + payload) * a2 + 60.0 * v2 + beam) / 62.0
    rng = np.random.default_rng(seed)
    noisy = {"q1": q1, "q2": q2} | {
        "i1": i1 + rng.normal(0, 0.02, t.size),
        "i2": i2 + rng.normal(0, 0.02, t.size),
    }
    return Log.from_arrays(noisy, sampling_period=1e-3)


def test_known_payloads_tell_the_constants_of_two_drives_whose_log_alone_says_none() -> None:
    left, right = Body("left", mass="M"), Body("right", mass="M")
    beam = Spring("beam", Between(first=left, second=right), stiffness="K", damping="D")
    loads = [Body(f"on_{body.name}", mass="Ml", geared=Geared(to=body, ratio=1.0)) for body in (left, right)]
    frictions = ViscousFriction(left, "Fv"), ViscousFriction(right, "Fv")
    drives = Drive("i1", left, gain="c1", unit="A"), Drive("i2", right, gain="c2", unit="A")
    axis = Axis(
        "gantry",
        (left, right, *loads, beam, *frictions),
        drives,
        (Position("q1", left), Position("q2", right)),
    )
    logs = [gantry_log(payload, seed) for payload, seed in ((0.0, 1), (12.5, 2))]
    alone = identify(axis.with_known({"Ml": 0.0}), logs[0], measured=("q1", "q2"))
    assert alone.status in ("undetermined", "no_physical_parameters")  # as rounding has it
    assert (
        "do not determine M, K, D, Fv, c1, c2, however the axis moves: give one with `fixed`" in alone.message
    )
    found = identify(axis, logs, measured=("q1", "q2"), known={"Ml": (0.0, 12.5)}, examine=False)
    assert found.status == "ok", found.message
    true = {"M": 40.0, "K": 3e5, "Fv": 60.0, "c1": 50.0, "c2": 62.0}
    assert {name: found.physical_parameters[name] for name in true} == pytest.approx(true, rel=0.02)


def test_deviations_are_those_of_repetitions() -> None:
    found = [
        identify_with_known(
            AXIS, [log_with(0.0, 2 * k), log_with(12.5, 2 * k + 1)], [{"Ml": 0.0}, {"Ml": 12.5}], ("q",)
        )
        for k in range(12)
    ]
    scatter = np.std([one.physical_parameters["Kt"] for one in found], ddof=1)
    stated = np.mean([one.standard_deviations[list(one.physical_units).index("Kt")] for one in found])
    assert 0.55 < stated / scatter < 1.8  # 12 runs tell a deviation to 21 %


def log_by_hand(payload: float, seed: int, *, late: float = 0.5e-3, asymmetry: float = 0.0) -> Log:
    """A motion of three sines, and the current at a later time; by default held over the sampling period.

    Viscous friction differs by a share between the directions.
    """
    rng, t = np.random.default_rng(seed), np.arange(3000) * 1e-3
    phases, rates = rng.uniform(0.0, 2 * np.pi, 3), 2 * np.pi * np.array([0.7, 1.6, 4.1])
    sizes = np.array([0.08, 0.03, 0.006])
    q, v, a = (
        np.sin(np.outer(t + tau, rates) + phases + k * np.pi / 2) @ (sizes * rates**k)
        for k, tau in ((0, 0.0), (1, late), (2, late))
    )
    friction = TRUE["Fv"] * (1.0 + np.sign(v) * asymmetry / 2) * v + TRUE["Fs"] * np.sign(v)
    current = ((TRUE["M"] + payload) * a + friction) / TRUE["Kt"]
    signals = {"q": q + rng.normal(0.0, 1e-7, t.size), "iq": current + rng.normal(0.0, 0.02, t.size)}
    return replace(Log.from_arrays(signals, sampling_period=1e-3), source=f"with {payload:g} kg")


PAYLOADS = (0.0, 8.0, 15.0, 25.0)


def test_deviations_hold_what_the_model_lacks_alike_in_all_logs() -> None:
    plain, widened = [], []
    for draw in range(4):
        logs = [log_by_hand(m, 10 * draw + i, asymmetry=0.05) for i, m in enumerate(PAYLOADS)]
        for errors, examine in ((plain, False), (widened, True)):
            found = identify(AXIS, logs, known={"Ml": PAYLOADS}, examine=examine)
            errors.append((found.values - list(TRUE.values())) / found.standard_deviations)
        assert found.status == "ok", found.message  # and no contradiction between the groups
        assert np.allclose(np.sqrt(np.diag(found.covariance)), found.standard_deviations)
    assert np.max(np.abs(plain)) > 2.5
    assert np.max(np.abs(widened)) < 2.0


def test_a_damaged_group_is_named_though_it_alone_determines_no_physical_parameters() -> None:
    sound = [log_by_hand(m, i) for i, m in enumerate(PAYLOADS)]
    late = log_by_hand(PAYLOADS[2], 2, late=2.5e-3)
    clipped = replace(sound[2], signals={**sound[2].signals, "iq": np.clip(sound[2]["iq"], -4.0, 4.0)})
    for log, fault in ((late, "timing"), (clipped, "poor_fit")):
        found = identify(AXIS, [*sound[:2], log, sound[3]], known={"Ml": PAYLOADS})
        assert found.groups[2].status == "no_physical_parameters"
        assert found.status == fault
        assert found.message.startswith("with 15 kg: ")


def test_one_payload_does_not_tell_and_a_fixed_mass_does() -> None:
    logs = [log_with(12.5, 1), log_with(12.5, 2)]
    found = identify_with_known(AXIS, logs, [{"Ml": 12.5}, {"Ml": 12.5}], ("q",))
    assert found.status == "no_physical_parameters"
    assert "Kt" in found.message
    assert np.isnan(found.values).all()
    weighed = identify_with_known(AXIS.with_known({"M": 40.0}), logs, [{"Ml": 12.5}, {"Ml": 12.5}], ("q",))
    assert weighed.status == "ok"
    assert weighed.physical_parameters["Kt"] == pytest.approx(55.0, rel=5e-3)


def test_three_payloads_of_which_one_is_wrong_contradict_each_other() -> None:
    logs = [log_with(payload, seed) for seed, payload in enumerate((0.0, 10.0, 20.0))]
    right = identify_with_known(AXIS, logs, [{"Ml": m} for m in (0.0, 10.0, 20.0)], ("q",))
    assert right.status == "ok", right.message
    wrong = identify_with_known(AXIS, logs, [{"Ml": m} for m in (0.0, 10.0, 15.0)], ("q",))
    assert wrong.status == "contradicted"


def test_a_ball_screw_in_current_units_is_found_without_a_start() -> None:
    screw = load_axis("ballscrew_2m1s")
    drive = Drive("iq", screw.drive.at, gain="Kt_drive", unit="A", held=True, noise=0.01)
    axis = (
        replace(screw, name="screw_in_current", drive=drive).with_signal("qm", 1e-8).with_signal("ql", 1e-8)
    )
    axis = replace(axis, drive=drive)
    true = {"Mm": 80.0, "Fvm": 120.0, "Fsm": 50.0, "Kt": 6e6, "Ft": 7000.0, "Fvl": 150.0, "Kt_drive": 80.0}
    logs = [log_with(payload, seed, axis, true) for seed, payload in enumerate((200.0, 320.0))]
    found = identify_with_known(axis, logs, [{"Ml": 200.0}, {"Ml": 320.0}], ("qm", "ql"))
    assert set(found.physical_parameters) == set(true)
    for name in ("Mm", "Kt", "Kt_drive"):
        assert found.physical_parameters[name] == pytest.approx(true[name], rel=0.05), name


def test_a_stiff_screw_with_a_payload_in_one_log_is_determined_with_its_constant() -> None:
    """Kn/(Mz + Ml) of the slide's balance tells Kn, and Kn/Kt of the motor's the constant; -g is no parameter."""
    screw, slide = Body("screw", inertia="J"), Body("slide", mass="Mz")
    load = Body("load", mass="Ml", geared=Geared(to=slide, ratio=1.0))
    nut = Spring("nut", Between(first=screw, second=slide, ratio=0.00159), stiffness="Kn")
    sensors = (Position("th", screw), Position("d", slide, relative_to=screw, ratio=0.00159))
    elements = (screw, slide, load, nut, ViscousFriction(screw, "Fv"), Weight(slide), Weight(load))
    hoist = Axis("hoist", elements, Drive("iq", screw, gain="Kt", unit="A"), sensors)
    assert any("gravity" in str(y) for y in derive(hoist, ("th", "d")).minimal.output)
    models = [compiled(derive(hoist.with_known({"Ml": payload}), ("th", "d"))) for payload in (0.0, 40.0)]
    assert "Kt" in open_by_structure(models[0])
    assert open_by_structure(*models) == ()


def test_the_constant_is_in_equations_and_simulation() -> None:
    assert str(AXIS.physical_parameters["Kt"]) == "N/A"
    assert str(AXIS.signal_units["iq"]) == "A"
    model = derive(AXIS, ("q",))
    assert [str(p.function.expression) for p in model.minimal.parameters] == ["Fv/Kt", "Fs/Kt", "(M + Ml)/Kt"]
    assert plant_of(AXIS, TRUE | {"Ml": 1.0}).drive.tolist() == [55.0]
    with pytest.raises(DeclarationError, match=r"give that, such as unit='A'"):
        replace(AXIS, drive=Drive("iq", TABLE, gain="Kt"))
    with pytest.raises(DeclarationError, match="leave command= out"):
        replace(AXIS, drive=Drive("iq", TABLE, gain="Kt", unit="A", command="u"))
    with pytest.raises(SettingError, match="give one set for each log"):
        identify_with_known(AXIS, [log_with(0.0, 1)], [{"Ml": 0.0}, {"Ml": 1.0}], ("q",))


def test_the_command(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_axis(AXIS, Path("current.py"), "A table with a payload.")
    for name, payload in (("empty", 0.0), ("loaded", 12.5)):
        write_log(log_with(payload, int(payload)), Path(f"{name}.csv"))
    logs = ("empty.csv", "loaded.csv")
    assert run("identify", "current.py", *logs, "--known", "Ml=0,12.5kg", "--json", "found.json") == 0
    assert "Kt" in capsys.readouterr().out
    record = json.loads(Path("found.json").read_text())
    assert record["physical"]["Kt"]["value"] == pytest.approx(55.0, rel=5e-3)
    assert [group["known"]["Ml"] for group in record["groups"]] == [0.0, 12.5]
    joint = json.loads(Path("found.json").read_text())["physical"]
    Path("loads.csv").write_text("log,Ml [g]\nempty.csv,0\nloaded.csv,12500\n")
    assert run("identify", "current.py", *logs, "--known", "loads.csv", "--json", "found.json") == 0
    assert json.loads(Path("found.json").read_text())["physical"] == joint
    Path("loads.csv").write_text("log,Ml\n" + logs[0] + ",0\n")
    assert run("identify", "current.py", *logs, "--known", "loads.csv") == 2
    assert run("identify", "current.py", *logs, "--known", "Ml=12.5kg") == 2
    assert "1 values for 2 logs" in capsys.readouterr().err
    assert run("identify", "current.py", *logs, "--known", "Ml=0,1", "--method", "iv") == 2


def test_a_known_constant_of_the_drive_makes_the_others_si() -> None:
    known = AXIS.with_known({"Kt": 55.0, "Ml": 0.0})
    found = identify(known, log_with(0.0, 1), examine=False)
    assert list(found.physical_parameters) == ["M", "Fv", "Fs"]
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < 4 * deviation + 1e-3 * TRUE[name], name
    with pytest.raises(SettingError, match="the nominal Ml is 0, where a search cannot start"):
        identify(AXIS, log_with(0.0, 1), method="oe", nominal=TRUE | {"Ml": 0.0})
