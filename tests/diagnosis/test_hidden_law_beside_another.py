"""A law of a hidden body is found beside another effect, which comes first."""

from dataclasses import replace

from symid import Cogging, CoulombFriction, load_axis
from symid.data import Log
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import Key, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.hidden_starts import Start
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection import stages
from symid.diagnosis.selection.screening import Candidate
from symid.diagnosis.selection.step import Confirmed, is_clear
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("direct_2m1s")
VALUES = {"Mm": 90.0, "Ms": 300.0, "Ks": 7.4e6, "Fvs": 2000.0, "Fvm": 150.0, "Fsm": 30.0}
IMITATIONS = ("position_dependent_friction", "force_constant_ripple", "periodic_disturbance")


def test_friction_of_a_structure_is_found_beside_cogging_of_the_motor() -> None:
    structure, motor = AXIS.bodies
    laws = CoulombFriction(structure, "Fss"), Cogging(motor, "As", "Ac", pitch=0.02)
    machine = AXIS.with_effect(*laws).with_signal("q2", noise=1e-8).with_signal("Fm", noise=0.3)
    reference = trapezoids(0.1, [0.15, 0.3], acceleration=4.0, jerk=120.0, dwell=0.1, sampling_period=1e-3)
    values = VALUES | {"Fss": 60.0, "As": 150.0, "Ac": 0.0}
    run = simulate(machine, values, reference, tuned_cascade(plant_of(AXIS, VALUES), "q2"), seed=1).log
    log = Log.from_arrays({"q2": run["q2"], "Fm": run["Fm"]}, sampling_period=run.sampling_period)

    nominal = VALUES | {"Fvm": 157.0, "Mm": 94.0}
    library = [effect for effect in LIBRARY if effect.name in ("cogging", "coulomb_friction", *IMITATIONS)]
    found = diagnose(AXIS, log, nominal=nominal, held=True, library=library)
    cogging, friction = found.effects
    assert (cogging.effect, cogging.at) == ("cogging", "motor")
    assert (friction.effect, friction.at) == ("coulomb_friction", "structure")
    assert abs(friction.parameters["Fs"].value - 60.0) < 1.0


def test_friction_of_a_structure_begins_at_the_size_with_the_least_error() -> None:
    structure = AXIS.bodies[0]
    machine = AXIS.with_effect(CoulombFriction(structure, "Fss")).with_signal("q2", noise=1e-8)
    reference = trapezoids(0.1, [0.15, 0.3], acceleration=4.0, jerk=120.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(AXIS, VALUES), "q2")
    log = simulate(machine.with_signal("Fm", noise=0.3), VALUES | {"Fss": 60.0}, reference, loop, seed=1).log
    data = data_of(AXIS, (joined([log]), None), Recording({}, True))
    state, weighting = first_state(data.record, VALUES)
    (coulomb,) = (effect for effect in LIBRARY if effect.name == "coulomb_friction")
    # A projection of a force that has changed its own motion may be far off, either way.
    for projected in (2.0, 60.0, 900.0):
        placed = Placed(coulomb, "structure", (), (projected,), integrated=True)
        begun = Start(state, weighting, placed).best_state()
        assert begun is not None
        assert 25.0 < begun.placed[-1].amplitudes[0] < 150.0


def test_relatives_of_friction_of_a_structure_are_integrated_from_its_values() -> None:
    structure = AXIS.bodies[0]
    machine = AXIS.with_effect(CoulombFriction(structure, "Fss")).with_signal("q2", noise=1e-8)
    reference = trapezoids(0.1, [0.3], acceleration=4.0, jerk=120.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(AXIS, VALUES), "q2")
    log = simulate(machine.with_signal("Fm", noise=0.3), VALUES | {"Fss": 60.0}, reference, loop, seed=1).log
    state, weighting = first_state(data_of(AXIS, (joined([log]), None), Recording({}, True)).record, VALUES)
    fit = Fit(state, weighting)
    effects = {effect.name: effect for effect in LIBRARY}
    plain = Placed(effects["coulomb_friction"], "structure", (), (20.0,))
    refined = Placed(effects["presliding_friction"], "structure", (2e-6,), (1.0,))
    found = [Candidate(placed, 100.0, 100.0) for placed in (plain, refined)]

    def confirmed(placed: Placed) -> dict[Key, Confirmed]:
        own = Fit(with_effects(state, weighting, (placed,)), weighting)
        assert is_clear(own)
        return {placed.key: Confirmed(own, 100.0, 1.0, fit.blocks.squares)}

    (start,) = stages.refinements(fit, found, confirmed(replace(plain, integrated=True)))
    begun_with = start.placed
    assert (begun_with.key, begun_with.amplitudes, begun_with.integrated) == (refined.key, (20.0,), True)
    (start,) = stages.simpler_effects(fit, found, confirmed(refined))
    begun_with = start.placed
    assert (begun_with.key, begun_with.amplitudes, begun_with.integrated) == (plain.key, (1.0,), True)
