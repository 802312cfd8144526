"""Priors of parameters that no log determines alone, beside normal posteriors by hand."""

import math

import numpy as np
import pytest

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Log,
    Position,
    Preparation,
    ViscousFriction,
    identify,
)

RATIO, J, M, FV = 0.0159, 0.004, 60.0, 0.4
PINION = Body("pinion", inertia="J")
TABLE = Body("table", mass="M", geared=Geared(to=PINION, ratio=RATIO))
RACK = Axis(
    "rack", (PINION, TABLE, ViscousFriction(PINION, "Fv")), Drive("T", PINION), (Position("q", PINION),)
)
RAW = Preparation(
    cutoff_hz=200.0, decimation=1, difference_order=10, standstill=0.0, trim=(50, 50), filter_force=False
)


def motion(inertia: float, seed: int, noise: float = 0.02, friction: float = FV, gain: float = 1.0) -> Log:
    """A pinion with an inertia that moves by formula; the torque has white noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(3000) / 1000
    q = 2.0 * np.sin(9 * t) + np.sin(23 * t)
    v = 18.0 * np.cos(9 * t) + 23.0 * np.cos(23 * t)
    a = -162.0 * np.sin(9 * t) - 529.0 * np.sin(23 * t)
    torque = inertia * a + friction * v + noise * rng.standard_normal(t.size)
    return Log.from_arrays({"q": q, "T": torque / gain}, sampling_period=1e-3)


def rack(seed: int = 1) -> Log:
    return motion(J + RATIO**2 * M, seed)


def deviations_of(found) -> dict[str, float]:
    return dict(zip(found.physical_parameters, map(float, found.physical_deviations), strict=True))


def test_one_prior_determines_the_other_parameter() -> None:
    """M = (X - J)/r^2 with a sum X that is known far better than J."""
    found = identify(RACK, rack(), preparation=RAW, prior={"J": (0.0042, 0.0002)}, examine=False)
    whole = found.minimal_parameters["X1"]
    assert found.status == "ok", found.message
    assert found.physical_parameters["J"] == pytest.approx(0.0042, rel=1e-6)
    assert found.physical_parameters["M"] == pytest.approx((whole - 0.0042) / RATIO**2, rel=1e-6)
    deviations = deviations_of(found)
    spread = math.hypot(0.0002, float(found.standard_deviations[0])) / RATIO**2
    assert deviations["J"] == pytest.approx(0.0002, rel=1e-6)
    assert deviations["M"] == pytest.approx(spread, rel=1e-4)
    assert "J, M rest on the prior of J" in found.notes


def test_two_priors_are_weighed_by_their_deviations() -> None:
    prior = {"J": (0.0042, 0.0004), "M": (60.0, 2.0)}
    found = identify(RACK, rack(), preparation=RAW, prior=prior, examine=False)
    # of J speak its own prior, and that of M through the sum
    weights = np.array([0.0004, 2.0 * RATIO**2]) ** -2
    says = np.array([0.0042, found.minimal_parameters["X1"] - RATIO**2 * 60.0])
    assert found.physical_parameters["J"] == pytest.approx(weights @ says / weights.sum(), rel=1e-4)
    assert deviations_of(found)["J"] == pytest.approx(weights.sum() ** -0.5, rel=1e-3)
    against = identify(RACK, rack(), preparation=RAW, prior=prior | {"M": (65.0, 0.5)}, examine=False)
    assert against.status == "contradicted"
    assert "where its prior says" in against.message


def test_a_prior_of_what_the_log_determines_leaves_the_others_open() -> None:
    found = identify(RACK, rack(), preparation=RAW, prior={"Fv": (0.4, 0.01)}, examine=False)
    assert found.status == "no_physical_parameters"
    assert "`fixed` or `prior`" in found.message


def test_bounds_hold_beside_the_prior() -> None:
    prior, bounds = {"J": (0.0042, 0.0002)}, {"M": (None, 59.0)}
    found = identify(RACK, rack(), preparation=RAW, prior=prior, bounds=bounds, examine=False)
    assert found.physical_parameters["M"] == 59.0
    assert found.physical_parameters["J"] == pytest.approx(
        found.minimal_parameters["X1"] - RATIO**2 * 59.0, rel=1e-3
    )


SLIDE = Body("table", mass="M")
LOAD = Body("load", mass="Ml", geared=Geared(to=SLIDE, ratio=1.0))
CURRENT = Axis(
    "current",
    (SLIDE, LOAD, ViscousFriction(SLIDE, "Fv"), CoulombFriction(SLIDE, "Fs")),
    Drive("iq", SLIDE, gain="Kt", unit="A"),
    (Position("q", SLIDE),),
)


def slide(payload: float, seed: int) -> Log:
    log = motion(40.0 + payload, seed, noise=30.0, friction=400.0, gain=55.0)
    return Log.from_arrays(
        {"q": log["q"], "iq": log["T"] + np.sign(np.gradient(log["q"]))}, sampling_period=1e-3
    )


def test_a_prior_and_payloads_are_combined() -> None:
    logs, known = [slide(0.0, 1), slide(12.5, 2)], {"Ml": (0.0, 12.5)}
    alone = identify(CURRENT, logs, known=known, preparation=RAW, examine=False)
    place = list(alone.physical_units).index("Kt")
    own, deviation = alone.physical_parameters["Kt"], float(alone.standard_deviations[place])
    mean = own + deviation
    found = identify(
        CURRENT, logs, known=known, prior={"Kt": (mean, deviation)}, preparation=RAW, examine=False
    )
    assert found.status == "ok", found.message
    assert found.physical_parameters["Kt"] == pytest.approx(own + deviation / 2, rel=1e-4)
    assert found.standard_deviations[place] == pytest.approx(deviation / math.sqrt(2), rel=1e-2)
    far = {"Kt": (own + 20 * deviation, deviation)}
    assert (
        identify(CURRENT, logs, known=known, prior=far, preparation=RAW, examine=False).status
        == "contradicted"
    )
    bounded = identify(
        CURRENT, logs, known=known, bounds={"Kt": (None, own - deviation)}, preparation=RAW, examine=False
    )
    assert bounded.physical_parameters["Kt"] == pytest.approx(own - deviation)


def test_one_payload_and_a_prior_determine_the_constant() -> None:
    logs, known = [slide(12.5, 1), slide(12.5, 2)], {"Ml": (12.5, 12.5)}
    assert (
        identify(CURRENT, logs, known=known, preparation=RAW, examine=False).status
        == "no_physical_parameters"
    )
    found = identify(CURRENT, logs, known=known, prior={"M": (40.0, 0.5)}, preparation=RAW, examine=False)
    assert found.status == "ok", found.message
    # Kt is the whole mass over that in units of the current
    place = list(found.physical_units).index("Kt")
    assert found.physical_parameters["Kt"] == pytest.approx(55.0, rel=0.02)
    assert found.standard_deviations[place] == pytest.approx(55.0 * 0.5 / 52.5, rel=0.05)
