"""The published tables of EMPS and those of symid, digit by digit, and results of the default preparation.

Published: Janot, Gautier, Brunot, "Data Set and Reference Models of EMPS" (2019), sections 3.4, 3.5 and 4.2. Their
preparation filters the motion only, and the deviation of the residual uses the number of rows minus 1.

Usage: python -m benchmarks.emps
"""

from pathlib import Path

import symid

DATA = Path(__file__).parent.parent / "data" / "emps"
PUBLISHED_RECIPE = symid.Preparation(
    cutoff_hz=100.0,
    order=4,
    filter_force=False,
    decimation=10,
    trim=(49, 0),
    standstill=0.0,
    difference_order=2,
)
Table = dict[str, float]

SYMMETRIC: Table = {
    "M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "OF": -3.1648,
    "sd M": 0.1085, "sd Fv": 1.1460, "sd Fc": 0.1012, "sd OF": 0.0444,
    "condition": 25.9883, "error norm": 108.7569, "relative %": 4.0834, "std": 2.1843, "rows": 2480,
}  # fmt: skip
ASYMMETRIC: Table = {
    "M": 95.1540, "Fvp": 166.7061, "Fcp": 20.1440, "Fvn": 240.4236, "Fcn": 20.6277,
    "sd M": 0.0827, "sd Fvp": 1.2326, "sd Fcp": 0.1088, "sd Fvn": 1.2346, "sd Fcn": 0.1091,
    "condition": 26.0197, "error norm": 82.8778, "relative %": 3.1117, "std": 1.6646, "rows": 2480,
}  # fmt: skip
PULSES: Table = {"error norm": 169.4876, "relative %": 5.9824, "std": 3.4039}


def read(axis: str, file: str) -> symid.Log:
    """Read a log, the force made of the controller's volts."""
    declared = symid.load_axis(axis)
    assert declared.drive.gain is not None
    return symid.read_log(
        DATA / file,
        expected=declared.signal_units,
        columns={"q": "qm", "F": "vir"},
        units={"F": "N"},
        gains={"F": declared.drive.gain},
    )


def table(found: symid.Identification) -> Table:
    """All figures of a fit by the names of the published tables."""
    names, (residual,) = list(found.model.physical_units), found.residuals
    deviations = {f"sd {n}": float(s) for n, s in zip(names, found.fit.standard_deviations, strict=True)}
    return {
        **dict(zip(names, found.minimal_parameters.values(), strict=True)),
        **deviations,
        "condition": found.fit.condition_number,
        "error norm": residual.norm,
        "relative %": 100.0 * residual.relative,
        "std": residual.deviation,
        "rows": residual.rows,
    }


def cross(found: symid.Identification, log: symid.Log) -> Table:
    """Figures of parameters on another log."""
    (residual,) = symid.predict(found, log).residuals
    return {"error norm": residual.norm, "relative %": 100.0 * residual.relative, "std": residual.deviation}


def print_comparison(title: str, published: Table, ours: Table, default: Table) -> None:
    """Print published, ours, the difference, and the default preparation's."""
    print(f"\n{title:24}{'published':>12}{'ours':>18}{'difference':>12}   digits{'default':>14}")
    for name, value in published.items():
        same = round(ours[name], 4) == value
        print(
            f"{name:24}{value:12.4f}{ours[name]:18.10f}{ours[name] - value:12.1e}   "
            f"{'all' if same else 'NOT ALL':7}{default[name]:13.4f}"
        )


def main() -> None:
    for axis, published in (("emps", SYMMETRIC), ("emps_asymmetric", ASYMMETRIC)):
        model, log, pulses = (
            symid.load_generated(axis),
            read(axis, "DATA_EMPS.mat"),
            read(axis, "DATA_EMPS_PULSES.mat"),
        )
        ours = symid.identify(model, log, preparation=PUBLISHED_RECIPE, ddof=1, examine=False)
        default = symid.identify(model, log)
        print_comparison(f"{axis}, DATA_EMPS", published, table(ours), table(default))
        here, there = cross(ours, pulses), cross(default, pulses)
        if axis == "emps":
            print_comparison("emps, tested on PULSES", PULSES, here, there)
        else:
            print(
                f"tested on PULSES: {here['relative %']:.4f} % (not published), default {there['relative %']:.4f} %"
            )
        chosen = default.observations[0].preparation
        print(
            f"default: {chosen.cutoff_hz:g} Hz on both sides, one row for every {chosen.decimation} samples, "
            f"rows near standstill left out"
        )


if __name__ == "__main__":
    main()
