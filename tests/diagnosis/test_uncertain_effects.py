"""Effects of one size: hardly a block of the log shows one of them alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symid import Log, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.effects import Effect
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection import forward
from symid.diagnosis.selection.backward import backward_elimination
from symid.diagnosis.selection.reselection import reselected
from symid.diagnosis.selection.step import SelectionStep, accepted_of

NAMES = ("payload_change", "force_constant_ripple")
TIME = np.arange(6000) * 1e-3
WAVES = ((0.1, 2.1, 4.0), (0.05, 5.3, 1.7), (0.02, 11.7, 0.3), (0.005, 29.0, 5.1))


def slide() -> Log:
    """58 kg and, from 3.4 s on, 70 % more, moved by a force whose constant varies by 20 % over 27 mm."""
    q = sum(x * np.sin(rate * TIME + phase) for x, rate, phase in WAVES)
    v = sum(x * rate * np.cos(rate * TIME + phase) for x, rate, phase in WAVES)
    a = -sum(x * rate**2 * np.sin(rate * TIME + phase) for x, rate, phase in WAVES)
    force = 58.0 * (1 + 0.7 * (TIME > 3.4)) * a + 100.0 * v + 35.0 * np.sign(v)
    noise = np.random.default_rng(0).standard_normal((2, TIME.size))
    recorded = force / (1 + 0.2 * np.sin(2 * np.pi * q / 0.027 + 0.4))
    return Log("by hand", 0.0, 1e-3, {"q": q + 1e-7 * noise[0], "F": recorded + noise[1]})


def first_step(*names: str) -> tuple[Fit, list[Effect], SelectionStep]:
    """The slide re-identified, effects by their names, and the first step of a search among these."""
    data = data_of(load_axis("rigid_1m"), (joined([slide()]), None), Recording({}, True))
    fit = fitted_axis(*first_state(data.record, {"M": 58.0, "Fv": 100.0, "Fs": 35.0}))
    library = [effect for effect in LIBRARY if effect.name in names]
    return fit, library, forward._selection_step(fit, library, None)


def uncertain(*names: str) -> tuple[SelectionStep, ...]:
    """Steps of the search after a first one whose candidates would not be certain enough."""
    fit, library, first = first_step(*names)
    doubtful = tuple(replace(own, certainty=0.9) for own in first.confirmed)
    first = replace(first, confirmed=doubtful)
    assert not first.accepts
    return backward_elimination(forward._together(fit, first, library, None), library)


def test_two_effects_that_together_explain_a_log_are_found_together() -> None:
    steps = accepted_of(uncertain(*NAMES))
    assert {step.best.key[0] for step in steps} == set(NAMES)
    assert steps[-1].best.fit.mean_square < 0.05 * steps[0].before.mean_square


def test_an_uncertain_effect_that_leaves_a_gap_is_none() -> None:
    assert accepted_of(uncertain("payload_change")) == []


def test_uncertain_effects_after_the_first_are_found_if_together_they_leave_hardly_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a stiffness and cogging, a friction that warms up and an asymmetric one hide in each other's error."""
    fit, library, first = first_step(*NAMES)
    search = forward._selection_step

    def doubtful(*given: Any) -> SelectionStep:
        step = search(*given)
        return replace(step, confirmed=tuple(replace(own, certainty=0.9) for own in step.confirmed))

    monkeypatch.setattr(forward, "_selection_step", doubtful)
    steps = forward._continued(fit, first, library, None)
    assert {step.best.key[0] for step in steps} == set(NAMES)
    left = steps[-1].before  # as if the second effect had explained nothing
    nothing = replace(steps[-1], confirmed=(replace(steps[-1].best, fit=left),))
    assert forward._without_tentative([first, nothing]) == (first,)


def test_an_imitation_beside_another_effect_is_replaced_where_a_clear_gap_stays() -> None:
    fit, library, first = first_step("payload_change", "gain_nonlinearity")
    steps = accepted_of(forward._continued(fit, first, library, None))
    assert [step.best.key[0] for step in steps] == ["payload_change", "gain_nonlinearity"]
    more = [effect for effect in LIBRARY if effect.name in (*NAMES, "gain_nonlinearity")]
    assert {member.placed.key[0] for member in reselected(steps, more)} == set(NAMES)


def test_a_search_goes_on_from_effects_as_probable_as_the_first() -> None:
    """Of a structure with a limited force and a changed mass a bent gain came first, by a hair, and hid both."""
    _, _, step = first_step(*NAMES)
    best, other = step.confirmed
    assert forward._tied(step) == []
    tied = replace(other, gain=best.penalised_gain + other.gain - other.penalised_gain, squares=best.squares)
    (from_other,) = forward._tied(replace(step, confirmed=(best, tied)))
    assert [own.key for own in from_other.confirmed] == [other.key, best.key]
