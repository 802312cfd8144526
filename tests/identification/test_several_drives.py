"""Several drives in one axis: equations and identification against a gantry written by hand (tests/axes/gantry.py)."""

from dataclasses import replace

import numpy as np
import pytest
from axes.gantry import AXIS, LEFT, RIGHT, TRUE, log, matrices

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Log,
    Position,
    ViscousFriction,
    axis_source,
    derive,
    identify,
)
from symid.codegen.generated_models import compiled
from symid.errors import DeclarationError, LogError, SettingError
from symid.identification import measured_signals, read_axis_log
from symid.identification.rows.bands import coherent_band

SETS = (("q1", "q2", "qb"), ("q1", "q2"))


def exact_signals(names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Derivatives at random times of a motion without reversal whose beam is solved for by hand."""
    M, C, K = matrices()
    t, draw = np.linspace(0.0, 1.0, 40), np.random.default_rng(3)
    s = 2j * np.pi * np.array([3.0, 7.0, 19.0])
    ends = draw.normal(size=(2, 3)) * 1e-3
    beam = (TRUE["K1"] * ends[0] + TRUE["K2"] * ends[1]) / (TRUE["Mb"] * s**2 + TRUE["K1"] + TRUE["K2"])
    amplitudes = np.vstack([ends, beam])
    speed = 1.0  # all move together at 1 m/s, and sliding never reverses
    dynamic = M[..., None] * s**2 + C[..., None] * s + K[..., None]
    forces = np.einsum("ijk,jk->ik", dynamic, amplitudes)[:2]
    levels = np.array([TRUE["Fv1"] * speed + TRUE["Fs1"], TRUE["Fv2"] * speed + TRUE["Fs2"]])
    waves = np.exp(np.outer(s, t))
    found = {}
    for name in names:
        signal, order = (*name.rsplit("_d", 1), "0")[:2]
        if signal.startswith("F"):
            i, own = int(signal[1]) - 1, forces
            rest = levels[i] if order == "0" else 0.0
        else:
            i, own = ("q1", "q2", "qb").index(signal), amplitudes
            rest = {"0": speed * t, "1": speed}.get(order, 0.0)
        found[name] = np.real((own[i] * s ** int(order)) @ waves) + rest
    return found


@pytest.mark.parametrize("measured", SETS, ids="_".join)
def test_each_sensor_has_an_equation_that_the_motion_by_hand_satisfies(measured: tuple[str, ...]) -> None:
    model = compiled(derive(AXIS, measured))
    W, y = model.sample(exact_signals(model.signals))
    assert len(y) == len(measured)
    for row, output in zip(W @ model.minimal_parameters(*TRUE.values()), y, strict=True):
        np.testing.assert_allclose(row, output, atol=1e-9 * np.abs(output).max())


def test_every_drive_leads_an_equation_where_all_bodies_are_measured() -> None:
    model = derive(AXIS, SETS[0]).minimal
    assert model.output_names[:2] == ("F1", "F2")
    assert all(p.function.is_linear for p in model.parameters)


@pytest.mark.parametrize(("measured", "within"), [(SETS[0], 0.01), (SETS[1], 0.03)])
def test_parameters_from_a_log_of_the_ode_with_noise(measured: tuple[str, ...], within: float) -> None:
    nominal = {name: 1.15 * value for name, value in TRUE.items()}
    found = identify(derive(AXIS, measured), log(), nominal=nominal)
    assert found.status == "ok"
    for name, value in found.physical_parameters.items():
        assert value == pytest.approx(TRUE[name], rel=within), name


def test_tandem_drives_of_one_body_share_its_equation() -> None:
    table = Body("table", mass="M")
    pinion = Body("pinion", inertia="J", geared=Geared(to=table, ratio=1 / 0.03))
    axis = Axis(
        "tandem",
        (table, ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs"), pinion),
        (Drive("F1", table), Drive("tau2", pinion)),
        (Position("q", table),),
    )
    assert {name: str(unit) for name, unit in axis.signal_units.items()} == {
        "F1": "N",
        "tau2": "N*m",
        "q": "m",
    }
    t = np.arange(8000) / 2000
    q, v, a = (0.1 * np.sin(4 * t), 0.4 * np.cos(4 * t), -1.6 * np.sin(4 * t))
    whole = 50.0 * a + 30.0 * v + 7.0 * np.sign(v)
    share = 0.5 + 0.3 * np.sin(9 * t)
    signals = {"q": q, "F1": share * whole, "tau2": 0.03 * (1 - share) * whole}
    found = identify(derive(axis), Log("by hand", 0.0, 1 / 2000, signals)).minimal_parameters
    assert found == pytest.approx({"X1": 50.0, "X2": 30.0, "X3": 7.0}, rel=2e-3)


def test_the_band_is_that_of_both_forces_together() -> None:
    table = Body("table", mass="M")
    axis = Axis("tandem", (table,), (Drive("F1", table), Drive("F2", table)), (Position("q", table),))
    t, draw = np.arange(40_000) / 2000, np.random.default_rng(7)
    lines = 2 * np.pi * np.arange(1.0, 60.0, 0.1)
    amplitudes = draw.normal(size=(2, lines.size)) + 1j * draw.normal(size=(2, lines.size))
    waves = np.exp(1j * np.outer(lines, t))
    forces = np.real(amplitudes @ waves)
    q = np.real((amplitudes.sum(axis=0) / (-50.0 * lines**2)) @ waves) + 1e-7 * draw.normal(size=t.size)
    log = Log("by hand", 0.0, 1 / 2000, {"q": q, "F1": forces[0], "F2": forces[1]})
    model = compiled(derive(axis))
    assert coherent_band(log, model) == pytest.approx(60.0, abs=3.0)
    assert identify(model, log).minimal_parameters["X1"] == pytest.approx(50.0, rel=5e-3)


def test_friction_is_taken_off_the_force_of_its_own_drive() -> None:
    mirrored = replace(AXIS, drive=AXIS.drives[::-1])
    for axis in (AXIS, mirrored):
        model = compiled(derive(axis, SETS[1]))
        assert model.coulomb_drives == ("F1",)  # F2 is a column beside the output F1
        found = identify(model, log())
        assert found.status == "ok"
        assert found.physical_parameters["Fs1"] == pytest.approx(TRUE["Fs1"], rel=0.02)
        assert found.physical_parameters["Fs2"] == pytest.approx(TRUE["Fs2"], rel=0.02)


def test_the_torque_constants_of_two_drives_are_unknown_but_for_their_ratio() -> None:
    table = Body("table", mass="M")
    drives = (Drive("i1", table, gain="K1", unit="A"), Drive("i2", table, gain="K2", unit="A"))
    model = derive(Axis("tandem", (table, ViscousFriction(table, "Fv")), drives, (Position("q", table),)))
    assert [str(p.function.expression) for p in model.minimal.parameters] == ["K2/K1", "Fv/K1", "M/K1"]


def test_held_forces_are_all_moved_by_half_a_sample() -> None:
    held = replace(AXIS, drive=tuple(replace(drive, held=True) for drive in AXIS.drives))
    seen = identify(derive(held, SETS[0]), log()).observations[0]
    assert seen.preparation.late == pytest.approx({"F1": -0.25e-3, "F2": -0.25e-3})


def test_a_log_lacks_the_force_of_a_drive() -> None:
    signals = {name: log()[name] for name in ("q1", "q2", "F1")}
    read = read_axis_log(AXIS, {"t": np.arange(log().n_samples) / 2000, **signals})
    with pytest.raises(LogError, match="no column for F2"):
        measured_signals(AXIS, [read])


def test_what_is_wrong_with_several_drives_is_reported() -> None:
    def faults(*drives: Drive) -> str:
        with pytest.raises(DeclarationError) as caught:
            replace(AXIS, drive=drives)
        return str(caught.value)

    assert "signal 'F1' is used more than once" in faults(Drive("F1", LEFT), Drive("F1", RIGHT))
    assert "are not all held" in faults(Drive("F1", LEFT, held=True), Drive("F2", RIGHT))
    assert "units of different quantities" in faults(
        Drive("F1", LEFT, unit="A"), Drive("F2", RIGHT, unit="N")
    )
    assert "no drive" in faults()
    with pytest.raises(SettingError, match=r"axis 'gantry' has 2 drives \(F1, F2\)"):
        _ = AXIS.only_drive


def test_an_axis_with_several_drives_is_written_and_one_of_a_tuple_is_one() -> None:
    assert 'drive=(Drive("F1", left), Drive("F2", right))' in axis_source(AXIS)
    alone = Axis("one", (LEFT,), (Drive("F", LEFT),), (Position("q", LEFT),))
    assert alone == Axis("one", (LEFT,), Drive("F", LEFT), (Position("q", LEFT),))
    assert alone.only_drive.signal == "F"
