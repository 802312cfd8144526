"""Parameter values of the shipped axes, and files of them."""

import json
from pathlib import Path

VALUES = {
    "rigid_1m": {"M": 100, "Fv": 80, "Fs": 40},
    "direct_2m1s": {"Ms": 1700, "Fvs": 24000, "Ks": 1.3e8, "Mm": 460, "Fvm": 104, "Fsm": 98},
    "ballscrew_2m1s": {"Mm": 80, "Fvm": 120, "Fsm": 50, "Kt": 6e6, "Ft": 700, "Ml": 200, "Fvl": 150},
    "direct_3m2s": {
        "Ms": 3899, "Fvs": 3949, "Ks": 1e9, "Mm": 362, "Fvm": 88, "Fsm": 146, "Kl": 4e7, "Fl": 900, "Ml": 60,
    },
    "emps": {"M": 95, "Fv": 203, "Fc": 20, "OF": -3},
    "emps_asymmetric": {"M": 95, "Fvp": 166, "Fcp": 20, "Fvn": 240, "Fcn": 21},
    "motor_bench": {"Jm": 0.0049, "Fvm": 0.02, "Kt": 555, "Ft": 0.009, "Pt": 0, "Jl": 0.0049, "Fvl": 0.1},
}  # fmt: skip


def write_parameters(folder: Path) -> None:
    """One file AXIS.json for each axis."""
    for name, values in VALUES.items():
        (folder / f"{name}.json").write_text(json.dumps(values))
