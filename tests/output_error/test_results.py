"""Least squares, instrumental variables and output error give results that are read alike."""

import numpy as np

from symid import Preparation, identify, load_axis, load_generated, simulate
from symid.instrumental import identify_by_instruments
from symid.output_error import identify_output_error
from symid.simulation import ClosedLoop, chirp, plant_of, tuned_cascade


def test_results_of_all_methods_are_read_alike() -> None:
    axis, truth = load_axis("rigid_1m"), {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
    reference = chirp(0.5, 5.0, 4.0, 0.01, sampling_period=1e-3)
    noisy = axis.with_signal("q", noise=1e-6).with_signal("F", noise=0.01)
    controller = tuned_cascade(plant_of(axis, truth), "q")
    log, other = (simulate(noisy, truth, reference, controller, seed=seed).log for seed in (1, 2))
    model, held = load_generated("rigid_1m"), Preparation(cutoff_hz=40.0, held=True)
    results = (
        identify(model, log, preparation=held),
        identify_by_instruments(model, log, ClosedLoop(axis), preparation=held),
        identify_output_error(axis, model, log, held=True),
    )
    for found in results:
        assert found.status == "ok", found.message
        assert all(abs(found.parameters[name] / truth[name] - 1) < 0.02 for name in truth)
        assert found.covariance.shape == (3, 3)
        assert np.all(found.standard_deviations >= 0.999 * np.sqrt(np.diag(found.covariance)))
        assert found.bias is None or found.bias.total.shape == (3,)
        assert isinstance(found.notes, tuple)
        assert found.predict(other).log == other.source
