"""Part (d) of `output_error`: the real bench, every n-th sample kept."""

from collections.abc import Iterable, Mapping

import numpy as np

import symid
from benchmarks.motor_bench import read
from symid.identification import Preparation
from symid.output_error import identify_output_error


def row(label: str, values: Iterable[float], width: int = 9, digits: int = 2) -> None:
    print(f"{label:44}" + "".join(f"{value:{width}.{digits}f}" for value in values), flush=True)


def kept(log: symid.Log, every: int, *, mean: bool) -> symid.Log:
    """Every n-th sample; the current there, or its mean over the samples until the next one kept."""
    n = log.n_samples // every
    current = log["iq"][: n * every].reshape(n, every)
    signals = {name: log[name][: n * every : every] for name in ("qm", "ql")}
    signals["iq"] = current.mean(axis=1) if mean else current[:, 0]
    return symid.Log.from_arrays(signals, sampling_period=every * log.sampling_period)


def bench_frequencies(p: Mapping[str, float]) -> list[float]:
    """Antiresonance and resonance, Hz."""
    if not p or not all(p[name] > 0 for name in ("Jm", "Jl", "Kt")):
        return [np.nan, np.nan]
    anti, resonance = p["Kt"] / p["Jl"], p["Kt"] * (1 / p["Jl"] + 1 / p["Jm"])
    return [float(np.sqrt(w) / (2 * np.pi)) for w in (anti, resonance)]


def print_bench(quick: bool) -> None:
    """(d) The real bench, decimated."""
    print(
        "\n(d) real flexible motor bench, log A, every n-th sample kept (inertias in 1e-3 A s^2/rad, Kt in A/rad)"
    )
    print(f"{'':44}" + "".join(f"{name:>9}" for name in ("Jm", "Jl", "Kt", "antires", "res Hz")))
    log = read("A")
    for measured in (("qm",), ("qm", "ql")):
        axis, model = symid.load_axis("motor_bench"), symid.load_generated("motor_bench", measured)
        for every in (10,) if quick else (1, 2, 5, 10, 12, 14):
            for mean in (False,) if quick or every == 1 else (False, True):
                part = kept(log, every, mean=mean)
                late = {"iq": -0.5 * part.sampling_period} if mean else {}
                found = {
                    "wls": symid.identify(model, part, preparation=symid.Preparation(late=late)),
                    "oe": identify_output_error(
                        axis, model, part, preparation=Preparation(held=True if mean else None)
                    ),
                }
                how = ", mean current" if mean else ""
                for method, one in found.items():
                    p = one.physical_parameters
                    values = [1e3 * p["Jm"], 1e3 * p["Jl"], p["Kt"]] if p else [np.nan] * 3
                    label = f"{'+'.join(measured)} n={every} {2500 / every:g} Hz{how}: {method} {one.status}"
                    row(label, [*values, *bench_frequencies(p)])
