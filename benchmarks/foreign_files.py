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

FILES: dict[str, tuple[str, Callable[[Path], None], str, str]] = {
    "semicolons, German": ("a.csv", plain, "--gain 85", ""),
    "Siemens-like trace, counts": (
        "b.csv",
        counts,
        "--gain 50 --column q=Lageistwert --unit q='5000 counts/mm'",
        "",
    ),
    "TwinCAT Scope": ("c.csv", twincat, "--gain 10", ""),
    "TwinCAT, shared times": ("w.csv", twincat_shared, "--gain 10", ""),
    "ControlDesk CSV": ("d.csv", control_desk, "--gain 85", ""),
    "ControlDesk MAT": ("d.mat", dspace_mat, "", ""),
    "Simulink structure": ("e.mat", simulink, "", ""),
    "MATLAB matrix": ("f.mat", matrix, "--column q=data(:,2) --column F=data(:,3)", ""),
    "MATLAB 7.3 struct": ("g.mat", matlab_7_3, "", ""),
    "HDF5": ("h.h5", hdf5, "--gain 85", ""),
    "TDMS": ("i.tdms", tdms, "", ""),
    "MDF 4": ("j.mf4", mdf4, "", ""),
    "MCAP, JSON": ("k.mcap", mcap, "", ""),
    "MCAP, ROS 2": ("l.mcap", ros2_mcap, "", "--resample own"),
    "ROS 2 bag, SQLite": ("m.db3", ros2_db3, "", "--resample own"),
    "PlotJuggler": ("n.csv", plot_juggler, "", ""),
    "Excel": ("o.xlsx", excel, "", ""),
    "JSON": ("p.json", json_log, "", ""),
    "JSON lines": ("q.jsonl", json_lines, "", ""),
    "Feather": ("r.feather", feather, "", ""),
    "NPZ": ("s.npz", npz, "", ""),
    "CSV.GZ": ("t.csv.gz", gzipped, "", ""),
    "without names": ("u.txt", headerless, "--column q='column 2' --unit q=mm --column F='column 3'", ""),
    "ISO time": ("v.csv", iso, "", ""),
    "Simulink dataset": ("x.mat", simulink_dataset, "", ""),
    "oscilloscope, volts": (
        "y.csv",
        oscilloscope,
        "--column 'q=Kanal A [V]' --unit q='50 mm' --column 'F=Kanal B [mV]' --unit F='0.1 N'",
        "",
    ),
    "Excel, texts": ("z.xlsx", sheet_of_texts, "", ""),
    "two files": ("drive.csv+scope.csv", two_files, "", ""),
}
"""By name: file, writer, options of `symid import` beyond the axis, and those of `identify` and `diagnose`."""


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
    file, write, options, later = FILES[name]
    write(Path(file))
    code, said = run("import", file, "--axis", "rigid_1m", *shlex.split(options), "-o", "map.json")
    if code:
        return f"import: {said}"
    common = ["rigid_1m", file, "--mapping", "map.json", "--held", "F", *later.split()]
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
        for name in options.names or FILES:
            begin = time.perf_counter()
            line = outcome(name, diagnosed=not options.no_diagnosis)
            print(f"{name:28} {line}  {time.perf_counter() - begin:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
