"""Recursive filters as sections of the second order: their designs, and their run over a signal.

scipy.signal does the same, but its import takes half of the start-up time of a command. Its compiled loop is
used.
"""

import importlib.machinery
import importlib.util
import math
from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.errors import SettingError

SectionLoop = Callable[[FloatArray, FloatArray, FloatArray], None]


def butterworth(order: int, share: float) -> FloatArray:
    """Low-pass of an order with its cutoff at a share of the Nyquist frequency, shape (n_sections, 6) as scipy has it.

    >>> butterworth(2, 0.5).round(4).tolist()
    [[0.2929, 0.5858, 0.2929, 1.0, -0.0, 0.1716]]
    """
    return _low_pass(-np.exp(1j * _angles(order)), 1.0, share)


def chebyshev(order: int, ripple_db: float, share: float) -> FloatArray:
    """Low-pass of type I with its cutoff, where the ripple ends, at a share of the Nyquist frequency.

    >>> chebyshev(2, 3.0, 0.5).round(4).tolist()
    [[0.213, 0.426, 0.213, 1.0, -0.2483, 0.4518]]
    """
    ripple = math.sqrt(10.0 ** (0.1 * ripple_db) - 1.0)
    poles = -np.sinh(math.asinh(1.0 / ripple) / order + 1j * _angles(order))
    return _low_pass(poles, 1.0 if order % 2 else 1.0 / math.sqrt(1.0 + ripple**2), share)


def _angles(order: int) -> FloatArray:
    return np.asarray(np.pi / (2 * order) * np.arange(1 - order, order, 2))


def _low_pass(poles: ComplexArray, gain: float, share: float) -> FloatArray:
    """Sections of the bilinear transform of poles for a cutoff of 1, with a gain at rest; the slowest come last."""
    analogue = math.tan(0.5 * math.pi * share) * poles
    sampled = (1.0 + analogue) / (1.0 - analogue)
    sections = []
    for place in np.argsort(np.abs(sampled), kind="stable"):
        pole = complex(sampled[place])
        if abs(poles[place].imag) < 1e-12:
            sections.append([1.0, 1.0, 0.0, 1.0, -pole.real, 0.0])
        elif poles[place].imag > 0.0:
            sections.append([1.0, 2.0, 1.0, 1.0, -2.0 * pole.real, abs(pole) ** 2])
    found = np.array(sections)
    found[0, :3] *= gain * float(np.prod(np.abs(analogue / (1.0 - analogue))))
    return found


def settled_states(sections: FloatArray) -> FloatArray:
    """States in which a constant input of 1 leaves the sections, shape (n_sections, 2).

    SettingError if a section does not settle.
    """
    states, level = np.empty((len(sections), 2)), 1.0
    for k, (b0, b1, b2, _, a1, a2) in enumerate(sections.tolist()):
        rest = 1.0 + a1 + a2
        if rest <= 0.0:
            raise SettingError(
                "the cutoff is so low against the sampling rate that the filter does not settle: raise it"
            )
        gain = (b0 + b1 + b2) / rest
        states[k] = level * (b1 - a1 * gain + b2 - a2 * gain), level * (b2 - a2 * gain)
        level *= gain
    return states


def run_sections(sections: FloatArray, x: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows of samples filtered by sections of shape (n_sections, 6), and the states behind them.

    The states, of shape (n_rows, n_sections, 2), are those before the first samples.

    >>> section = np.array([[0.5, 0.0, 0.0, 1.0, -0.5, 0.0]])
    >>> run_sections(section, np.array([[1.0, 0.0]]), np.zeros((1, 1, 2)))[0].tolist()
    [[0.5, 0.25]]
    """
    passed, behind = np.array(x, order="C"), np.array(states, order="C")
    _loop()(sections, passed, behind)
    return passed, behind


@cache
def _loop() -> SectionLoop:
    """The compiled loop of scipy, without the package around it; where it has moved, that of the package."""
    package = importlib.util.find_spec("scipy")
    folders = (package.submodule_search_locations if package else None) or []
    for folder, suffix in product(folders, importlib.machinery.EXTENSION_SUFFIXES):
        file = Path(folder) / "signal" / f"_sosfilt{suffix}"
        spec = importlib.util.spec_from_file_location("scipy.signal._sosfilt", file)
        if file.exists() and spec and spec.loader:
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            if loop := getattr(module, "_sosfilt", None):
                return loop  # type: ignore[no-any-return]  # an extension has no types

    import scipy

    def through_package(sections: FloatArray, x: FloatArray, states: FloatArray) -> None:
        x[:], behind = scipy.signal.sosfilt(sections, x, zi=states.swapaxes(0, 1))
        states[:] = behind.swapaxes(0, 1)

    return through_package
