"""`derive`, `simulate` and `tune` of any axis."""

from __future__ import annotations

from symid.simulation import simulate as simulate_axis
from symid.symbolic import derive as derive_axis
from symid.tuning import tune as tune_axis
from symid.verbs.axes import of_any_axis

derive = of_any_axis(derive_axis)
simulate = of_any_axis(simulate_axis)
tune = of_any_axis(tune_axis)
