"""One log in each kind of file that symid reads: its columns, and functions that write it."""

import gzip
import json
from pathlib import Path

import asammdf
import h5py
import nptdms
import numpy as np
import openpyxl
import polars as pl
import scipy.io
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2McapWriter
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin, Writer as FolderWriter
from rosbags.typesys import Stores, get_typestore

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
    scipy.io.savemat(
        path,
        {"run": {"t": T, "axis": {"q": Q[:, None], "F": F}, "name": "x"}, "dt": PERIOD},
        do_compression=True,
    )


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
    scipy.io.savemat(
        path, {"rec1": {"X": {"Name": "t", "Data": T}, "Y": ys, "Description": "x"}}, do_compression=True
    )


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
        signals = [asammdf.Signal(1e3 * Q, T, unit="mm", name="q"), asammdf.Signal(F, T, unit="N", name="F")]
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
