"""The catalogue: each axis as declared to symid, beside its equations of motion written by hand."""

from functools import cache

from axes.case import SCREW, Case
from axes.gears_and_weights import (
    flexible_pendulum_case,
    inclined_case,
    pendulum_case,
    rack_and_pinion_case,
    rigid_gear_case,
    turning_bench_case,
    vertical_2m1s_case,
)
from axes.models import (
    ballscrew_2m1s_case,
    direct_2m1s_case,
    direct_3m2s_case,
    emps_asymmetric_case,
    emps_case,
    geared_ballscrew_3m2s_case,
    motor_bench_case,
    rigid_case,
)
from axes.nonlinear import friction_in_the_spring_case, hardening_spring_case, ripple_and_drag_case
from axes.structures import (
    accelerometer_only_case,
    both_ends_case,
    parallel_masses_case,
    redundant_sensors_case,
    single_letters_case,
    triangle_case,
    two_springs_case,
)
from symid.codegen import GeneratedModel
from symid.codegen.generated_models import compiled
from symid.symbolic import DerivedModel, derive


@cache
def cases() -> dict[str, Case]:
    """All axes of the catalogue that are not chains, by name."""
    from axes.chains import chain_cases

    made = (
        rigid_case(),
        direct_2m1s_case(),
        ballscrew_2m1s_case(),
        direct_3m2s_case(),
        emps_case(),
        emps_asymmetric_case(),
        motor_bench_case(),
        geared_ballscrew_3m2s_case(),
        rigid_gear_case("reduction_gear", 0.2),
        rigid_gear_case("reversing_gear", -SCREW),
        rigid_gear_case("overdrive_gear", 2),
        rack_and_pinion_case(),
        vertical_2m1s_case(),
        inclined_case(),
        pendulum_case(),
        flexible_pendulum_case(),
        turning_bench_case(),
        two_springs_case(),
        triangle_case(),
        both_ends_case(),
        redundant_sensors_case(),
        accelerometer_only_case(),
        friction_in_the_spring_case(),
        hardening_spring_case(),
        ripple_and_drag_case(),
        parallel_masses_case(),
        single_letters_case(),
        *chain_cases(),
    )
    return {case.name: case for case in made}


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
