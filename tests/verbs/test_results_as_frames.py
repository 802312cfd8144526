"""Results as data frames, and the names that a notebook completes."""

import numpy as np
import pytest

import symid

COLUMNS = ["kind", "name", "value", "std", "unit"]


@pytest.fixture(scope="module")
def log() -> symid.Log:
    t = 0.002 * np.arange(4000)
    q = 0.05 * (1 - np.cos(8.0 * t)) + 0.01 * np.sin(31.0 * t)
    v, a = np.gradient(q, 0.002), np.gradient(np.gradient(q, 0.002), 0.002)
    noise = 0.05 * np.random.default_rng(3).standard_normal(t.size)
    return symid.Log.from_arrays(
        {"q": q, "F": 12.0 * a + 30.0 * v + 3.0 * np.sign(v) + noise}, sampling_period=0.002
    )


@pytest.mark.parametrize("method", ["wls", "oe"])
def test_a_frame_holds_what_is_printed(log: symid.Log, method: str) -> None:
    found = symid.identify("rigid_1m", log, method=method)
    table = found.to_frame()
    assert table.columns == COLUMNS
    physical = table.filter(kind="physical")
    assert physical["name"].to_list() == ["M", "Fv", "Fs"]
    assert physical["value"].to_list() == list(found.physical_parameters.values())
    assert physical["std"].to_list() == found.physical_deviations.tolist()
    assert physical["unit"].to_list() == ["kg", "N*s/m", "N"]
    assert table.filter(kind="minimal")["std"].to_list() == found.standard_deviations.tolist()


def test_a_diagnosis_is_a_frame_of_parameters_and_effects(log: symid.Log) -> None:
    mass = symid.Body("motor", mass="M")
    bare = symid.Axis("bare", (mass,), symid.Drive("F", mass), (symid.Position("q", mass),))
    found = symid.diagnose(bare, log)
    table = found.to_frame()
    assert table.columns == COLUMNS
    assert table.row(0)[:2] == ("physical", "M")
    kinds = [f"{one.effect} at {one.at}" for one in found.effects for _ in one.parameters]
    assert kinds
    assert table["kind"].to_list() == ["physical", *kinds]


def test_names_that_load_late_are_listed() -> None:
    assert set(symid.__all__) <= set(dir(symid))
    assert {"identify", "diagnose", "Log", "tune"} <= set(dir(symid))
