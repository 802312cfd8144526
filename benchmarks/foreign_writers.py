"""One motion of a rigid axis as drives, scopes and robots write it, with their names, units and clocks."""

import gzip
import json
import warnings
from importlib import import_module
from pathlib import Path

import asammdf
import h5py
import nptdms
import numpy as np
import openpyxl
import polars as pl
import scipy.io
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

from symid import load_axis, simulate
from symid.simulation import plant_of, trapezoids, tuned_cascade

TRUE = {"M": 120.0, "Fv": 300.0, "Fs": 60.0}
PERIOD, COUNT, KT = 1e-3, 0.2e-6, 85.0


def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, counted positions, forces and references."""
    axis = load_axis("rigid_1m")
    reference = trapezoids([0.4, 0.15], [0.2, 0.6, 1.0], acceleration=5.0, jerk=200.0, sampling_period=PERIOD)
    log = simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "q")).log
    rng = np.random.default_rng(1)
    force = log["F"] + 0.5 * rng.standard_normal(log.n_samples)
    return log.time, COUNT * np.round(log["q"] / COUNT), force, np.asarray(log["reference"])


T, Q, F, R = motion()
EPOCH = 1_760_000_000_000_000_000
STAMPS = (EPOCH + np.round(1e9 * T).astype(np.int64)).tolist()


def rows(columns: list[np.ndarray], separator: str, *, comma: bool = False) -> str:
    text = "\n".join(separator.join(f"{x:.10g}" for x in row) for row in zip(*columns, strict=True))
    return text.replace(".", ",") if comma else text


def plain(path: Path) -> None:
    head = "Zeit [ms];Sollposition [mm];Istposition [mm];Strom [A]\n"
    path.write_text(head + rows([1e3 * T, 1e3 * R, 1e3 * Q, F / KT], ";", comma=True), "cp1252")


def counts(path: Path) -> None:
    head = "Sinumerik Trace\nAchse;X1\nAbtastzeit: 1 ms\n\nZeit;Lageistwert;Drehmoment\nms;Inkr;Nm\n"
    path.write_text(head + rows([1e3 * T, np.round(Q / COUNT), F / 50.0], ";", comma=True), "cp1252")


def twincat(path: Path) -> None:
    channels = {"Axis1.ActPos": 1e3 * Q, "Axis1.ActTorque": F / 10.0, "Axis1.SetPos": 1e3 * R}
    lines = ["Name\tScope YT Project", "File\tC:\\Scope\\run.svdx", "Starttime of export\t133000", ""]
    for key, values in {
        "Name": list(channels),
        "SymbolComment": [""] * 3,
        "Data-Type": ["REAL64", "REAL64", "REAL64"],
        "SampleTime[ms]": ["1"] * 3,
        "VariableSize": ["8"] * 3,
        "SymbolName": list(channels),
        "NetID": ["5.1.2.3.1.1"] * 3,
        "Port": ["501"] * 3,
    }.items():
        lines.append("\t".join(x for value in values for x in (key, value)))
    body = rows([x for value in channels.values() for x in (1e3 * T, value)], "\t")
    path.write_text("\r\n".join([*lines, "", *body.splitlines()]) + "\r\n")


def twincat_shared(path: Path) -> None:
    """As Scope exports by default: one column of times, in stamps of 100 ns, for all channels of a sample time."""
    names, units = ("ActPos", "ActTorque", "SetPos"), ("mm (Length)", "Nm (Torque)", "mm (Length)")
    lines = ["Name;run", "Starttime of export;132959733843760000;Montag, 2. Mai 2022;15:56:24.376", ""]
    lines += [";".join(row) for row in (("Name", *names), ("SampleTime[ms]", *"111"), ("Unit", *units))]
    stamps = [132959733843760000 + round(1e7 * t) for t in T.tolist()]
    body = rows([1e3 * Q, F / 10.0, 1e3 * R], ";", comma=True).splitlines()
    lines += ["", *(f"{stamp};{row}" for stamp, row in zip(stamps, body, strict=True)), "EOF"]
    path.write_text("\r\n".join(lines) + "\r\n", "utf-8-sig")


def control_desk(path: Path) -> None:
    head = [
        'header_version,"1.0"',
        'type,"measurement"',
        'date,"2026-11-21"',
        "name,XAxis,Model Root/Axis/pos,Model Root/Axis/I_q",
        "unit,s,mm,A",
        "description,,,",
    ]
    body = [
        f"trace_values,{line}" if k == 0 else f",{line}"
        for k, line in enumerate(rows([T, 1e3 * Q, F / KT], ",").splitlines())
    ]
    path.write_text("\n".join([*head, *body]) + "\n")


def dspace_mat(path: Path) -> None:
    ys = np.empty((1, 2), dtype=object)
    ys[0, 0] = {"Name": '"Model Root"/"Axis"/"position"', "Data": Q, "Unit": "m"}
    ys[0, 1] = {"Name": '"Model Root"/"Drive"/"force"', "Data": F, "Unit": "N"}
    scipy.io.savemat(path, {"rec1_001": {"X": {"Name": "", "Data": T}, "Y": ys, "Description": "x"}})


def simulink(path: Path) -> None:
    signals = np.empty((1, 2), dtype=object)
    signals[0, 0] = {"values": Q[:, None], "dimensions": 1.0, "label": "position"}
    signals[0, 1] = {"values": F[:, None], "dimensions": 1.0, "label": "force"}
    scipy.io.savemat(path, {"ScopeData": {"time": T[:, None], "signals": signals, "blockName": "m/Scope"}})


def matrix(path: Path) -> None:
    scipy.io.savemat(path, {"data": np.column_stack([T, Q, F])})


def matlab_7_3(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"time": T, "pos_mm": 1e3 * Q, "force": F}.items():
            file[f"log/{name}"] = values[None, :]
            file[f"log/{name}"].attrs["MATLAB_class"] = np.bytes_("double")
    content = bytearray(path.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    path.write_bytes(bytes(content))


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, values, unit in (("time", T, "s"), ("position", 1e3 * Q, "mm"), ("current", F / KT, "A")):
            file[f"measurement/{name}"] = values
            file[f"measurement/{name}"].attrs["unit"] = unit


def tdms(path: Path) -> None:
    wave = {"wf_increment": PERIOD, "wf_start_offset": 0.0, "wf_samples": T.size}
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("cDAQ", "Position", 1e3 * Q, {**wave, "unit_string": "mm"}),
                nptdms.ChannelObject("cDAQ", "Force", F, {**wave, "unit_string": "N"}),
            ]
        )


def mdf4(path: Path) -> None:
    with asammdf.MDF() as file:
        file.append([asammdf.Signal(1e3 * Q, T, unit="mm", name="Axis.Position")])
        file.append([asammdf.Signal(F, T, unit="N", name="Axis.Force")])
        file.save(path, overwrite=True)


def mcap(path: Path) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        channel = writer.register_channel(
            "/axis", "json", writer.register_schema("axis", "jsonschema", b"{}")
        )
        for stamp, q, f in zip(STAMPS, Q.tolist(), F.tolist(), strict=True):
            writer.add_message(channel, stamp, json.dumps({"position": q, "effort": f}).encode(), stamp)
        writer.finish()


def _bag(path: Path, plugin: StoragePlugin) -> None:
    """Joint states with stamps that jitter by 20 us."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    joints, header, moment = (
        store.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    late = np.random.default_rng(2).integers(0, 20_000, T.size).tolist()
    folder = path.with_suffix("")
    with BagWriter(folder, version=9, storage_plugin=plugin) as bag:
        topic = bag.add_connection("/joint_states", joints.__msgtype__, typestore=store)
        for stamp, delay, q, f in zip(STAMPS, late, Q, F, strict=True):
            now = stamp + delay
            head = header(moment(now // 10**9, now % 10**9), "")
            message = joints(head, ["axis_x"], np.array([q]), np.array([]), np.array([f]))
            bag.write(topic, now + 100_000, store.serialize_cdr(message, joints.__msgtype__))
    (folder / path.name).rename(path)


def ros2_mcap(path: Path) -> None:
    _bag(path, StoragePlugin.MCAP)


def ros2_db3(path: Path) -> None:
    _bag(path, StoragePlugin.SQLITE3)


def plot_juggler(path: Path) -> None:
    head = "__time,/joint_states/axis_x/position,/joint_states/axis_x/effort\n"
    body = "\n".join(
        f"{t:.9f},{q:.10g},{f:.10g}" for t, q, f in zip(1e-9 * np.array(STAMPS), Q, F, strict=True)
    )
    path.write_text(head + body)


def excel(path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["Versuch 7", "Achse X"])
    book.active.append(["Zeit", "Position", "Kraft"])
    book.active.append(["s", "mm", "N"])
    for row in zip(T.tolist(), (1e3 * Q).tolist(), F.tolist(), strict=True):
        book.active.append(row)
    book.save(path)


def json_log(path: Path) -> None:
    path.write_text(
        json.dumps(
            {"meta": {"axis": "x"}, "log": {"time": T.tolist(), "position": Q.tolist(), "force": F.tolist()}}
        )
    )


def json_lines(path: Path) -> None:
    records = zip(STAMPS, (1e3 * Q).tolist(), F.tolist(), strict=True)
    path.write_text(
        "\n".join(json.dumps({"timestamp_ns": s, "pos_mm": q, "force_n": f}) for s, q, f in records)
    )


def feather(path: Path) -> None:
    pl.DataFrame(
        {"timestamp": pl.Series(STAMPS).cast(pl.Datetime("ns")), "position": Q, "force": F}
    ).write_ipc(path)


def npz(path: Path) -> None:
    np.savez_compressed(path, time=T, position=Q, force=F)


def gzipped(path: Path) -> None:
    path.write_bytes(gzip.compress(("time,position (mm),force (N)\n" + rows([T, 1e3 * Q, F], ",")).encode()))


def simulink_dataset(path: Path) -> None:
    """Logged signals as objects, with uniform times by start and increment."""
    with warnings.catch_warnings():  # it sets an option of pandas that is deprecated
        warnings.simplefilter("ignore")
        matio, opaque = import_module("matio"), import_module("matio.utils.matclass").MatlabOpaque
    signals = np.empty((2, 1), dtype=object)
    for place, (name, values, unit) in enumerate((("x_meas", 1e3 * Q, "mm"), ("F_cmd", F, "N"))):
        times = {"Units": "seconds", "Start_": 0.0, "Increment_": PERIOD, "Length": float(T.size)}
        info = opaque(times, "tsdata.timemetadata"), opaque({"Units": unit}, "tsdata.datametadata")
        series = {
            "Name": name,
            "Data_": values,
            "Time_": np.zeros((0, 0)),
            "TimeInfo": info[0],
            "DataInfo": info[1],
        }
        signal = {"Name": name, "Values": opaque(series, "timeseries")}
        signals[place, 0] = opaque(signal, "Simulink.SimulationData.Signal")
    storage = opaque({"Elements_": signals}, "Simulink.SimulationData.Storage.RamDatasetStorage")
    dataset = opaque({"Name": "logsout", "Storage_": storage}, "Simulink.SimulationData.Dataset")
    matio.save_to_mat(str(path), {"logsout": dataset}, version="v7")


def oscilloscope(path: Path) -> None:
    """As PicoScope exports: units in parentheses above an empty line; 1 V is 50 mm and 100 N."""
    body = rows([1e3 * T, 20 * Q, 10 * F], ";", comma=True)
    path.write_text(f"Zeit;Kanal A;Kanal B\n(ms);(V);(mV)\n\n{body}\n")


def sheet_of_texts(path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["Protokoll", "Achse X"])
    sheet = book.create_sheet("Messung")
    sheet.append(["Zeit [ms]", "Weg [mm]", "Kraft [kN]"])
    for line in rows([1e3 * T, 1e3 * Q, 1e-3 * F], ";", comma=True).splitlines():
        sheet.append(line.split(";"))
    book.save(path)


def two_files(path: Path) -> None:
    drive, scope = (Path(name) for name in str(path).split("+"))
    drive.write_text("t_s,pos_mm\n" + rows([T, 1e3 * Q], ","))
    scope.write_text("t_s,force_N\n" + rows([T, F], ","))


def headerless(path: Path) -> None:
    path.write_text(rows([T, 1e3 * Q, F], " "))


def iso(path: Path) -> None:
    moments = pl.Series(STAMPS).cast(pl.Datetime("ns")).dt.strftime("%Y-%m-%dT%H:%M:%S%.6fZ")
    body = "\n".join(f"{t},{q:.10g},{f:.10g}" for t, q, f in zip(moments, 1e3 * Q, F, strict=True))
    path.write_text("timestamp,position_mm,force_N\n" + body)
