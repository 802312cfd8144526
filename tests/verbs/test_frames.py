"""Data frames as logs: units, clocks, what holds no numbers."""

import datetime as dt

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import symid
from symid.errors import LogError

N = 400
T = np.arange(N) / 200
COLUMNS = {"t": T, "q [mm]": 1e3 * np.sin(9 * T), "F [kN]": np.cos(9 * T)}
FRAMES = {"dict": dict, "pandas": pd.DataFrame, "polars": pl.DataFrame, "pyarrow": pa.table}


@pytest.mark.parametrize("kind", FRAMES)
def test_frames_of_all_kinds_are_logs(kind: str) -> None:
    frame = FRAMES[kind](COLUMNS)
    for log in (symid.Log.from_frame(frame), symid.read_axis_log("rigid_1m", frame)):
        assert (log.n_samples, log.source) == (N, "frame")
        assert log.sampling_period == pytest.approx(0.005)
        assert log["q"] == pytest.approx(np.sin(9 * T))
        assert log["F"] == pytest.approx(1e3 * np.cos(9 * T))


def test_a_frame_and_a_log_are_the_same_there_and_back() -> None:
    log = symid.Log.from_frame(COLUMNS)
    again = symid.Log.from_frame(log.to_frame())
    assert again.to_frame().equals(log.to_frame())
    assert log.to_frame().columns == ["t", "q", "F"]


def test_moments_durations_and_an_index_are_clocks() -> None:
    moments = [dt.datetime(2026, 11, 21) + dt.timedelta(milliseconds=5 * i) for i in range(N)]
    frame = pd.DataFrame({"q": np.sin(T)}, index=pd.Index(moments, name="t"))
    assert symid.Log.from_frame(frame).sampling_period == pytest.approx(0.005)
    lengths = pl.DataFrame({"t": [moment - moments[0] for moment in moments], "q": np.sin(T)})
    assert symid.Log.from_frame(lengths).sampling_period == pytest.approx(0.005)


def test_an_index_of_moments_is_the_clock_whatever_its_name() -> None:
    moments = pd.Timestamp("2026-11-21") + pd.to_timedelta(1e3 * T, unit="ms")
    for index in (moments, pd.Index(moments, name="when"), pd.to_timedelta(T, unit="s")):
        log = symid.Log.from_frame(pd.DataFrame({"q": np.sin(T)}, index=index))
        assert (list(log.signals), log.sampling_period) == (["q"], pytest.approx(0.005))


def test_an_index_with_a_name_is_a_column() -> None:
    frame = pd.DataFrame({"q": np.sin(T)}, index=pd.Index(1e3 * T, name="t [ms]"))
    assert symid.Log.from_frame(frame).sampling_period == pytest.approx(T[1])
    frame.index = pd.Index(T, name="timestamps")
    log = symid.Log.from_frame(frame, columns={"t": "timestamps"})
    assert list(log.signals) == ["q"]


def test_a_lazy_frame_is_collected() -> None:
    log = symid.Log.from_frame(pl.DataFrame(COLUMNS).lazy())
    assert log.to_frame().equals(symid.Log.from_frame(COLUMNS).to_frame())


@pytest.mark.parametrize(("scale", "unit"), [(1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_times_without_a_unit_are_never_taken_for_seconds(scale: float, unit: str) -> None:
    frame = {**COLUMNS, "t": scale * T}
    for read in (
        symid.Log.from_frame,
        lambda frame, **given: symid.read_axis_log("rigid_1m", frame, **given),
    ):
        with pytest.raises(LogError, match=f"may be 5\\S* {unit}: write t"):
            read(frame)
        assert read(frame, units={"t": unit}).sampling_period == pytest.approx(0.005)
        assert read(frame, units={"t": "s"}).sampling_period == pytest.approx(0.005 * scale)


def test_texts_are_left_out_with_a_note() -> None:
    log = symid.Log.from_frame({**COLUMNS, "mode": ["auto"] * N})
    assert list(log.signals) == ["q", "F"]
    assert "column 'mode' holds" in log.notes[0]


def test_columns_units_and_gains_are_as_for_files() -> None:
    frame = {"Zeit": 1e3 * T, "Lage": 1e3 * np.sin(9 * T), "Strom": np.cos(9 * T)}
    mapped = {
        "columns": {"t": "Zeit", "q": "Lage", "F": "Strom"},
        "units": {"t": "ms", "q": "mm"},
        "gains": {"F": 85.0},
    }
    for log in (symid.Log.from_frame(frame, **mapped), symid.read_axis_log("rigid_1m", frame, **mapped)):
        assert log["q"] == pytest.approx(np.sin(9 * T))
        assert log["F"] == pytest.approx(85 * np.cos(9 * T))


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        ({"q": T}, "no column 't'"),
        ({"t": T**2, "q": T}, "jitters|uniform"),
        ({"t": T, "q": T[:-1]}, "differ in length"),
        ({"t": T, "q": np.where(T > 1, np.nan, T)}, "not finite"),
        ({"t": T, "w [1/min]": T}, "depends on what is measured"),
        ({"t": T, "a [g]": T}, "depends on what is measured"),
        ({"t": T, "q [count]": T}, "has no known size"),
        ({"t": T, "q [mm]": T, "q": T}, "two columns are named 'q'"),
        ({"t": T, "q": np.ones((N, 2))}, "no signals"),
        (5, "int is not a log"),
        ([1, 2], "list is not a log"),
        ("run.csv", "str is not a log"),
        ({"t": T, "q": 3.0}, "differ in length"),
        (pd.DataFrame(np.array([T, T, T]).T, columns=["t", "q", "q"]), "several columns are named q"),
        (pd.DataFrame({0: T, 1: T}), "no column 't'"),
    ],
)
def test_what_is_no_log_is_refused(frame: object, says: str) -> None:
    with pytest.raises(LogError, match=says):
        symid.Log.from_frame(frame)


def test_columns_without_names_are_mapped_by_their_numbers() -> None:
    frame = pd.DataFrame(np.array([T, np.sin(9 * T)]).T)
    assert symid.Log.from_frame(frame, columns={"t": "0", "q": "1"})["q"] == pytest.approx(np.sin(9 * T))


def test_a_period_takes_the_place_of_a_clock() -> None:
    assert symid.Log.from_frame({"q": T}, sampling_period=0.1).time[1] == 0.1
    with pytest.raises(LogError, match="omit the sampling period"):
        symid.Log.from_frame(COLUMNS, sampling_period=0.1)


def test_columns_of_two_sensors_serve_one() -> None:
    """The mapping of an axis names all its sensors, `measured` those that are read."""
    mass = symid.Body("mass", mass="M")
    axis = symid.Axis(
        "two", (mass,), symid.Drive("F", mass), (symid.Position("q", mass), symid.Velocity("v", mass))
    )
    frame = {"time": T, "way": 1e3 * np.sin(9 * T), "speed": 9 * np.cos(9 * T), "force": np.cos(9 * T)}
    columns = {"t": "time", "q": "way", "v": "speed", "F": "force"}
    foreign = {"columns": columns, "units": {"q": "mm"}, "gains": {"q": 2.0}}
    both = symid.read_axis_log(axis, frame, **foreign)
    one = symid.read_axis_log(axis, frame, measured=("v",), **foreign)
    assert both["q"] == pytest.approx(2 * np.sin(9 * T))
    assert set(one.signals) == {"v", "F"}
    with pytest.raises(LogError, match="'x' is not known"):
        symid.read_axis_log(axis, frame, measured=("v",), columns=columns | {"x": "way"})
