"""A model without a law of the machine: the law is named, and nothing that only sets astray values right."""

import pytest

from benchmarks.diagnosis.lacking import Case, drawn, is_close
from symid.diagnosis import Diagnosis, diagnose


def found_in(case: Case) -> Diagnosis:
    return diagnose(case.model, case.logs[0], validation=case.logs[1], nominal=case.nominal)


@pytest.mark.parametrize("seed", [6013, 6056])
def test_coulomb_friction_of_an_elastic_machine_is_no_stribeck_friction(seed: int) -> None:
    case = drawn(seed, worldly=False)
    assert case is not None
    assert case.lacks == "coulomb_friction"
    found = found_in(case)
    assert found.effects[0].effect == "coulomb_friction"
    assert is_close(case, found.effects)


def test_values_that_went_astray_are_no_effect() -> None:
    case = drawn(6043, worldly=False)
    assert case is not None
    found = found_in(case)
    assert found.gap.reidentified.rms < 2 * found.gap.noise_floor.rms
    values = {change.name: change.reidentified for change in found.parameters}
    assert values["K"] == pytest.approx(case.machine.values["K"], rel=0.02)
    assert "cogging" not in {effect.effect for effect in found.effects}
