"""The files that links of a page save, against the logs and the results that they are of."""

import base64
import csv
import gzip
import io
from urllib.parse import unquote

import numpy as np
import pytest
from hand_made import rigid_log

import symid
from symid.report.figures.identification_curves import identification_curves
from symid.report.pages.plot_data import csv_address, curve_data


def rows_of(address: str) -> list[dict[str, str]]:
    kind, _, content = address.partition(",")
    if kind == "data:application/gzip;base64":
        text = gzip.decompress(base64.b64decode(content)).decode()
    else:
        assert kind == "data:text/csv;charset=utf-8"
        text = unquote(content)
    return list(csv.DictReader(io.StringIO(text)))


def test_the_file_of_a_fit_leaves_the_printed_residual() -> None:
    log, axis = rigid_log(), symid.load_axis("rigid_1m")
    found = symid.identify(axis, log)
    files = {one.file: one for one in curve_data(identification_curves(found, axis=axis, runs=[log]))}
    assert list(files) == ["output-1.csv", "response-q.csv"]
    rows = rows_of(files["output-1.csv"].address)
    residual = np.array([float(row["residual [N]"] or "nan") for row in rows])
    of_both = [float(r["measured F [N]"] or "nan") - float(r["predicted F [N]"] or "nan") for r in rows]
    np.testing.assert_allclose(residual, of_both, atol=1e-5)
    observation = found.observations[0]
    wanted = observation.y[0] - observation.W[0] @ found.fit.solution
    assert np.nanstd(residual) == pytest.approx(np.std(wanted[observation.valid[0]]), rel=1e-4)
    position = [float(row["position q [m]"]) for row in rows]
    np.testing.assert_allclose(position, np.interp(observation.time, log.time, log["q"]), atol=1e-6)
    response = rows_of(files["response-q.csv"].address)
    mass, damping = found.parameters["M"], found.parameters["Fv"]
    for row in response[:: len(response) // 5]:
        s = 2j * np.pi * float(row["frequency [Hz]"])
        assert float(row["identified magnitude"]) == pytest.approx(abs(1 / (mass * s + damping)), rel=1e-6)


def test_no_row_of_a_long_fit_is_lost() -> None:
    t = np.arange(9000) / 1000
    q = 0.1 * np.sin(9 * t) + 0.02 * np.sin(23 * t)
    v, a = 0.9 * np.cos(9 * t) + 0.46 * np.cos(23 * t), -8.1 * np.sin(9 * t) - 10.58 * np.sin(23 * t)
    preparation = symid.Preparation(cutoff_hz=100.0, decimation=1)
    log = {"t": t, "q": q, "F": 5 * a + 3 * v + 2 * np.sign(v)}
    found = symid.identify("rigid_1m", log, preparation=preparation, examine=False)
    (saved,) = [
        one for one in curve_data(identification_curves(found, axis=None, runs=[])) if "output" in one.file
    ]
    assert saved.file == "output-1.csv.gz"
    observation = found.observations[0]
    seconds = [float(row["time [s]"]) for row in rows_of(saved.address)]
    np.testing.assert_allclose(seconds, observation.time, atol=1e-7)


def test_names_are_kept_as_they_are() -> None:
    name = 'F "é" <&#%> [N]'
    assert list(rows_of(csv_address({"t": np.zeros(2), name: np.ones(1)}))[1].items()) == [
        ("t", "0"),
        (name, ""),
    ]
