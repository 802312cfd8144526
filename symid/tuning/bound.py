"""The lowest frequency at which an error meets a bound: a scan, then Nelder-Mead on | error - bound |."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from symid.arrays import FloatArray

BoundStatus = Literal["ok", "bound_not_reached", "bound_met_everywhere"]
TuningStatus = Literal[BoundStatus, "not_determined"]
"""Result of a tuning that rests on several bounds."""
RelativeErrors = Mapping[str, float]
"""Relative error of each parameter in percent, with its sign; nan where it is not determined."""
Track = Callable[[Sequence[float]], Iterable[float]]
"""Wrapper of the frequencies of a scan that shows progress, such as a progress bar."""

_TOLERANCE = 1e-3
"""Relative tolerance of the frequency and of the error."""
_MOST_EVALUATIONS = 40  # of the error


@dataclass(frozen=True, eq=False)
class BoundSearch:
    """A frequency chosen so that the largest error meets a bound."""

    frequency_hz: float
    """The chosen frequency."""
    errors: RelativeErrors
    """Error of each parameter there, percent."""
    bound: float
    """Largest error allowed, percent."""
    scanned_hz: FloatArray
    """Frequencies evaluated, rising; shape (n_points,)."""
    scanned_errors: FloatArray
    """The largest error at each, percent; shape (n_points,)."""
    status: BoundStatus
    """Either "ok", "bound_not_reached" (the frequency is that of the smallest error) or "bound_met_everywhere" (it is
    the lowest one scanned)."""

    @property
    def largest_error(self) -> float:
        """Largest error at the chosen frequency, percent."""
        return largest(self.errors)


def largest(errors: RelativeErrors) -> float:
    """Largest magnitude among the errors that are determined; inf if none is.

    >>> largest({"M": -2.0, "Fv": 1.0, "Fs": float("nan")})
    2.0
    """
    return max((abs(e) for e in errors.values() if math.isfinite(e)), default=math.inf)


def lowest_within(
    errors_at: Callable[[float], RelativeErrors],
    frequencies: Sequence[float],
    bound: float,
    track: Track = iter,
) -> BoundSearch:
    """The lowest frequency that meets a bound on the largest error, percent, as [35] and [37] by Nelder-Mead.

    The error is not monotone: it may dip below the bound where errors happen to cancel. The search is therefore
    bracketed by a scan of rising frequencies, Hz; the lowest two neighbours that both meet the bound, or the last
    frequency, count as met, and Nelder-Mead runs in the interval below them.

    >>> found = lowest_within(lambda f: {"M": 100 / f}, [1.0, 10.0, 100.0, 1000.0], 0.5)
    >>> round(found.frequency_hz), found.status
    (200, 'ok')
    """
    seen: dict[float, RelativeErrors] = {}

    def error(frequency: float) -> float:
        if frequency not in seen:
            seen[frequency] = errors_at(frequency)
        return largest(seen[frequency])

    # Errors oscillate with frequency: the bound must hold at a scanned frequency and at the next one, from where the
    # crossing is refined.
    scanned = np.array([error(f) for f in track(frequencies)])
    met = scanned <= bound
    lasting = met & np.append(met[1:], True)
    status: BoundStatus = "ok"
    if not met.any():
        status, chosen = "bound_not_reached", frequencies[int(np.argmin(scanned))]
    elif not lasting.any():
        chosen = frequencies[int(np.argmax(met))]
    elif lasting[0]:
        status, chosen = "bound_met_everywhere", frequencies[0]
    else:
        first = int(np.argmax(lasting))
        chosen = _refined(error, frequencies[first - 1], frequencies[first], bound)
    order = sorted(seen)
    return BoundSearch(
        frequency_hz=chosen,
        errors=seen[chosen],
        bound=bound,
        scanned_hz=np.array(order),
        scanned_errors=np.array([largest(seen[f]) for f in order]),
        status=status,
    )


def _refined(error: Callable[[float], float], above: float, within: float, bound: float) -> float:
    """Nelder-Mead on the logarithms of frequency and error, in an interval that brackets the bound."""

    def distance(logarithm: FloatArray) -> float:
        frequency = float(np.exp(np.clip(logarithm[0], math.log(above), math.log(within))))
        return abs(math.log(min(max(error(frequency), 1e-300), 1e300) / bound))

    # Between two frequencies the error is about a straight line on logarithmic axes: begin where that meets the bound.
    share = 0.5
    if math.isfinite(error(above)):
        share = math.log(error(above) / bound) / math.log(error(above) / max(error(within), 1e-300))
    guess = math.log(above) + min(max(share, 0.02), 0.98) * math.log(within / above)
    simplex = np.array([[guess], [guess + 0.02 * math.log(within / above)]])
    found = scipy.optimize.minimize(
        distance,
        simplex[0],
        method="Nelder-Mead",
        options={
            "initial_simplex": simplex,
            "xatol": _TOLERANCE,
            "fatol": _TOLERANCE,
            "maxfev": _MOST_EVALUATIONS,
        },
    )
    chosen = float(np.exp(np.clip(found.x[0], math.log(above), math.log(within))))
    # A local minimum away from the bound is not a solution; the end of the interval meets the bound.
    return chosen if error(chosen) <= bound * (1.0 + 10 * _TOLERANCE) else within


def tuning_status(searches: Mapping[str, BoundSearch]) -> tuple[TuningStatus, str]:
    """Status of a tuning from those of its searches, by name, with its meaning and cure."""
    for what, search in searches.items():
        if not math.isfinite(search.largest_error):
            return "not_determined", f"no parameter is determined at any {what}: choose a richer trajectory"
    messages = [text for what, search in searches.items() for text in _advice(what, search)]
    errors = [pair for search in searches.values() for pair in search.errors.items()]
    unknown = dict.fromkeys(name for name, error in errors if not math.isfinite(error))
    statuses = {search.status for search in searches.values()}
    if unknown:
        messages.append(
            f"{', '.join(unknown)} have no error (0, or not determined by this motion) and do not count"
        )
    if "bound_not_reached" in statuses:
        return "bound_not_reached", "; ".join(messages)
    if unknown:
        return "not_determined", "; ".join(messages)
    return ("bound_met_everywhere" if "bound_met_everywhere" in statuses else "ok"), "; ".join(messages)


def _advice(what: str, search: BoundSearch) -> Iterator[str]:
    lowest, highest = search.scanned_hz[0], search.scanned_hz[-1]
    if search.status == "bound_not_reached":
        yield (
            f"no {what} from {lowest:.4g} to {highest:.4g} Hz keeps the errors below {search.bound:g} %: the best has "
            f"{search.largest_error:.3g} % at {search.frequency_hz:.4g} Hz; allow more, or choose a richer trajectory"
        )
    elif search.status == "bound_met_everywhere":
        yield (
            f"every {what} from {lowest:.4g} to {highest:.4g} Hz keeps the errors below {search.bound:g} %: the lowest "
            "one that was tried is given"
        )
