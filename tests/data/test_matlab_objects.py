"""Objects of MATLAB in files of versions 7 and 7.3: time series, datasets of Simulink, timetables."""

import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import scipy.io

from symid.data import read_log
from symid.data.formats import array_files
from symid.errors import LogError
from tests.log_formats import EXPECTED, PERIOD, F, N, Q, T

with warnings.catch_warnings():  # it sets an option of pandas that is deprecated
    warnings.simplefilter("ignore")
    save_to_mat = import_module("matio").save_to_mat
    MatlabOpaque = import_module("matio.utils.matclass").MatlabOpaque

NONE = np.zeros((0, 0))


@pytest.fixture(autouse=True)
def _in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """No file here is damaged; that a file is parsed in a separate process is shown by test_formats.py."""
    monkeypatch.setattr(array_files, "_channels_apart", array_files._parsed)


def series(values: Any, name: str = "unnamed", unit: str = "", units: str = "seconds", **times: Any) -> Any:
    """A time series as MATLAB stores it: times in a vector, or by start, increment and length."""
    info = {"Units": units, "Start_": NONE, "Increment_": NONE, "Length": float(N), **times}
    return MatlabOpaque(
        {
            "Name": name,
            "Data_": values,
            "Time_": NONE if times else T[:, None],
            "TimeInfo": MatlabOpaque(info, "tsdata.timemetadata"),
            "DataInfo": MatlabOpaque({"Units": unit}, "tsdata.datametadata"),
        },
        "timeseries",
    )


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_time_series_are_columns_with_their_times(version: str, tmp_path: Path) -> None:
    # milliseconds; along the last axis, as Simulink logs; times by start and increment; one number beside them
    mm = series(1e3 * Q[:, None], unit="mm")
    force = series(F.reshape(1, 1, -1), units="milliseconds", Start_=0.0, Increment_=1e3 * PERIOD)
    variables = {"q": mm, "F": force, "gain": np.array([[3.0]])}
    save_to_mat(str(tmp_path / "a.mat"), variables, version=version)
    log = read_log(tmp_path / "a.mat", expected=EXPECTED)
    assert log.sampling_period == pytest.approx(PERIOD)
    np.testing.assert_allclose(log["q"], Q, rtol=1e-12)
    np.testing.assert_array_equal(log["F"], F)


def test_a_dataset_of_simulink_names_its_signals(tmp_path: Path) -> None:
    signals = np.empty((2, 1), dtype=object)
    for i, (name, values) in enumerate((("q", Q), ("F", F))):
        signal = {"Name": name, "Values": series(values[:, None], name=""), "PortIndex": 1.0}
        signals[i, 0] = MatlabOpaque(signal, "Simulink.SimulationData.Signal")
    storage = MatlabOpaque({"Elements_": signals}, "Simulink.SimulationData.Storage.RamDatasetStorage")
    dataset = MatlabOpaque({"Name": "logsout", "Storage_": storage}, "Simulink.SimulationData.Dataset")
    save_to_mat(str(tmp_path / "a.mat"), {"logsout": dataset}, version="v7")
    log = read_log(tmp_path / "a.mat", expected=EXPECTED)
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


@pytest.mark.filterwarnings("ignore:duration_to_mat")
def test_a_timetable_has_the_times_of_its_rows(tmp_path: Path) -> None:
    frame = pd.DataFrame({"q": Q, "F": F}, index=pd.to_timedelta(T + 5.0, unit="s"))
    save_to_mat(str(tmp_path / "a.mat"), {"run": frame}, version="v7")
    log = read_log(tmp_path / "a.mat", expected=EXPECTED)
    np.testing.assert_array_equal(log["F"], F)
    assert log.sampling_period == pytest.approx(PERIOD)


def test_objects_that_hold_no_numbers_are_reported(tmp_path: Path) -> None:
    save_to_mat(str(tmp_path / "a.mat"), {"a": MatlabOpaque({"x": "text"}, "other")}, version="v7")
    with pytest.raises(LogError, match="save the Time and Data of a timeseries as vectors"):
        read_log(tmp_path / "a.mat", expected=EXPECTED)


def test_vectors_beside_objects_that_cannot_be_read_are_read(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"t": T, "q": Q, "F": F})
    data = bytearray((tmp_path / "a.mat").read_bytes())
    data[116:124] = (len(data) - 64).to_bytes(8, "little")  # the data of objects, which are not there
    (tmp_path / "a.mat").write_bytes(bytes(data))
    np.testing.assert_array_equal(read_log(tmp_path / "a.mat", expected=EXPECTED)["q"], Q)


def test_a_structure_with_time_of_several_signals_in_version_7_3(tmp_path: Path) -> None:
    # an array of structs is stored by references
    signals = np.empty((1, 2), dtype=[("values", object), ("label", object)])
    for place, (label, values) in enumerate((("q", Q), ("F", F))):
        signals[0, place] = (values[:, None], label)
    save_to_mat(str(tmp_path / "a.mat"), {"out": {"t": T[:, None], "signals": signals}}, version="v7.3")
    log = read_log(tmp_path / "a.mat", expected=EXPECTED)
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


BY_MATLAB = Path(scipy.__file__).parent / "io/matlab/tests/data"
"""Files that MATLAB 4 to 8 wrote, for the tests of scipy."""


@pytest.mark.skipif(not BY_MATLAB.is_dir(), reason="this scipy is installed without its tests")
def test_files_by_matlab_are_read_or_refused_in_one_line() -> None:
    files = sorted(BY_MATLAB.glob("test*.mat"))
    assert len(files) > 80
    messages = []
    for file in files:  # in this process: none of them is damaged
        try:
            assert all(channel.values.size != 1 for channel in array_files._parsed(file, None))
        except LogError as error:
            messages.append(str(error))
    assert all(message.startswith(str(BY_MATLAB)) and "\n" not in message for message in messages)


@pytest.mark.skipif(not BY_MATLAB.is_dir(), reason="this scipy is installed without its tests")
def test_a_handle_of_a_function_is_no_signal() -> None:
    assert not array_files._parsed(next(BY_MATLAB.glob("testfunc*.mat")), None)
