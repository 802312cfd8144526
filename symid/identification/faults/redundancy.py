"""Consistency of redundant sensors, such as an accelerometer and the second derivative of a position."""

from collections.abc import Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import ObservationBlock, corrected_covariance_of_blocks
from symid.identification.criteria import CRITERIA
from symid.identification.rows.excerpts import Excerpt, estimate_of, running_integral
from symid.identification.rows.filtered_signals import filtered
from symid.signal_processing import derivatives

_LEAST_LATE = 0.5
"""Delay between two sensors, in samples, that is reported; a converter takes less."""
_ROUNDS = 8
"""Gauss-Newton iterations; a delay of a fifth of a period converges within them."""
_MOST_LEFT = 0.5
"""Largest share of a difference's power that remains after a delay which is its cause."""


def disagreement_of(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on redundant sensors whose gain or course differs; empty without such sensors.

    The gain of one signal against another lies between its two regressions, whatever noise each has (R. Frisch,
    Statistical Confluence Analysis, Oslo 1934): sensors disagree if 1 is not within these bounds. They disagree too if
    they differ by more than their noise, as they do where one is late.
    """
    for name, terms in model.redundant:
        used = [name, *(signal for signal, _, _ in terms)]
        if not all(signal in part.log.signals for part in parts for signal in used):
            continue
        pairs = [_compared(model, part, name, terms) for part in parts]
        reading, expected = (np.concatenate([pair[k] for pair in pairs]) for k in (0, 1))
        crossed, power = float(reading @ expected), max(float(reading @ reading), 1e-300)
        low, high = sorted((crossed / max(float(expected @ expected), 1e-300), power / (crossed or 1e-300)))
        source = " + ".join(f"derivative {order} of {signal}" for signal, order, _ in terms)
        if low > 1.0 + CRITERIA.gain or high < 1.0 - CRITERIA.gain or crossed <= 0.0:
            return (
                f"{name} is {np.sqrt(max(low * high, 0.0)) * np.sign(crossed):.4g} times the reading of other sensors "
                f"({source}): correct its unit, sign or gain (`units`, `gains`)"
            )
        if late := _samples_late(reading, expected):
            shift = f"{1e3 * abs(late) * parts[0].log.sampling_period:.3g} ms {'later' if late > 0 else 'earlier'}"
            return (
                f"{name} is {shift} than the reading of other sensors ({source}): correct the time of one of them "
                "(`late`), or leave one out of `measured`"
            )
        differs = float(np.sqrt(np.sum((reading - expected) ** 2) / power))
        noise = np.sqrt(np.mean([_noise(part, name, terms) for part in parts]) * reading.size / power)
        if differs > max(CRITERIA.worst_fit, CRITERIA.noise_explains * float(noise)):
            return (
                f"{name} differs from the reading of other sensors ({source}) by {100 * differs:.3g} %, more than "
                "noise does: one of them is late or damaged; correct its time (`late`), or leave it out of `measured`"
            )
    return ""


def _samples_late(reading: FloatArray, expected: FloatArray) -> float:
    """Samples by which a reading is later than expected; 0 if a delay does not explain most of the difference."""
    delay, places = 0.0, np.arange(reading.size)
    for _ in range(_ROUNDS):
        # Gauss-Newton: the derivative of the moved signal by the delay is minus its slope.
        moved = np.interp(places - delay, places, expected)
        slope, differs = np.gradient(moved), reading - moved
        delay -= float(slope @ differs) / max(float(slope @ slope), 1e-300)
    left = float(np.sum((reading - np.interp(places - delay, places, expected)) ** 2))
    is_late = abs(delay) > _LEAST_LATE and left < _MOST_LEFT * float(np.sum((reading - expected) ** 2))
    return delay if is_late else 0.0


def high_pass_of(model: GeneratedModel, parts: Sequence[Excerpt], name: str) -> tuple[float, float] | None:
    """Corner, rad/s, of the high-pass that a sensor has passed by the others, and its deviation; None without one.

    Before the high-pass, a signal x was x + corner * (integral of x), up to a constant.
    """
    terms = next((terms for reading, terms in model.redundant if reading == name), None)
    if terms is None or not all(signal in part.log.signals for part in parts for signal, _, _ in terms):
        return None
    blocks = []
    for k, part in enumerate(parts):
        reading, expected = _compared(model, part, name, terms)
        thin = slice(None, None, part.observation.preparation.decimation or 1)
        sums = running_integral(reading, part.log.sampling_period)
        W, y = np.column_stack([sums, np.ones_like(reading)])[thin], (expected - reading)[thin]
        blocks.append(ObservationBlock(W[None], y[None], np.ones((1, y.size), dtype=bool), equation=k))
    fit = estimate_of(blocks)
    if fit.status != "ok":
        return None
    correlated = corrected_covariance_of_blocks(lambda: blocks, fit)
    return float(fit.solution[0]), float(correlated.standard_deviations[0])


def _compared(
    model: GeneratedModel, part: Excerpt, name: str, terms: Sequence[tuple[str, int, float]]
) -> tuple[FloatArray, FloatArray]:
    """A signal and what it should be, both low-passed as for the estimate, between the trimmed ends."""
    chosen, log = part.observation.preparation, part.log
    used = [name, *(signal for signal, _, _ in terms)]
    moved = {key: x[:] for key, x in filtered(model, log, chosen, 1.0, used).items()}
    before, after = chosen.trim or (0, 0)
    inside = slice(before, log.n_samples - after)
    expected = np.zeros(log.n_samples)
    for signal, order, factor in terms:
        x = moved[signal]
        expected += (
            factor * ([x, *derivatives(x, log.sampling_period, order, accuracy=chosen.difference_order)])[-1]
        )
    return moved[name][inside], expected[inside]


def _noise(part: Excerpt, name: str, terms: Sequence[tuple[str, int, float]]) -> float:
    """Variance of the difference of a signal and what it should be, by white noise up to the cutoff."""
    cutoff = part.observation.preparation.cutoff_hz
    assert cutoff is not None
    return sum(
        factor**2 * part.levels[signal] * (2 * np.pi * cutoff) ** (2 * order) * cutoff / (2 * order + 1)
        for signal, order, factor in ((name, 0, 1.0), *terms)
        if signal in part.levels
    )
