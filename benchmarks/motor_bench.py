"""The flexible motor bench: how well logs A and B agree, for both sets of sensors, and what limits the motor alone.

Rows: the default preparation, several cutoffs, the current taken as acting 0.11 ms later than it is recorded, and the
same logs resampled to 8 times the rate, where central differences are exact up to 250 Hz; averaged over the periods,
where noise is lower by a factor of 4; and what an ideal bench of two bodies would log. "dJm" and so on is
B's parameter less A's in percent of A's (aim 3 %); "antires" and "res" are sqrt(Kt/Jl) and sqrt(Kt (1/Jl + 1/Jm)) over
2 pi of A (in the authors' figures about 53 and 77 Hz); "current" is the error of A's parameters on the current of B
(aim 10 %). An independent route: the frequency responses of both encoders to the current, averaged over
periods, and a nonlinear fit of both with their delays.

Usage: python -m benchmarks.motor_bench
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, signal

import symid
from symid.codegen import GeneratedModel

DATA = Path(__file__).parent.parent / "data" / "flex_motor_bench"
PERIOD = 2500  # samples
SKIPPED = 2  # periods in which the bench settles
LINES = {"A": np.arange(11, 251), "B": np.arange(13, 250, 4)}  # Hz
LATE = {"iq": -1.1e-4}
CUTOFFS = (60.0, 90.0, 120.0, 150.0, 250.0)
RESAMPLED = 8
COMPARED = ("Jm", "Jl", "Kt")
FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def read(which: str) -> symid.Log:
    return symid.read_log(
        DATA / f"MultisineType{which}.mat",
        expected=symid.load_axis("motor_bench").signal_units,
        columns={"iq": "iq_adx", "qm": "theta_mx", "ql": "theta_my", "t": "time"},
        units={"t": "us"},
        gains={"ql": -1.0},
    )


def resampled(log: symid.Log, factor: int) -> symid.Log:
    """Interpolate a log of whole periods by its Fourier series, the drift over the log apart."""
    n = log.n_samples
    fine = np.arange(n * factor) / factor
    signals = {}
    for name in ("iq", "qm", "ql"):
        x = log[name]
        drift = (x[-PERIOD:].mean() - x[:PERIOD].mean()) / (n - PERIOD)
        signals[name] = signal.resample(x - drift * np.arange(n), n * factor) + drift * fine
    return symid.Log(f"{log.source}, resampled", log.start, log.sampling_period / factor, signals)


def averaged(log: symid.Log) -> symid.Log:
    """Replace every period by the mean of the settled ones: noise falls by the root of their number."""
    signals = {}
    for name in ("iq", "qm", "ql"):
        periods = signal.detrend(log[name]).reshape(-1, PERIOD)
        signals[name] = np.tile(periods[SKIPPED:].mean(axis=0), len(periods))
    return symid.Log(f"{log.source}, averaged", log.start, log.sampling_period, signals)


def frequencies(parameters: dict[str, float]) -> tuple[float, float]:
    """Antiresonance and resonance, Hz."""
    Jm, Jl, Kt = (parameters[name] for name in COMPARED)
    antiresonance, resonance = np.sqrt(Kt / Jl), np.sqrt(Kt * (1.0 / Jl + 1.0 / Jm))
    return float(antiresonance / (2.0 * np.pi)), float(resonance / (2.0 * np.pi))


def print_row(label: str, a: dict[str, float], b: dict[str, float], current: float) -> None:
    """Print parameters of A, how far B's are from them, frequencies, and the error on B's current."""
    apart = [100.0 * (b[name] / a[name] - 1.0) for name in COMPARED]
    met = max(map(abs, apart)) <= 3.0 and not current > 0.1
    print(
        f"{label:26}{1e3 * a['Jm']:8.3f}{1e3 * a['Jl']:8.3f}{a['Kt']:8.1f}"
        + "".join(f"{value:8.2f}" for value in apart)
        + "".join(f"{value:9.2f}" for value in frequencies(a))
        + (f"{100.0 * current:9.2f}" if np.isfinite(current) else f"{'':9}")
        + f"   {'met' if met else 'MISSED'}",
        flush=True,
    )


def compare(
    model: GeneratedModel, logs: dict[str, symid.Log], preparation: symid.Preparation, label: str
) -> None:
    found = {which: symid.identify(model, log, preparation=preparation) for which, log in logs.items()}
    chosen = found["A"].observations[0].preparation
    text = f"{chosen.cutoff_hz:g} Hz, 1 of {chosen.decimation}{label}"
    a, b = (found[which].physical_parameters for which in "AB")
    if not (a and b):
        print(
            f"{text:26}{found['A'].status}, {found['B'].status}: {found['A'].message or found['B'].message}"
        )
        return
    residuals = symid.predict(found["A"], logs["B"]).residuals
    print_row(text, a, b, next(r.relative for r in residuals if r.output.lstrip("-") == "iq"))


def frequency_responses(log: symid.Log, lines: NDArray[np.int64]) -> dict[str, ComplexArray]:
    """Responses of both angles to the current at the lines of a multisine, averages over periods."""
    spectra = {}
    for name in ("iq", "qm", "ql"):
        periods = signal.detrend(log[name]).reshape(-1, PERIOD)[SKIPPED:]
        spectra[name] = np.fft.rfft(periods, axis=1).mean(axis=0)[lines]
    return {name: spectra[name] / spectra["iq"] for name in ("qm", "ql")}


def two_bodies(p: dict[str, float], s: ComplexArray) -> dict[str, ComplexArray]:
    """Responses of both angles of two turning bodies to the current, each with a delay."""
    joint = p["Ft"] * s + p["Kt"]
    motor, load = p["Jm"] * s**2 + p["Fvm"] * s + joint, p["Jl"] * s**2 + p["Fvl"] * s + joint
    determinant = motor * load - joint**2
    return {
        "qm": load / determinant * np.exp(-s * p["delay qm"]),
        "ql": joint / determinant * np.exp(-s * p["delay ql"]),
    }


def simulated(log: symid.Log, lines: NDArray[np.int64], fit: dict[str, float]) -> symid.Log:
    """Log of an ideal bench of two bodies for the lines of the same current, without noise."""
    current = np.fft.rfft(log["iq"])
    s = 2j * np.pi * np.fft.rfftfreq(log.n_samples, log.sampling_period)
    excited = lines * round(log.n_samples * log.sampling_period)
    spectra = {"iq": current} | {
        name: g * current[excited] for name, g in two_bodies(fit, s[excited]).items()
    }
    signals = {}
    for name, values in spectra.items():
        spectrum = np.zeros(current.size, dtype=complex)
        spectrum[excited] = values[excited] if name == "iq" else values
        signals[name] = np.fft.irfft(spectrum, log.n_samples)
    return symid.Log("simulated", log.start, log.sampling_period, signals)


def print_mismatch(which: str, log: symid.Log, fit: dict[str, float]) -> None:
    """Print by bands how far the motor's measured response is from that of the two bodies fitted to it."""
    lines = LINES[which]
    ratio = frequency_responses(log, lines)["qm"] / two_bodies(fit, 2j * np.pi * lines)["qm"]
    bands = ((11, 50), (50, 60), (60, 90), (90, 180), (180, 251))
    parts = [
        f"{low}-{high - 1} Hz {np.mean(np.abs(ratio[(lines >= low) & (lines < high)])):.3f}"
        f" +- {np.std(np.abs(ratio[(lines >= low) & (lines < high)])):.3f}"
        for low, high in bands
    ]
    print(f"  {which}: measured response of the motor over that of the fit: {', '.join(parts)}")


def response_fit(log: symid.Log, lines: NDArray[np.int64]) -> dict[str, float]:
    """Fit both responses of two turning bodies, each with a delay, in logarithms."""
    s, measured = 2j * np.pi * lines, frequency_responses(log, lines)
    names = ("Jm", "Fvm", "Kt", "Ft", "Jl", "Fvl", "delay qm", "delay ql")
    start = np.array([5e-3, 0.02, 550.0, 0.05, 4.4e-3, 0.02, 1e-4, 1e-4])

    def residuals(relative: FloatArray) -> FloatArray:
        modelled = two_bodies(dict(zip(names, relative * start, strict=True)), s)
        errors = np.concatenate([np.log(modelled[name] / measured[name]) for name in modelled])
        return np.concatenate([errors.real, (errors.imag + np.pi) % (2.0 * np.pi) - np.pi])

    solution = optimize.least_squares(residuals, np.ones(start.size), loss="soft_l1")
    return {
        **dict(zip(names, solution.x * start, strict=True)),
        "rms": float(np.sqrt(np.mean(residuals(solution.x) ** 2))),
    }


def print_bias() -> None:
    """Say how much central differences lose of the derivatives that the two models need."""
    print("\nwhat repeated central differences leave of a derivative of order n, (sin wT / wT)^n")
    for frequency in (53.0, 77.0, 120.0, 250.0):
        gain, fine = np.sinc(2.0 * frequency / 2500.0), np.sinc(2.0 * frequency / 2500.0 / RESAMPLED)
        print(
            f"  {frequency:5.0f} Hz: n = 2: {gain**2:.4f}   n = 4: {gain**4:.4f}   "
            f"resampled, n = 4: {fine**4:.5f}"
        )


def main() -> None:
    logs = {which: read(which) for which in "AB"}
    fits = {which: response_fit(log, LINES[which]) for which, log in logs.items()}
    ideal = {which: simulated(log, LINES[which], fits["A"]) for which, log in logs.items()}
    quiet = {which: averaged(log) for which, log in logs.items()}
    variants = {
        "as recorded": logs,
        f"resampled to {2.5 * RESAMPLED:g} kHz": {
            which: resampled(log, RESAMPLED) for which, log in logs.items()
        },
        "averaged over periods": quiet,
        "averaged and resampled": {which: resampled(log, RESAMPLED) for which, log in quiet.items()},
        "ideal bench": ideal,
        "ideal bench, resampled": {which: resampled(log, RESAMPLED) for which, log in ideal.items()},
    }
    heading = "".join(f"{word:>8}" for word in ("Jm", "Jl", "Kt", "dJm %", "dJl %", "dKt %"))
    heading += f"{'antires':>9}{'res Hz':>9}{'current %':>10}"
    for measured in (("qm", "ql"), ("qm",)):
        model = symid.load_generated("motor_bench", measured)
        print(f"\nmotor_bench from {' and '.join(measured)} (Jm, Jl in 1e-3 A s^2/rad, Kt in A/rad)")
        for variant, pair in variants.items():
            print(f"{variant:26}{heading}")
            cutoffs = (None, *CUTOFFS) if variant == "as recorded" else CUTOFFS
            for cutoff in cutoffs:
                label = ", default" if cutoff is None else ""
                compare(model, pair, symid.Preparation(cutoff_hz=cutoff, difference_order=2), label)
                compare(
                    model,
                    pair,
                    symid.Preparation(cutoff_hz=cutoff, late=LATE, difference_order=2),
                    f"{label}, late",
                )
    print(f"\nfrequency responses of both encoders, nonlinear fit\n{'':26}{heading}")
    print_row("11 to 250 Hz", fits["A"], fits["B"], float("nan"))
    for which, fit in fits.items():
        delays = ", ".join(f"{name[6:]} {1e3 * fit[name]:.3f} ms" for name in ("delay qm", "delay ql"))
        print(f"  {which}: delays {delays}; rms error {fit['rms']:.3f} (logarithm of the response)")
        print_mismatch(which, logs[which], fit)
    print_bias()


if __name__ == "__main__":
    main()
