"""Least squares, instrumental variables and output error give results that are read alike."""

import numpy as np
import pytest

from symid import (
    InstrumentalVariables,
    OrdinaryLeastSquares,
    OutputError,
    Preparation,
    WeightedLeastSquares,
    identify,
    load_axis,
    load_generated,
    simulate,
)
from symid.errors import SettingError
from symid.identification import IdentificationResult
from symid.simulation import ClosedLoop, chirp, plant_of, tuned_cascade


def test_results_of_all_methods_are_read_alike() -> None:
    axis, truth = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    reference = chirp(0.5, 5.0, 4.0, 0.01, sampling_period=1e-3)
    noisy = axis.with_signal("q", noise=1e-6).with_signal("F", noise=0.01)
    controller = tuned_cascade(plant_of(axis, truth), "q")
    log, other = (simulate(noisy, truth, reference, controller, seed=seed).log for seed in (1, 2))
    held, loop = Preparation(cutoff_hz=40.0, held=True), ClosedLoop(axis, controller)
    for method in ("wls", "ols", "iv", "oe"):
        found = identify("rigid_1m", log, method=method, preparation=held)
        assert isinstance(found, IdentificationResult)
        assert found.status == "ok", found.message
        assert all(abs(found.parameters[name] / truth[name] - 1) < 0.02 for name in truth)
        assert found.covariance.shape == (3, 3)
        assert np.all(found.standard_deviations >= 0.999 * np.sqrt(np.diag(found.covariance)))
        assert found.bias is None or found.bias.total.shape == (3,)
        assert isinstance(found.notes, tuple)
        predicted = found.predict(other)
        assert predicted.log == other.source
        assert predicted.residuals[0].relative < 0.02
        framed = found.predict(other.to_frame())
        assert framed.residuals[0].rms == pytest.approx(predicted.residuals[0].rms, rel=1e-6)
    model = load_generated("rigid_1m")
    for chosen in (InstrumentalVariables(loop=loop), OutputError(loop=loop)):  # under the known controller
        known = identify(model, log, method=chosen, preparation=held, fixed={"M": 5.0})
        assert list(known.parameters) == ["Fv", "Fs"]
        assert abs(known.parameters["Fs"] - 2.0) < 0.02


def test_a_method_holds_the_settings_that_are_else_given_beside_its_name() -> None:
    t = 1e-3 * np.arange(2000)
    force = 5 * -81 * np.sin(9 * t) + 9 * np.cos(9 * t) + 2 * np.sign(np.cos(9 * t)) + 0.1 * np.sin(70 * t)
    log = {"t": t, "q": np.sin(9 * t), "F": force}
    prior = {"M": (5.2, 1e-3)}
    for name, method in (("wls", WeightedLeastSquares), ("ols", OrdinaryLeastSquares)):
        by_name = identify("rigid_1m", log, method=name, ddof=900, bounds="physical", prior=prior)
        found = identify("rigid_1m", log, method=method(ddof=900, bounds="physical", prior=prior))
        assert found.fit.method == name
        assert found.status == by_name.status == "contradicted"
        assert found.physical_parameters == by_name.physical_parameters
        assert np.array_equal(found.physical_deviations, by_name.physical_deviations)
        assert "contradict" in found.message


@pytest.mark.parametrize(
    ("method", "setting"),
    [
        ("oe", {"bounds": "physical"}),
        ("oe", {"prior": {"M": (5.0, 1.0)}}),
        ("iv", {"ddof": 3}),
        ("wls", {"loop": ClosedLoop(load_axis("rigid_1m"))}),
    ],
)
def test_a_setting_that_a_method_does_not_have_is_refused(method: str, setting: dict[str, object]) -> None:
    with pytest.raises(SettingError, match=f"{next(iter(setting))} is not possible with method '{method}'"):
        identify("rigid_1m", {"t": [0.0]}, method=method, **setting)
    with pytest.raises(SettingError, match="no method 'ml': choose from wls, ols, iv, oe"):
        identify("rigid_1m", {"t": [0.0]}, method="ml")
    with pytest.raises(SettingError, match="known is not possible with OutputError"):
        identify("rigid_1m", {"t": [0.0]}, method=OutputError(), known={"M": [5.0]})
    with pytest.raises(SettingError, match=r"give OutputError\(loop=...\)"):
        identify("rigid_1m", {"t": [0.0]}, method=OutputError(), loop=ClosedLoop(load_axis("rigid_1m")))
