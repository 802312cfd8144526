"""The files that scopes, drives and robots write: each is written by its own library and read alike."""

import gzip
import json
import sys
from pathlib import Path

import asammdf
import h5py
import nptdms
import numpy as np
import openpyxl
import polars as pl
import pytest
import scipy.io
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2McapWriter
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as FolderWriter
from rosbags.typesys import Stores, get_typestore

from symid.data import Layout, guessed_layout, open_table, read_log
from symid.data.formats import FOLDER_SUFFIXES, SUFFIXES
from symid.data.formats.extra import required
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
N, PERIOD = 300, 0.004
T = PERIOD * np.arange(N)
Q = 0.1 * np.sin(3.0 * T)
F = 50.0 * np.cos(2.0 * T) + 1.0
COLUMNS = {"t": T, "q": Q, "F": F}


def feather(path: Path) -> None:
    pl.DataFrame(COLUMNS).write_ipc(path)


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["run/t"], file["run/F"] = T, F[:, None]
        file["run/q"] = 1e3 * Q
        file["run/q"].attrs["units"] = "mm"
        file["run/name"], file["gain"] = "axis", 2.0


def compound(path: Path) -> None:
    rows = np.zeros(N, dtype=[("t", "f8"), ("q", "f4"), ("F", "f8"), ("note", "S3")])
    rows["t"], rows["q"], rows["F"] = T, Q, F
    with h5py.File(path, "w") as file:
        file["log"] = rows


def matlab_7_3(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in COLUMNS.items():
            file[f"run/{name}"] = values[None, :]
            file[f"run/{name}"].attrs["MATLAB_class"] = np.bytes_("double")
        file["run/title"] = np.frombuffer("axis".encode("utf-16-le"), dtype="u2")[:, None]
        file["run/title"].attrs["MATLAB_class"] = np.bytes_("char")
        file["#refs#/a"] = np.arange(9.0)
    content = bytearray(path.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    path.write_bytes(bytes(content))


def struct(path: Path) -> None:
    scipy.io.savemat(path, {"run": {"t": T, "axis": {"q": Q[:, None], "F": F}, "name": "x"}, "dt": PERIOD})


def structure_with_time(path: Path) -> None:
    """What a Scope of Simulink saves."""
    signals = np.empty((1, 2), dtype=object)
    signals[0, 0] = {"values": Q[:, None], "dimensions": 1.0, "label": "q"}
    signals[0, 1] = {"values": F[:, None], "dimensions": 1.0, "label": "F"}
    scipy.io.savemat(path, {"ScopeData": {"t": T[:, None], "signals": signals, "blockName": "m/Scope"}})


def dspace(path: Path) -> None:
    """What ControlDesk saves: one clock, signals by name."""
    ys = np.empty((1, 2), dtype=object)
    ys[0, 0], ys[0, 1] = {"Name": "q", "Data": Q, "Unit": "m"}, {"Name": "F", "Data": F, "Unit": "N"}
    scipy.io.savemat(path, {"rec1": {"X": {"Name": "t", "Data": T}, "Y": ys, "Description": "x"}})


def tdms(path: Path) -> None:
    wave = {"wf_increment": PERIOD, "wf_start_offset": 0.0, "wf_samples": N}
    channels = [
        nptdms.ChannelObject("axis", "q", 1e3 * Q, {**wave, "unit_string": "mm"}),
        nptdms.ChannelObject("axis", "F", F, wave),
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)


def mdf(path: Path) -> None:
    with asammdf.MDF() as file:
        signals = [
            asammdf.Signal(1e3 * Q, T, unit="mm", name="q"),
            asammdf.Signal(F, T, unit="N", name="F"),
        ]
        file.append(signals)
        file.save(path, overwrite=True)


EPOCH = 1_760_000_000_000_000_000
STAMPS = [EPOCH + round(1e9 * t) for t in T.tolist()]


def mcap_of_json(path: Path) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("axis", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/axis", "json", schema)
        for stamp, q, f in zip(STAMPS, Q.tolist(), F.tolist(), strict=True):
            message = json.dumps({"q": q, "F": f, "state": "run", "on": True}).encode()
            writer.add_message(channel, stamp, message, stamp)
        writer.finish()


AXIS_MESSAGE = (
    "std_msgs/Header header\nfloat64 q\nfloat64 force\nuint8[4] flags\n"
    f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)


def mcap_of_ros2(path: Path) -> None:
    """Messages that are recorded late by a random time, with a stamp."""
    late = np.random.default_rng(5).integers(10**5, 10**6, N)
    with path.open("wb") as file:
        writer = Ros2McapWriter(file)
        schema = writer.register_msgdef("drive_msgs/msg/Axis", AXIS_MESSAGE)
        for stamp, q, f, delay in zip(STAMPS, Q, F, late.tolist(), strict=True):
            header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "x"}
            message = {"header": header, "q": q, "force": f, "flags": [0, 1, 0, 1]}
            writer.write_message("/axis", schema, message, log_time=stamp + delay)
        writer.finish()


def rosbag2(path: Path) -> None:
    """Two topics that are recorded at the same times."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    number = store.types["std_msgs/msg/Float64"]
    folder = path.with_suffix("")
    with FolderWriter(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topics = {
            name: bag.add_connection(f"/{name}", number.__msgtype__, typestore=store) for name in ("q", "F")
        }
        for stamp, q, f in zip(STAMPS, Q.tolist(), F.tolist(), strict=True):
            for name, value in (("q", q), ("F", f)):
                raw = store.serialize_cdr(number(value), number.__msgtype__)
                bag.write(topics[name], stamp, raw)
    (folder / f"{folder.name}.db3").rename(path)


def rosbag1(path: Path) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    number = store.types["geometry_msgs/msg/Vector3"]
    with BagWriter(path) as bag:
        axis = bag.add_connection("/axis", number.__msgtype__, typestore=store)
        for stamp, q, f in zip(STAMPS, Q.tolist(), F.tolist(), strict=True):
            bag.write(axis, stamp, store.serialize_ros1(number(q, f, 0.0), number.__msgtype__))


def excel(path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["only a title"])
    sheet = book.create_sheet("Trace")
    sheet.append(["Recorded by hand"])
    sheet.append(["t", "q", "F"])
    sheet.append(["s", "mm", "N"])
    for row in zip(T, 1e3 * Q, F, strict=True):
        sheet.append([float(value) for value in row])
    book.save(path)


def npz(path: Path) -> None:
    np.savez_compressed(path, **COLUMNS, gain=2.0)


def columns_by_name(path: Path) -> None:
    path.write_text(json.dumps({"meta": {"axis": "x"}, "data": {k: v.tolist() for k, v in COLUMNS.items()}}))


def records() -> list[dict[str, object]]:
    return [
        {"t": t, "axis": {"q": q, "F": f}, "state": "run"}
        for t, q, f in zip(T.tolist(), Q.tolist(), F.tolist(), strict=True)
    ]


def list_of_records(path: Path) -> None:
    path.write_text(json.dumps(records()))


def rows_as_pandas_splits(path: Path) -> None:
    rows = np.column_stack(list(COLUMNS.values())).tolist()
    path.write_text(json.dumps({"columns": list(COLUMNS), "index": list(range(N)), "data": rows}))


def record_a_line(path: Path) -> None:
    path.write_text("\n".join(map(json.dumps, records())))


def text(separator: str = ",", *, header: str = "t,q,F") -> str:
    rows = zip(T.tolist(), Q.tolist(), F.tolist(), strict=True)
    return "\n".join([header, *(separator.join(map(repr, row)) for row in rows)]) + "\n"


def gzipped(path: Path) -> None:
    path.write_bytes(gzip.compress(text().encode()))


FILES = {
    "a.feather": feather,
    "a.arrow": feather,
    "a.h5": hdf5,
    "b.hdf5": compound,
    "a.mat": struct,
    "b.mat": structure_with_time,
    "c.mat": dspace,
    "d.mat": matlab_7_3,
    "a.tdms": tdms,
    "a.mf4": mdf,
    "a.mcap": mcap_of_json,
    "a.db3": rosbag2,
    "a.xlsx": excel,
    "a.npz": npz,
    "a.json": columns_by_name,
    "b.json": list_of_records,
    "c.json": rows_as_pandas_splits,
    "a.jsonl": record_a_line,
    "a.ndjson": record_a_line,
    "a.csv.gz": gzipped,
}


@pytest.mark.parametrize("name", FILES)
def test_each_kind_is_read_alike(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    FILES[name](path)
    log = read_log(path, expected=EXPECTED)
    assert log.sampling_period == PERIOD
    np.testing.assert_allclose(log["q"], Q, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(log["F"], F, rtol=1e-12)


@pytest.mark.parametrize("name", FILES)
def test_each_kind_that_is_damaged_is_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    FILES[name](path)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for size in (1, len(whole) // 3, len(whole) // 2, len(whole) - 9):
        path.write_bytes(whole[:size])
        _fails_in_one_line_or_reads(path)
    if name in ("a.mat", "b.mat", "c.mat", "a.mf4"):
        return  # the parsers of scipy and asammdf end the process on some: a batch survives that, a test does not
    for _ in range(12):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), 20):
            damaged[place] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(damaged))
        _fails_in_one_line_or_reads(path)


def _fails_in_one_line_or_reads(path: Path) -> None:
    try:
        read_log(path, expected=EXPECTED)
    except LogError as error:
        message = str(error)
        assert "\n" not in message
        assert message.startswith(f"{path}: ")


def test_joints_are_named_by_their_message(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    joints, header, moment = (
        store.types[f"{package}/msg/{name}"]
        for package, name in (
            ("sensor_msgs", "JointState"),
            ("std_msgs", "Header"),
            ("builtin_interfaces", "Time"),
        )
    )
    with FolderWriter(tmp_path / "run", version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        topic = bag.add_connection("/joint_states", joints.__msgtype__, typestore=store)
        for stamp, q, f in zip(STAMPS, Q, F, strict=True):
            stamped = header(moment(stamp // 10**9, stamp % 10**9), "")
            message = joints(stamped, ["a", "b"], np.array([q, 0.0]), np.array([]), np.array([f, 1.0]))
            bag.write(topic, stamp + 700_000, store.serialize_cdr(message, joints.__msgtype__))
    columns = {"q": "joint_states.a.position", "F": "joint_states.a.effort"}
    log = read_log(tmp_path / "run" / "run.mcap", expected=EXPECTED, columns=columns)
    assert log.sampling_period == PERIOD
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


def test_fields_of_messages_are_columns(tmp_path: Path) -> None:
    rosbag1(tmp_path / "a.bag")
    mcap_of_ros2(tmp_path / "a.mcap")
    for name, columns in (("a.bag", {"q": "x", "F": "y"}), ("a.mcap", {"F": "force"})):
        log = read_log(tmp_path / name, expected=EXPECTED, columns=columns)
        assert log.sampling_period == PERIOD
        np.testing.assert_array_equal(log["q"], Q)
        np.testing.assert_array_equal(log["F"], F)


def test_messages_in_another_encoding_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        channel = writer.register_channel("/a", "protobuf", writer.register_schema("a", "protobuf", b""))
        writer.add_message(channel, 0, b"", 0)
        writer.finish()
    with pytest.raises(LogError, match=r"p\.mcap: its messages are in protobuf: record ROS 2 or JSON"):
        open_table(path)


def test_matrices_are_their_columns(tmp_path: Path) -> None:
    matrix = np.column_stack(list(COLUMNS.values()))
    scipy.io.savemat(tmp_path / "m.mat", {"data": matrix})
    with h5py.File(tmp_path / "m.h5", "w") as file:
        file["data"] = matrix.T
    for name, columns in (
        ("m.mat", {"t": "data(:,1)", "q": "data(:,2)", "F": "data(:,3)"}),
        ("m.h5", {"t": "1", "q": "2", "F": "3"}),
    ):
        log = read_log(tmp_path / name, expected=EXPECTED, columns=columns)
        np.testing.assert_array_equal(log["q"], Q)
        np.testing.assert_array_equal(log["F"], F)


def test_names_that_repeat_are_whole_paths(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "two.mat", {"a": {"q": Q}, "b": {"q": Q}, "t": T})
    assert set(open_table(tmp_path / "two.mat").headers) == {"a.q", "b.q", "t"}


def test_a_library_that_is_missing_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hdf5(tmp_path / "a.h5")
    mdf(tmp_path / "a.mf4")
    mcap_of_json(tmp_path / "a.mcap")
    for library, name in (("h5py", "a.h5"), ("asammdf", "a.mf4"), ("mcap.reader", "a.mcap")):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(LogError, match=rf"files are read by {library}, .* pip install 'symid\[files\]'"):
            read_log(tmp_path / name, expected=EXPECTED)
    assert required("json", tmp_path) is json


def test_results_and_settings_in_a_folder_are_no_logs() -> None:
    assert set(SUFFIXES) - set(FOLDER_SUFFIXES) == {".json", ".npz", ".xls", ".ods"}


@pytest.mark.parametrize(
    "content", ["[]", "{}", '"a"', '{"a": [[1, 2], [3]]}', '[{"a": "x"}]', "[" * 100_000]
)
def test_json_without_columns_is_refused(content: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(content)
    with pytest.raises(LogError, match=r"a\.json: ") as caught:
        open_table(path)
    assert "\n" not in str(caught.value)


def test_no_objects_are_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "o.npz", t=np.array([{"a": 1}] * 30, dtype=object))
    with pytest.raises(LogError, match=r"o\.npz: is damaged or no NPZ file"):
        open_table(tmp_path / "o.npz")


# Text without names, and moments


def test_a_file_without_names_has_numbered_columns(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text(text().partition("\n")[2])
    layout = guessed_layout(path)
    assert layout == Layout("utf-8-sig", ",", ".", 0, 0, named=False)
    columns = {"t": "column 1", "q": "column 2", "F": "column 3"}
    log = read_log(path, expected=EXPECTED, columns=columns, layout=layout)
    assert log.n_samples == N
    np.testing.assert_array_equal(log["F"], F)


def test_compressed_text_has_lines_above_its_header(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv.gz"
    above = "Trace of axis X\nrecorded today\n\n"
    path.write_bytes(gzip.compress((above + text(";", header="t;q;F")).encode("utf-16")))
    np.testing.assert_array_equal(read_log(path, expected=EXPECTED)["q"], Q)


@pytest.mark.parametrize(
    "stamp",
    [
        lambda k: (
            f"2026-11-21T09:59:59.{4 * k:03d}Z" if k < 250 else f"2026-11-21T10:00:00.{4 * k - 1000:03d}Z"
        ),
        lambda k: (
            f"2026-11-21 23:59:59.{4 * k:03d}" if k < 250 else f"2026-11-22 00:00:00.{4 * k - 1000:03d}"
        ),
        lambda k: f"23:59:59.{4 * k:03d}" if k < 250 else f"00:00:00.{4 * k - 1000:03d}",
    ],
)
def test_moments_are_seconds(stamp, tmp_path: Path) -> None:
    path = tmp_path / "iso.csv"
    rows = [f"{stamp(k)},{q!r},{f!r}" for k, (q, f) in enumerate(zip(Q.tolist(), F.tolist(), strict=True))]
    path.write_text("\n".join(["t,q,F", *rows]))
    log = read_log(path, expected=EXPECTED)
    assert log.sampling_period == pytest.approx(PERIOD)
    np.testing.assert_array_equal(log["q"], Q)
    assert guessed_layout(path).above == 0


def test_a_column_of_words_is_no_column_of_moments(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text().replace("\n0.004,", "\nlater,"))
    with pytest.raises(LogError, match="'later' in row 2"):
        read_log(path, expected=EXPECTED)


@pytest.mark.parametrize("mark", ["", "# "])
def test_columns_of_spaces_are_read(mark: str, tmp_path: Path) -> None:
    path = tmp_path / "run.dat"
    rows = "\n".join(f"{t:12.6f}{q:26.17e}\t  {f!r}  " for t, q, f in zip(T, Q, F.tolist(), strict=True))
    path.write_text(f"a log of the axis, written by hand\n{mark}t   q\tF\n{rows}\n")
    layout = guessed_layout(path)
    assert layout == Layout("utf-8-sig", " ", ".", 1, 0)
    log = read_log(path, expected=EXPECTED, layout=layout)
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


def test_the_mark_of_a_comment_is_no_name(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.csv", np.column_stack(list(COLUMNS.values())), header="t,q,F", delimiter=",")
    np.testing.assert_array_equal(read_log(tmp_path / "a.csv", expected=EXPECTED)["F"], F)
