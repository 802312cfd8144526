"""Aliasing: motion that reaches the Nyquist frequency, so that faster motion was folded into the band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symid.codegen import GeneratedModel
from symid.data.filters.density import NOISE_FROM, explained_power, mean_power, segment_spectra
from symid.identification.rows.excerpts import Excerpt

_SHARE = 0.1
"""Part of a sensor's power above it; an accelerometer's noise of 2 % of the rms signal makes 1e-4 of it."""
_COHERENT = 0.8
"""Share of a force's power there that is linear in the sensors, in the median: noise is not."""
_SEGMENTS, _LONGEST = 16, 1024  # segments at least, and samples of one at most


def folding_of(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a sensor with motion up to half the sampling frequency; empty without one.

    A controller makes a force of an encoder's noise, so that the two are coherent up to there in a sound log too: it is
    the share of the power that decides. As a rule accelerometers show it.
    """
    for part in parts:
        length = max(16, min(_LONGEST, part.log.n_samples // _SEGMENTS))
        motion = [name for name in model.highest_derivatives if name not in model.forces]
        sensors = {name: segment_spectra(part.log[name][None], length) for name in motion}
        upper = np.arange(length // 2 + 1) > NOISE_FROM * length
        power = {name: mean_power(x) for name, x in sensors.items()}
        shares = {name: float(p[upper].sum()) / max(float(p.sum()), 1e-300) for name, p in power.items()}
        name = max(shares, key=shares.__getitem__)
        if shares[name] < _SHARE:
            continue
        for force in model.forces:
            spectra = segment_spectra(part.log[force][None], length)
            seen = explained_power(spectra, np.stack(list(sensors.values())))
            if np.median((seen / np.maximum(mean_power(spectra), 1e-300))[upper]) > _COHERENT:
                return (
                    f"{name} has {100 * shares[name]:.2g} % of its power above 0.7 of half the sampling frequency, and "
                    f"{force} goes with it: faster motion is folded into the log; record faster, or filter all signals "
                    "alike before sampling"
                )
    return ""
