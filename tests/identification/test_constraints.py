"""Values, bounds and priors of parameters, against least squares written by hand."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from symid import Log, Preparation, Velocity, identify, load_axis
from symid.errors import SettingError
from symid.identification import Identification

M, FV, FS = 5.0, 30.0, 8.0
RAW = Preparation(
    cutoff_hz=200.0, decimation=1, difference_order=10, standstill=0.0, trim=(50, 50), filter_force=False
)


def log_of(seed: int, noise: float = 2.0, friction: float = FV) -> Log:
    """A rigid axis that moves by formula; the force has white noise, the motion none."""
    rng = np.random.default_rng(seed)
    t = np.arange(3000) / 1000
    q = 0.02 * np.sin(9 * t) + 0.01 * np.sin(23 * t)
    v = 0.18 * np.cos(9 * t) + 0.23 * np.cos(23 * t)
    a = -1.62 * np.sin(9 * t) - 5.29 * np.sin(23 * t)
    F = M * a + friction * v + FS * np.sign(v) + noise * rng.standard_normal(t.size)
    return Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)


def rows_of(found: Identification) -> tuple[np.ndarray, np.ndarray]:
    seen = found.observations[0]
    used = seen.valid[0]
    return seen.W[0][used], seen.y[0][used]


def plain(log: Log, **settings: object) -> Identification:
    return identify("rigid_1m", log, preparation=RAW, examine=False, **settings)


def test_a_fixed_mass_is_least_squares_on_the_other_columns() -> None:
    log = log_of(1)
    W, y = rows_of(plain(log))
    by_hand, residual, *_ = np.linalg.lstsq(W[:, 1:], y - W[:, 0] * 5.01, rcond=None)
    found = plain(log, fixed={"M": 5.01})
    assert list(found.physical_parameters) == ["Fv", "Fs"]
    assert np.allclose(found.fit.parameters, by_hand, rtol=1e-9)
    covariance = residual[0] / (y.size - 2) * np.linalg.inv(W[:, 1:].T @ W[:, 1:])
    assert np.allclose(found.fit.covariance, covariance, rtol=1e-6)
    assert found.status == "ok"
    assert any("M is given as 5.01 kg; the log alone says" in note for note in found.notes)


def test_a_known_friction_level_is_taken_off_the_output() -> None:
    log = log_of(2)
    W, y = rows_of(plain(log))
    by_hand, *_ = np.linalg.lstsq(W[:, :2], y - W[:, 2] * FS, rcond=None)
    found = plain(log, fixed={"Fs": FS})
    assert np.allclose(found.fit.parameters, by_hand, rtol=1e-9)


def test_bounds_count_beside_a_parameter_that_no_sensor_used_sees() -> None:
    """The unmeasured tachometer has an unknown gain; a bound above the viscous friction is held all the same."""
    axis = load_axis("rigid_1m")
    tachometer = Velocity("w", axis.bodies[0], gain="g", unit="V")
    scaled = replace(axis, sensors=(*axis.sensors, tachometer))

    def found(**settings: object) -> Identification:
        return identify(
            scaled,
            log_of(1),
            measured=["q"],
            preparation=RAW,
            examine=False,
            bounds={"Fv": (35.0, None)},
            **settings,
        )

    values = found().physical_parameters
    assert values["Fv"] == 35.0
    assert np.isnan(values["g"])
    assert found().status == "contradicted"
    assert found(prior={"g": (2.0, 0.1)}).physical_parameters["g"] == pytest.approx(2.0)


def test_a_prior_is_a_row_more() -> None:
    log, mean, deviation = log_of(3), 5.002, 0.004
    free = plain(log)
    found = plain(log, prior={"M": (mean, deviation)})
    root = np.linalg.cholesky(np.linalg.inv(free.covariance)).T
    rows = np.vstack([root, [1 / deviation, 0, 0]])
    rhs = np.append(root @ free.fit.parameters, mean / deviation)
    by_hand, *_ = np.linalg.lstsq(rows, rhs, rcond=None)
    assert np.allclose(list(found.physical_parameters.values()), by_hand, rtol=1e-9)
    assert np.allclose(found.physical[0].covariance, np.linalg.inv(rows.T @ rows), rtol=1e-6)
    assert np.allclose(
        found.physical[0].propagated(found.covariance), np.linalg.inv(rows.T @ rows), rtol=1e-6
    )


def test_posterior_deviations_are_those_of_repetitions() -> None:
    """Truth and log are drawn: errors divided by posterior deviations have variance 1."""
    rng, ratios = np.random.default_rng(11), []
    for seed in range(60):
        deviation = 0.02
        mean = M + deviation * rng.standard_normal()
        found = plain(log_of(100 + seed, noise=6.0), prior={"M": (mean, deviation)})
        error = np.array(list(found.physical_parameters.values())) - (M, FV, FS)
        ratios.append(error / found.physical[0].standard_deviations)
    variance = np.var(ratios, axis=0)
    assert np.all((variance > 0.6) & (variance < 1.6)), variance


@pytest.mark.parametrize("friction", [-1.0, -6.0])
def test_bounds_are_bounded_least_squares(friction: float) -> None:
    log = log_of(4, noise=10.0, friction=friction)
    free = plain(log)
    bounds = {"Fv": (1.5, None), "M": (None, 10.0), "Fs": (0.0, 100.0)}
    found = plain(log, bounds=bounds)
    root = np.linalg.cholesky(np.linalg.inv(free.covariance)).T
    by_hand = scipy.optimize.lsq_linear(
        root, root @ free.fit.parameters, bounds=([-np.inf, 1.5, 0.0], [10.0, np.inf, 100.0]), method="bvls"
    )
    assert np.allclose(list(found.physical_parameters.values()), by_hand.x, rtol=1e-7)
    assert found.physical_parameters["Fv"] == 1.5
    cost = 2 * by_hand.cost
    (note,) = [note for note in found.notes if "held at its bound" in note]
    assert note.startswith("Fv is held at its bound 1.5 N*s/m")
    assert f"costs {cost:.3g} in chi-square" in note
    # the posterior of Fv is the tail of a normal distribution; the others are as uncertain as this leaves them
    normal, distance = np.linalg.inv(root.T @ root), np.sqrt(cost)
    mean, variance = scipy.stats.truncnorm.stats(distance, np.inf)
    of_bound = normal[1, 1] * (variance + (mean - distance) ** 2)
    assert found.physical[0].standard_deviations[1] == pytest.approx(np.sqrt(of_bound), rel=1e-5)
    slope = normal[:, 1] / normal[1, 1]
    expected = np.diag(normal) - slope**2 * (normal[1, 1] - of_bound)
    assert np.allclose(found.physical[0].standard_deviations, np.sqrt(expected), rtol=1e-5)


def test_a_bound_that_costs_nothing_does_not_make_others_certain() -> None:
    log = log_of(4, noise=10.0)
    free = plain(log)
    low = free.physical_parameters["Fv"] * (1 + 1e-9)
    found = plain(log, bounds={"Fv": (low, None)})
    assert any("held at its bound" in note for note in found.notes)
    assert np.allclose(found.physical[0].standard_deviations, free.physical[0].standard_deviations, rtol=1e-3)


def test_what_contradicts_the_log_is_not_ok() -> None:
    log = log_of(5)
    assert plain(log).status == "ok"
    for knowledge in ({"fixed": {"M": 6.0}}, {"bounds": {"M": (6.0, None)}}, {"prior": {"M": (6.0, 1e-4)}}):
        found = plain(log, **knowledge)
        assert found.status == "contradicted", knowledge
        assert "M is 6 where the log alone says 5" in found.message or "M is 5.99" in found.message


def test_a_negative_friction_is_held_at_zero_and_not_ok() -> None:
    log = log_of(6, noise=0.5, friction=-20.0)
    assert plain(log).status == "not_physical"
    found = plain(log, bounds="physical")
    assert found.physical_parameters["Fv"] == 0.0
    assert found.status == "contradicted"
    examined = identify("rigid_1m", log, preparation=RAW, bounds="physical")
    assert examined.status == "contradicted", examined.message
    assert "Fv is 0 where the log alone says -" in examined.message


def test_bounds_that_do_not_bind_change_nothing() -> None:
    log = log_of(7)
    free, found = plain(log), plain(log, bounds="physical")
    assert np.allclose(
        list(found.physical_parameters.values()), list(free.physical_parameters.values()), rtol=1e-8
    )
    assert found.status == "ok"
    assert not any("bound" in note for note in found.notes)


def test_a_fixed_stiffness_separates_what_one_frequency_does_not() -> None:
    """At one frequency a spring and a mass are one column; with one of them known the other is found."""
    from symid import Axis, Body, Drive, Position, PositionStiffness, ViscousFriction

    table = Body("table", mass="M")
    axis = Axis(
        "sprung",
        (table, ViscousFriction(table, "Fv"), PositionStiffness(table, "k")),
        Drive("F", table),
        (Position("q", table),),
    )
    t, w = np.arange(4000) / 1000, 11.0
    q, v, a = np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)
    rng = np.random.default_rng(0)
    log = Log.from_arrays(
        {"q": q, "F": 5 * a + 3 * v + 200 * q + rng.standard_normal(t.size)}, sampling_period=1e-3
    )
    alone = identify(axis, log, preparation=RAW, examine=False)
    assert alone.status in ("rank_deficient", "poorly_excited", "not_physical")
    found = identify(axis, log, preparation=RAW, fixed={"k": 200.0}, examine=False)
    assert found.physical_parameters["M"] == pytest.approx(5.0, abs=4 * found.physical_deviations[0])
    assert found.physical_deviations[0] < 0.01


@pytest.mark.parametrize(
    ("knowledge", "message"),
    [
        ({"bounds": {"M": (3.0, 2.0)}}, "3 is not below 2"),
        ({"bounds": {"M": (-5.0, -1.0)}}, "M is at least 0 by its declaration, and its bounds say -1"),
        ({"prior": {"Fv": (-3.0, 1.0)}}, "Fv is at least 0 by its declaration, and its prior says"),
        ({"bounds": {"M": 3.0}}, "give a pair of numbers"),
        ({"bounds": "possible"}, "give 'physical'"),
        ({"prior": {"M": (3.0, 0.0)}}, "a deviation above 0"),
        ({"prior": {"M": (3.0, 1e-20)}}, r"finer than numbers are: give the value as known \(`fixed` M=3\)"),
        ({"prior": {"Q": (3.0, 1.0)}}, "'Q' is not an unknown parameter"),
        ({"fixed": {"Q": 3.0}}, "no parameter 'Q'"),
        ({"fixed": {"M": 5.0}, "bounds": {"M": (0.0, 9.0)}}, "its value is known"),
    ],
)
def test_what_is_not_possible_is_refused(knowledge: dict[str, object], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        plain(log_of(0), **knowledge)


def test_all_faults_of_what_is_known_are_told_at_once() -> None:
    with pytest.raises(SettingError) as refused:
        plain(log_of(0), bounds={"M": (3.0, 2.0), "A": (1.0, 2.0)}, prior={"Fv": (1.0, 0.0), "B": (1.0, 1.0)})
    for fault in (
        "bounds of M: 3 is not below 2",
        "the prior of Fv is",
        "'A', 'B' are no unknown parameters",
    ):
        assert fault in str(refused.value)


def test_a_start_that_was_given_is_not_asked_for_again() -> None:
    """Two masses that move as one: fewer minimal than physical parameters."""
    from symid import Axis, Body, Drive, Geared, Position, ViscousFriction

    left = Body("left", mass="Ml")
    right = Body("right", mass="Mr", geared=Geared(to=left, ratio=1.0))
    axis = Axis("pair", (left, right, ViscousFriction(left, "Fv")), Drive("F", left), (Position("q", left),))
    log = log_of(8)
    nominal = {"Ml": 2.0, "Mr": 3.0, "Fv": 30.0}
    found = identify(axis, log, preparation=RAW, nominal=nominal, examine=False)
    assert found.status == "no_physical_parameters"
    assert found.message == (
        "these signals do not determine Ml, Mr, however the axis moves: give one with `fixed` or `prior`, a payload "
        "that is `known` in each of several logs, or add a sensor"
    )
    known = identify(axis, log, preparation=RAW, fixed={"Mr": 3.0}, examine=False)
    assert list(known.physical_parameters) == ["Ml", "Fv"]
