"""Files of drives, scopes and robots, each from `symid import` to `symid diagnose` without an editor.

One motion of a rigid axis (0.2 um counts, 1 kHz, force held by the drive) is written by the library or in the layout of
each writer, with its names, units and clocks. Commands are run as a user would, with the options in the table: what a
file does not say (force per ampere, length of a count) is given. Printed are the error of the identified mass, the
verdict of the diagnosis, and what stopped it.

Usage: python -m benchmarks.foreign_files [NAME ...] [--no-diagnosis]
"""

import contextlib
import io
import json
import shlex
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from benchmarks import foreign_layouts as layouts
from benchmarks.foreign_writers import (
    TRUE,
    control_desk,
    counts,
    dspace_mat,
    excel,
    feather,
    gzipped,
    hdf5,
    headerless,
    iso,
    json_lines,
    json_log,
    matlab_7_3,
    matrix,
    mcap,
    mdf4,
    npz,
    oscilloscope,
    plain,
    plot_juggler,
    ros2_db3,
    ros2_mcap,
    sheet_of_texts,
    simulink,
    simulink_dataset,
    tdms,
    twincat,
    twincat_shared,
    two_files,
)
from benchmarks.options import parser_of
from symid.cli import main as symid


class File(NamedTuple):
    """A file of one writer, and the options of the commands beside the axis."""

    name: str
    write: Callable[[Path], None]
    of_import: str = ""
    of_others: str = ""
    axis: str = "rigid_1m"


FILES = {
    "semicolons, German": File("a.csv", plain, "--gain 85"),
    "Siemens-like trace, counts": File(
        "b.csv", counts, "--gain 50 --column q=Lageistwert --unit q='5000 counts/mm'"
    ),
    "TwinCAT Scope": File("c.csv", twincat, "--gain 10"),
    "TwinCAT, shared times": File("w.csv", twincat_shared, "--gain 10"),
    "ControlDesk CSV": File("d.csv", control_desk, "--gain 85"),
    "ControlDesk MAT": File("d.mat", dspace_mat),
    "Simulink structure": File("e.mat", simulink),
    "MATLAB matrix": File("f.mat", matrix, "--column q=data(:,2) --column F=data(:,3)"),
    "MATLAB 7.3 struct": File("g.mat", matlab_7_3),
    "HDF5": File("h.h5", hdf5, "--gain 85"),
    "TDMS": File("i.tdms", tdms),
    "MDF 4": File("j.mf4", mdf4),
    "MCAP, JSON": File("k.mcap", mcap),
    "MCAP, ROS 2": File("l.mcap", ros2_mcap, "", "--resample own"),
    "ROS 2 bag, SQLite": File("m.db3", ros2_db3, "", "--resample own"),
    "PlotJuggler": File("n.csv", plot_juggler),
    "Excel": File("o.xlsx", excel),
    "JSON": File("p.json", json_log),
    "JSON lines": File("q.jsonl", json_lines),
    "Feather": File("r.feather", feather),
    "NPZ": File("s.npz", npz),
    "CSV.GZ": File("t.csv.gz", gzipped),
    "without names": File("u.txt", headerless, "--column q='column 2' --unit q=mm --column F='column 3'"),
    "ISO time": File("v.csv", iso),
    "Simulink dataset": File("x.mat", simulink_dataset),
    "oscilloscope, volts": File(
        "y.csv",
        oscilloscope,
        "--column 'q=Kanal A [V]' --unit q='50 mm' --column 'F=Kanal B [mV]' --unit F='0.1 N'",
    ),
    "Excel, texts": File("z.xlsx", sheet_of_texts),
    "two files": File("drive.csv+scope.csv", two_files),
    "controller, bare names": File("aa.csv", layouts.bare_names, "--rated 1000"),
    "numbered samples": File("ab.csv", layouts.numbered_samples, "--rated 1000"),
    "Japanese, Shift-JIS": File("ac.csv", layouts.japanese, "--rated 1000"),
    "droop in pulses": File("ad.csv", layouts.droop, "--rated 1000 --unit q='1000 counts/mm'"),
    "units among properties": File("ae.lvm", layouts.properties),
    "labels of a scope, volts": File(
        "af.csv",
        layouts.labels,
        "--column 'q=Position [V]' --unit q='50 mm' --column 'F=Force [V]' --gain 100",
    ),
    "names with spaces": File("ag.txt", layouts.padded, "--gain 85"),
    "rostopic": File("ah.csv", layouts.rostopic),
    "gathered cycles": File("ai.txt", layouts.gathered, "--unit q='5000 counts/mm' --gain 0.85"),
    "PlotJuggler, sparse": File("aj.csv", layouts.sparse, "", "--resample own"),
    "InfluxDB": File("ak.csv", layouts.annotated),
    "messages of a broker": File("al.jsonl", layouts.messages),
    "nested JSON": File("bf.json", layouts.nested),
    "Grafana": File("am.csv", layouts.dashboard),
    "pandas, CSV": File("an.csv", layouts.numbered_rows),
    "pandas, Parquet": File("ao.parquet", layouts.indexed),
    "ZIP": File("ap.zip", layouts.zipped),
    "serial monitor": File("aq.log", layouts.serial, "--gain 85"),
    "CODESYS trace": File("ar.csv", layouts.trace, "--unit F=Nm --gain 10"),
    "decimal commas in commas": File("as.csv", layouts.comma_pairs),
    "thousands": File("at.csv", layouts.thousands),
    "overflowing clock": File("au.csv", layouts.overflowing),
    "last row first": File("av.csv", layouts.last_first),
    "exponents by D": File("aw.dat", layouts.exponents_by_d),
    "Russian, cp1251": File("ax.csv", layouts.russian),
    "coarse times": File("ay.csv", layouts.coarse),
    "lost rows": File("az.csv", layouts.lost_rows, "", "--resample own"),
    "milliseconds apart": File("ba.csv", layouts.millitm),
    "two clocks": File("bb.csv", layouts.two_clocks, "", "--resample own"),
    "angle in degrees": File("bc.csv", layouts.degrees, "--unit q=deg", "", "table.py"),
    "ODrive": File("bd.csv", layouts.turns, "--gain 85", "", "table.py"),
    "robot's joint": File("be.txt", layouts.joint, "--gain 85", "", "table.py"),
}


def run(*arguments: str) -> tuple[int, str]:
    """Exit code and last line on standard error of a command."""
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            symid(list(arguments))
        except SystemExit as end:
            lines = said.getvalue().strip().splitlines()
            return int(end.code or 0), lines[-1] if lines else ""
    return 0, ""


def outcome(name: str, *, diagnosed: bool) -> str:
    file, write, of_import, of_others, axis = FILES[name]
    write(Path(file))
    code, said = run("import", file, "--axis", axis, *shlex.split(of_import), "-o", "map.json")
    if code:
        return f"import: {said}"
    common = [axis, file, "--mapping", "map.json", "--held", "F", *of_others.split()]
    code, said = run("identify", *common, "--json", "found.json")
    if code:
        return f"identify: {said}"
    record = json.loads(Path("found.json").read_text())
    line = f"{100 * (record['physical']['M']['value'] / TRUE['M'] - 1):+6.2f} %  {record['status']:4}"
    if diagnosed:
        code, said = run("diagnose", *common, "--json", "why.json")
        line += f"  diagnose: {said}" if code else f"  {json.loads(Path('why.json').read_text())['verdict']}"
    return line


def main() -> int:
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", default=list(FILES))
    parser.add_argument("--no-diagnosis", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("table.py").write_text(layouts.AXIS_OF_A_TABLE, encoding="utf-8")
        for name in options.names or FILES:
            begin = time.perf_counter()
            line = outcome(name, diagnosed=not options.no_diagnosis)
            print(f"{name:28} {line}  {time.perf_counter() - begin:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
