"""Foreign logs: MATLAB, a CSV with foreign headers, a drive trace in mm and percent of rated torque."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import scipy

from symid import Log, identify, load_axis, load_generated, read_axis_log, simulate
from symid.data import foreign_columns, guessed_layout, open_table
from symid.identification import guessed_mapping, stated_period
from symid.simulation import plant_of, trapezoids, tuned_cascade

RATED = 850.0  # N at 100 % of the rated torque, from the motor's data sheet and the lead
TRUE = {"M": 120.0, "Fv": 300.0, "Fs": 60.0}


def recorded() -> Log:
    """A run of a rigid axis at 2 kHz."""
    axis = load_axis("rigid_1m").with_signal("q", noise=1e-8)
    reference = trapezoids(
        [0.2], [0.05, 0.2, 0.5], acceleration=5.0, jerk=200.0, dwell=0.1, sampling_period=5e-4
    )
    return simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "q")).log


def write_matlab(log: Log, file: Path) -> None:
    """Variables with foreign names, in mm and N."""
    scipy.io.savemat(file, {"time_s": log.time, "x_mm": 1e3 * log["q"], "force": log["F"]})


def write_csv(log: Log, file: Path) -> None:
    """Names and units as a German spreadsheet has them: semicolons, decimal commas, milliseconds."""
    rows = np.stack([1e3 * log.time, 1e3 * log["q"], log["F"]], axis=1)
    lines = ["Zeit [ms];Istposition [mm];Kraft [N]"]
    lines += [";".join(f"{x:.9g}".replace(".", ",") for x in row) for row in rows]
    file.write_text("\n".join(lines), encoding="cp1252")


def write_trace(log: Log, file: Path) -> None:
    """A drive trace: what it is above, no column of the time, mm, and percent of the rated torque."""
    above = ["Trace export", "Drive;Axis X;SERVO_03", "Sample time;0.5 ms", "Trigger;immediate", ""]
    rows = np.stack([1e3 * log["reference"], 1e3 * log["q"], 100 / RATED * log["F"]], axis=1)
    lines = [*above, "Position setpoint;Actual position;Actual torque", "mm;mm;%"]
    lines += [";".join(f"{x:.7f}" for x in row) for row in rows]
    file.write_text("\r\n".join(lines), encoding="utf-16")


def print_found(log: Log, what: str) -> None:
    """Parameters from a log."""
    axis = load_axis("rigid_1m")
    found = identify(load_generated(axis), log).physical_parameters
    print(f"{what}: {', '.join(f'{name} {value:.1f}' for name, value in found.items())}")


def main() -> None:
    """Read the same run from three files: two whose columns we name, one that is looked at first."""
    axis, log = load_axis("rigid_1m"), recorded()
    with TemporaryDirectory() as folder:
        mat, csv, trace = (Path(folder) / name for name in ("run.mat", "run.csv", "trace.csv"))
        write_matlab(log, mat)
        by_name = {"t": "time_s", "q": "x_mm", "F": "force"}
        print_found(read_axis_log(axis, mat, columns=by_name, units={"q": "mm"}), "MATLAB")
        write_csv(log, csv)
        by_name = {"t": "Zeit", "q": "Istposition", "F": "Kraft"}
        print_found(read_axis_log(axis, csv, columns=by_name), "CSV")
        write_trace(log, trace)
        layout = guessed_layout(trace)
        columns = foreign_columns(open_table(trace, layout))
        period = stated_period(trace, layout)
        mapping = guessed_mapping(axis, columns, layout=layout, sampling_period=period, rated=RATED)
        print(json.dumps(dict(mapping.columns), indent=2))
        read = read_axis_log(
            axis,
            trace,
            columns=mapping.columns,
            units=mapping.units,
            gains=mapping.gains,
            layout=layout,
            sampling_period=period,
        )
        print_found(read, "trace")


if __name__ == "__main__":
    main()
