"""The numbers of one mode as views of the table of all modes, compiled."""

from symid.jit import inner
from symid.simulation.loop_numbers import ModeNumbers


@inner
def numbers_of_mode(modes, m):  # type: ignore[no-untyped-def]  # compiled for arrays
    """Numbers of mode m of a table, as `ModeNumbers`; they share its memory."""
    n_stuck, n_sliding, n_varying = modes.counts[m]
    n, n_drives = modes.drives.shape
    pieces, width = modes.durations.size, 2 * n + n_drives + n_varying + 1
    a = modes.places[m]
    b = a + pieces * (2 * n + n_stuck) * width
    c = b + pieces * (2 * n + n_stuck + n_sliding) * width
    d = c + n * width
    e = d + n_varying
    f = modes.law_places[m]
    numbers = modes.numbers
    return ModeNumbers(
        numbers[a:b].reshape(pieces, 2 * n + n_stuck, width),
        numbers[b:c].reshape(pieces, 2 * n + n_stuck + n_sliding, width),
        numbers[c:d].reshape(n, width),
        modes.law_numbers[f : f + n_stuck],
        modes.law_numbers[f + n_stuck : f + n_stuck + n_varying],
        numbers[d:e],
        numbers[e : e + 2 * n_stuck].reshape(n_stuck, 2),
        modes.is_accelerated,
    )
