"""The catalogue: each axis as declared to symid, beside its equations of motion written by hand."""

from functools import cache

from axes import chains, gears_and_weights, models, nonlinear, structures
from axes.case import Case
from symid.codegen import GeneratedModel
from symid.codegen.generated_models import compiled
from symid.symbolic import DerivedModel, derive


@cache
def cases() -> dict[str, Case]:
    """All axes of the catalogue that are not chains, by name."""
    modules = (models, gears_and_weights, structures, nonlinear)
    listed = [*(case for module in modules for case in module.CASES), *chains.chain_cases()]
    return {case.name: case for case in listed}


def every_set() -> list[tuple[str, tuple[str, ...]]]:
    """Every axis of the catalogue with every of its sets of sensors."""
    return [(name, chosen) for name, case in cases().items() for chosen in case.sensor_sets]


@cache
def derived(name: str, measured: tuple[str, ...]) -> DerivedModel:
    """Derived model of an axis of the catalogue."""
    return derive(cases()[name].declared, measured)


@cache
def generated(name: str, measured: tuple[str, ...]) -> GeneratedModel:
    """Generated module of an axis of the catalogue, compiled in memory."""
    return compiled(derived(name, measured))
