"""An estimate that depends on the cutoff is not that of the machine."""

import numpy as np
import pytest

from symid import Log, Preparation, identify, load_generated
from symid.identification import Identification
from symid.identification.cutoff import disagreements_of
from symid.identification.results.reliability import with_discrepancies


def at(cutoff: float, table: float) -> Identification:
    """A mass that shakes at 1, 1.7 and 6 Hz, at a cutoff; it carries another one on a spring with a mode of 9 Hz."""
    t, draw = np.arange(16_000) / 1000, np.random.default_rng(0)
    w = 2 * np.pi * np.array([1.0, 1.7, 6.0])[:, None]
    q, v, a = (
        (size * np.sin(w * t + shift)) for size, shift in ((-1 / w**2, 0.0), (-1 / w, np.pi / 2), (1.0, 0.0))
    )
    carried = table / (1 - (w / (2 * np.pi * 9)) ** 2)
    F = np.sum((5 + carried) * a + 4 * v, axis=0) + 2 * np.sign(np.sum(v, axis=0))
    q, F = np.sum(q, axis=0) + 1e-7 * draw.standard_normal(t.size), F + 0.1 * draw.standard_normal(t.size)
    log = Log.from_arrays({"q": q, "F": F}, sampling_period=1e-3)
    return identify(
        load_generated("rigid_1m"), log, preparation=Preparation(cutoff_hz=cutoff), examine="bias"
    )


@pytest.mark.parametrize(("table", "seen"), [(0.0, False), (3.0, True)])
def test_a_mass_on_a_spring_makes_the_mass_depend_on_the_cutoff(table: float, seen: bool) -> None:
    """The apparent mass at a frequency far below the mode is that of both, 8 kg; at 12 Hz it is between."""
    found, others = at(12.0, table), [at(cutoff, table) for cutoff in (4.0, 20.0)]
    differences = disagreements_of(found, [*others, found])
    assert bool(differences) == seen
    assert disagreements_of(found, [found]) == ()
    wider = with_discrepancies(found, differences)
    places = list(found.physical_parameters).index("M")
    off = abs(found.physical_parameters["M"] - (5 + table))
    assert (off > 3 * found.physical_deviations[places]) == seen
    assert off < 3 * wider.physical_deviations[places]
