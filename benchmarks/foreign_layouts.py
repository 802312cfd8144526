"""The motion of `foreign_writers` in further layouts of text and tables: drives, controllers, scopes and brokers."""

import json
import zipfile
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.foreign_writers import COUNT, KT, STAMPS, F, Q, R, T, rows

V = np.gradient(Q, T)
DEGREE = np.pi / 180
AXIS_OF_A_TABLE = """from symid import Axis, Body, CoulombFriction, Drive, Position, ViscousFriction
table = Body("table", inertia="M")
axis = Axis(
    "table",
    (table, ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs")),
    Drive("F", table),
    (Position("q", table),),
)
"""
"""An axis that turns, with the names of `rigid_1m`."""


def cells(columns: list, separator: str) -> str:
    """Rows of numbers and texts."""
    return "\n".join(
        separator.join(x if isinstance(x, str) else f"{x:.10g}" for x in row)
        for row in zip(*columns, strict=True)
    )


def moments() -> list[datetime]:
    return [datetime.fromtimestamp(stamp // 1000 / 1e6, UTC) for stamp in STAMPS]


def bare_names(path: Path) -> None:
    """As the trends of a controller: no units, and a torque in per cent."""
    head = (
        "Controller,AXIS_01\nSample Period,1 ms\n\nTime (ms),AXIS_01.ActualPosition,AXIS_01.TorqueReference\n"
    )
    path.write_text(head + rows([1e3 * T, 1e3 * Q, F / 10], ","))


def numbered_samples(path: Path) -> None:
    """As the tool of a servo: a stated period in quotes, speeds and per cents, lengths of a count in names."""
    head = '"Trace"\n"Sampling Time","1000","us"\n"No.","Feedback Speed[mm/s]","Torque Reference[%]","Position[1 um]"\n'
    path.write_text(head + rows([np.arange(T.size), 1e3 * V, F / 10, 1e6 * Q], ","))


def japanese(path: Path) -> None:
    head = "波形グラフィック\nサンプリング周期,1,ms\n時間[ms],指令位置[mm],モータ位置[mm],トルク指令[%]\n"
    path.write_bytes((head + rows([1e3 * T, 1e3 * R, 1e3 * Q, F / 10], ",")).encode("cp932"))


def droop(path: Path) -> None:
    """As a servo amplifier: pulses, their droop before the position, and a torque in 0.1 %."""
    head = "[Wave]\nTime [ms],Droop pulses [pulse],Motor position [pulse],Torque [0.1%]\n"
    path.write_text(head + rows([1e3 * T, np.round((R - Q) / 1e-6), np.round(Q / 1e-6), F], ","))


def properties(path: Path) -> None:
    """As LabVIEW's measurement files: units among the properties, and a column of remarks without values."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\nY_Unit_Label\tmm\tkN\n"
    head += "Delta_X\t0.001\t0.001\n***End_of_Header***\t\t\nX_Value\tPosition\tForce\tComment\n"
    path.write_text(head + rows([T, 1e3 * Q, F / 1e3], "\t"))


def labels(path: Path) -> None:
    """As an oscilloscope with labels of its channels: 1 V is 50 mm and 100 N."""
    head = "Model,MSO\nVertical Units,V,V\nLabel,Position,Force\nTIME,CH1,CH2\n"
    path.write_text(head + rows([T, 20 * Q, F / 100], ","))


def padded(path: Path) -> None:
    """As a control prints its scope: names that hold spaces above columns of spaces."""
    head = "Scope\nChannel 1\n\n Time [ms]   s noml X [mm]   s actual X [mm]   I (int) X [A]\n"
    body = (
        f"{1e3 * t:10.3f} {1e3 * r:14.6f} {1e3 * q:14.6f} {f / KT:12.6f}"
        for t, r, q, f in zip(T, R, Q, F, strict=True)
    )
    path.write_text(head + "\n".join(body))


def rostopic(path: Path) -> None:
    """As `rostopic echo -p`: the stamp of the message behind the time of its arrival."""
    late = [str(stamp + 100_000 + k * k % 7000) for k, stamp in enumerate(STAMPS)]
    head = "%time,field.header.seq,field.header.stamp,field.name0,field.position0,field.effort0\n"
    path.write_text(
        head
        + cells([late, range(T.size), [*map(str, STAMPS)], ["axis_x"] * T.size, Q.tolist(), F.tolist()], ",")
    )


def gathered(path: Path) -> None:
    """As a motion controller gathers: numbers of servo cycles, counts, and a command without a unit."""
    head = "% ServoPeriod 1 ms\nSys.ServoCount Motor[1].ActPos.a Motor[1].DesPos.a Motor[1].IqCmd.a\n"
    path.write_text(
        head + rows([np.arange(T.size) + 100, np.round(Q / COUNT), np.round(R / COUNT), 100 * F / KT], " ")
    )


def sparse(path: Path) -> None:
    """As PlotJuggler exports topics that come at different times: a row for each, with blank cells."""
    stamps = [stamp / 1e9 for stamp in STAMPS]
    of_joint = (f"{t:.9f},{q:.10g},,{f:.10g}" for t, q, f in zip(stamps, Q, F, strict=True))
    of_command = (f"{t + 2.3e-4:.9f},,{r:.10g}," for t, r in zip(stamps, R, strict=True))
    body = (line for pair in zip(of_joint, of_command, strict=True) for line in pair)
    head = "__time,/joints/x/position,/command/x/position_setpoint,/joints/x/effort\n"
    path.write_text(head + "\n".join(body))


def annotated(path: Path) -> None:
    """As InfluxDB: lines of types, and a row for each value with the name of its field."""
    stamps = [moment.isoformat().replace("+00:00", "Z") for moment in moments()]
    head = "#group,false,false,true,false,false,true\n#default,_result,,,,,\n,result,table,_start,_time,_value,_field\n"
    body = [
        f",,{k},2026-01-01T00:00:00Z,{stamp},{x:.10g},{name}"
        for k, (name, values) in enumerate((("position_mm", 1e3 * Q), ("force_N", F)))
        for stamp, x in zip(stamps, values, strict=True)
    ]
    path.write_text(head + "\n".join(body))


def messages(path: Path) -> None:
    """As a client of a broker: a record for each message."""
    path.write_text(
        "\n".join(
            json.dumps({"ts": stamp / 1e9, "topic": topic, "value": x})
            for stamp, q, f in zip(STAMPS, (1e3 * Q).tolist(), F.tolist(), strict=True)
            for topic, x in (("axis/position_mm", q), ("axis/force_n", f))
        )
    )


def nested(path: Path) -> None:
    """As a controller's interface: a record for each sample, whose values are named by their path."""
    columns = (x.tolist() for x in (T, Q, R, F))
    samples = [
        {"t": t, "x": {"position": {"actual": q, "command": r}, "force": f}}
        for t, q, r, f in zip(*columns, strict=True)
    ]
    path.write_text(json.dumps({"samples": samples}))


def dashboard(path: Path) -> None:
    """As Grafana: moments and units in the cells."""
    body = (
        f"{moment:%Y-%m-%d %H:%M:%S.%f},{1e3 * q:.8g} mm,{f:.8g} N"
        for moment, q, f in zip(moments(), Q, F, strict=True)
    )
    path.write_text('"Time","Position","Force"\n' + "\n".join(body))


def numbered_rows(path: Path) -> None:
    """As pandas writes: a column of the numbers of rows without a name."""
    path.write_text(pd.DataFrame({"time": T, "position": Q, "force": F}).to_csv())


def indexed(path: Path) -> None:
    frame = pd.DataFrame({"position": Q, "force": F}, index=pd.to_datetime(STAMPS))
    frame.to_parquet(path)


def zipped(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("run.csv", "time,position (mm),force (N)\n" + rows([T, 1e3 * Q, F], ","))


def serial(path: Path) -> None:
    """As the monitor of a serial port: names beside values."""
    body = (
        f"{moment:%H:%M:%S.%f} -> t_us:{1e6 * t:.0f},pos_mm:{1e3 * q:.8g},i_A:{f / KT:.6g}"
        for moment, t, q, f in zip(moments(), T, Q, F, strict=True)
    )
    path.write_text("\n".join(body))


def trace(path: Path) -> None:
    """As CODESYS: properties, and the samples of each variable below its name."""
    lines = ["[key]; [value]", "Name; Application.Trace", "Flags; 32"]
    for k, (name, values) in enumerate((("fActPosition", 1e3 * Q), ("fActTorque", F / 10))):
        lines += [f"{k}.Variable; PLC_PRG.axis.{name}", f"{k}.Data; "]
        lines += [f"; {1e6 * t + 2:.0f}; {x:.10g}" for t, x in zip(T, values, strict=True)]
    path.write_text("\n".join(lines) + "\n")


def comma_pairs(path: Path) -> None:
    """Decimal commas between commas."""
    body = (",".join(f"{x:.6f}".replace(".", ",") for x in row) for row in zip(T, 1e3 * Q, F, strict=True))
    path.write_text("Zeit [s],Weg [mm],Kraft [N]\n" + "\n".join(body))


def thousands(path: Path) -> None:
    body = (",".join(f'"{x:,.3f}"' for x in row) for row in zip(1e6 * T, 1e6 * Q, 1e3 * F, strict=True))
    path.write_text("Time [us],Position [um],Force [mN]\n" + "\n".join(body))


def overflowing(path: Path) -> None:
    path.write_text("time_us,pos_mm,force_N\n" + rows([np.round(1e6 * T) % 65536, 1e3 * Q, F], ","))


def last_first(path: Path) -> None:
    path.write_text("time,pos_mm,force_N\n" + rows([T[::-1], 1e3 * Q[::-1], F[::-1]], ","))


def exponents_by_d(path: Path) -> None:
    body = ("  ".join(f"{x:.9E}".replace("E", "D") for x in row) for row in zip(T, Q, F, strict=True))
    path.write_text("  TIME  POS  FORCE\n" + "\n".join(body))


def russian(path: Path) -> None:
    body = rows([1e3 * T, 1e3 * Q, F], ";", comma=True)
    path.write_bytes(("Время, мс;Положение, мм;Сила, Н\n" + body).encode("cp1251"))


def coarse(path: Path) -> None:
    """Times rounded to 10 ms."""
    body = (f"{t:.2f},{1e3 * q:.8g},{f:.8g}" for t, q, f in zip(T, Q, F, strict=True))
    path.write_text("time [s],position [mm],force [N]\n" + "\n".join(body))


def lost_rows(path: Path) -> None:
    kept = np.setdiff1d(np.arange(T.size), [500, 501, 1200, 3000])
    path.write_text("time [s],position [mm],force [N]\n" + rows([T[kept], 1e3 * Q[kept], F[kept]], ","))


def millitm(path: Path) -> None:
    """A day, a time of day in seconds, and its milliseconds."""
    body = (
        f"11/21/2026,{moment:%H:%M:%S},{moment.microsecond // 1000},{1e3 * q:.8g},{f:.8g}"
        for moment, q, f in zip(moments(), Q, F, strict=True)
    )
    path.write_text("Date,Time,Millitm,Position [mm],Force [N]\n" + "\n".join(body))


def two_clocks(path: Path) -> None:
    """A column of times for each channel, of which the second is half as fast."""
    slow = [f"{t:.4f},{f:.8g}" for t, f in zip(T[::2], F[::2], strict=True)]
    body = (
        f"{t:.4f},{1e3 * q:.8g},{slow[k] if k < len(slow) else ','}"
        for k, (t, q) in enumerate(zip(T, Q, strict=True))
    )
    path.write_text("t1 [s],pos [mm],t2 [s],force [N]\n" + "\n".join(body))


def degrees(path: Path) -> None:
    """As a servo's trace: an angle of which nothing but its extent tells that it is in degrees."""
    path.write_text("Time (ms),ActualPosition,Torque [Nm]\n" + rows([1e3 * T, Q / DEGREE, F], ","))


def turns(path: Path) -> None:
    """As ODrive."""
    columns = [T, R / (2 * np.pi), Q / (2 * np.pi), V / (2 * np.pi), F / KT]
    path.write_text("time,pos_setpoint,pos_estimate,vel_estimate,Iq_measured\n" + rows(columns, ","))


def joint(path: Path) -> None:
    """As a robot's interface: columns of spaces, radians, targets beside what is actual."""
    head = "timestamp target_q_0 actual_q_0 actual_qd_0 target_current_0 actual_current_0\n"
    path.write_text(head + rows([T + 1234.5, R, Q, V, F / 12, F / KT], " "))
