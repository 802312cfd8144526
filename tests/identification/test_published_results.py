"""The published EMPS tables digit for digit, and what data/flex_motor_bench/SOURCE.md says of the motor bench."""

import math
from functools import cache
from pathlib import Path

import pytest

from symid import Log, Preparation, identify, load_axis, load_generated, predict, read_axis_log

DATA = Path(__file__).parents[2] / "data"
RECIPE = Preparation(
    cutoff_hz=100.0, filter_force=False, decimation=10, trim=(49, 0), standstill=0.0, difference_order=2
)
SYMMETRIC = {
    "M": ("95.1089", "0.1085"),
    "Fv": ("203.5034", "1.1460"),
    "Fc": ("20.3935", "0.1012"),
    "OF": ("-3.1648", "0.0444"),
}
ASYMMETRIC = {
    "M": ("95.1540", "0.0827"),
    "Fvp": ("166.7061", "1.2326"),
    "Fcp": ("20.1440", "0.1088"),
    "Fvn": ("240.4236", "1.2346"),
    "Fcn": ("20.6277", "0.1091"),
}


def emps_log(name: str) -> Log:
    return read_axis_log(load_axis("emps"), DATA / "emps" / name, columns={"q": "qm"})


@pytest.mark.parametrize(
    ("axis", "published", "norm", "relative", "condition", "deviation"),
    [
        ("emps", SYMMETRIC, "108.7569", "4.0834", "25.9883", "2.1843"),
        ("emps_asymmetric", ASYMMETRIC, "82.8778", "3.1117", "26.0197", "1.6646"),
    ],
)
def test_published_recipe_gives_published_digits(
    axis: str, published: dict[str, tuple[str, str]], norm: str, relative: str, condition: str, deviation: str
) -> None:
    found = identify(load_generated(axis), emps_log("DATA_EMPS.mat"), preparation=RECIPE, ddof=1)
    deviations = found.physical[0].propagated_deviations(found.fit.covariance)
    ours = {
        n: (f"{v:.4f}", f"{s:.4f}")
        for (n, v), s in zip(found.physical_parameters.items(), deviations, strict=True)
    }
    assert ours == published
    (residual,) = found.residuals
    assert found.fit.rows == (2480,)
    assert [
        f"{residual.norm:.4f}",
        f"{100 * residual.relative:.4f}",
        f"{found.fit.condition_number:.4f}",
    ] == [norm, relative, condition]
    assert f"{residual.deviation:.4f}" == deviation


def test_emps_parameters_on_the_other_log_leave_the_published_error() -> None:
    found = identify(load_generated("emps"), emps_log("DATA_EMPS.mat"), preparation=RECIPE, ddof=1)
    (error,) = predict(found, emps_log("DATA_EMPS_PULSES.mat")).residuals
    assert f"{100 * error.relative:.4f}" == "5.9824"
    assert error.norm == pytest.approx(169.4876, abs=2e-4)
    assert f"{error.deviation:.4f}" == "3.4039"


@cache  # a file that may hold objects is read by a process of its own
def bench_log(name: str) -> Log:
    return read_axis_log(
        load_axis("motor_bench"),
        DATA / "flex_motor_bench" / f"Multisine{name}.mat",
        columns={"iq": "iq_adx", "qm": "theta_mx", "ql": "theta_my", "t": "time"},
        units={"t": "us"},
        gains={"ql": -1.0},
    )


@pytest.mark.parametrize("measured", [("qm", "ql"), ("qm",)])
@pytest.mark.parametrize("late", [{}, {"iq": -1.1e-4}])
def test_motor_bench_repeats_and_predicts(measured: tuple[str, ...], late: dict[str, float]) -> None:
    model, preparation = load_generated("motor_bench", measured), Preparation(late=late)
    logs = {name: bench_log(name) for name in ("TypeA", "TypeB")}
    a, b = (identify(model, log, preparation=preparation) for log in logs.values())
    first, second = a.physical_parameters, b.physical_parameters
    for name in ("Jm", "Jl", "Kt"):
        assert abs(second[name] / first[name] - 1) < 0.03
    antiresonance = math.sqrt(first["Kt"] / first["Jl"]) / (2 * math.pi)
    resonance = math.sqrt(first["Kt"] * (1 / first["Jl"] + 1 / first["Jm"])) / (2 * math.pi)
    assert antiresonance == pytest.approx(53, abs=2)
    assert resonance == pytest.approx(77, abs=2)
    assert all(error.relative < 0.1 for error in predict(a, logs["TypeB"]).residuals)


def test_the_time_by_which_the_current_acts_late_makes_all_bench_parameters_physical() -> None:
    model, log = load_generated("motor_bench", ("qm", "ql")), bench_log("TypeA")
    as_recorded = identify(model, log, preparation=Preparation(cutoff_hz=120.0))
    assert as_recorded.status == "not_physical"
    assert "Fvm" in as_recorded.message
    moved = identify(model, log, preparation=Preparation(cutoff_hz=120.0, late={"iq": -1.1e-4}))
    assert moved.status == "ok"
    assert moved.residuals[0].relative < 0.8 * as_recorded.residuals[0].relative
