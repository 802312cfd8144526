"""Thresholds that decide on effects, probabilities and verdicts: units, reasons, and the data that fixed them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """Thresholds that candidates, effects and verdicts have to meet.

    Gains are those of the logarithm of the likelihood on blocks left out. Errors are in multiples of the noise floor,
    mean squares in multiples of its square. *Drawn* are cases of ``python -m benchmarks.blind draw`` whose labels are
    open, *sealed* those of its published tables, *real* the logs of ``python -m benchmarks.diagnosis.real``.
    """

    penalty: float = 4.5  # penalty of a free value: half the logarithm of 8000 rows (Schwarz)
    # gain, less its penalty, that an effect must bring: the best of all places and shapes brings less in noise
    # alone (drawn cases without an effect)
    least_penalised_gain: float = 30.0
    # least_of_usual, many_rows: the same of a law that machines have and first models lack (friction, weight, offset,
    # delay) where rows are few, and the independent rows from which on it must bring as much as others. The logarithm
    # of 800 columns tried and odds of 200 make 12; the rest stands for errors of the models, which gain as rows do: 36
    # rows cannot bring 30 (`benchmarks.diagnosis.others`)
    least_of_usual: float = 12.0
    many_rows: float = 1000.0
    # share of the mean square that the first effect must take away: mismatch of another simulator takes as much
    least_share: float = 0.006
    # share of draws of the blocks in which it must predict better: two sides of a test at 10 %
    least_certainty: float = 0.95
    # the same for an effect that is accepted tentatively, as others may explain the rest (a drawn pair: 0.935, and the
    # third effect of a drawn slide: 0.94)
    least_tentative: float = 0.8
    # least_power, least_of_first: mean square, and share of the first model's, that a further effect must take
    # away (second effects in drawn cases with one)
    least_power: float = 0.06
    least_of_first: float = 0.006
    # share of a clear remaining error that an effect must take away where it takes less than `least_of_first`: a gap of
    # a hundred floors would hide one of several floors (drawn worldly cases; wandering forces lost 0.2)
    least_of_rest: float = 0.3
    # mean square below which no effect takes a model: the level of the noise is known to some percent
    noise: float = 0.8
    most_effects: int = 4  # effects sought: a worldly case has four
    explained: float = 1.4  # mean square at which no further starts are tried
    # share of the mean square above which no candidate has explained it, and costlier starts are tried
    hardly: float = 0.05
    # share of the best candidate's gain by projection from which on another is fitted
    promising: float = 0.15
    # mean square from which on candidates are fitted regardless of their projection, and more than noise is left
    clear_gap: float = 9.0
    # mean square from which on a search that would end goes on from the nominal values (a drawn pair: 7.8)
    resumed: float = 4.0
    # multiple of the least mean square beyond which the fit of another candidate is given up
    give_up: float = 4.0
    # share of the best gain from which on another candidate is accepted in its place, where it is not certain
    beside_best: float = 0.2
    # share of the gain of a friction that varies along the stroke from which on its level comes first (a load: 0.02)
    level_first: float = 0.2
    # other_time, far_other_time: deviations, and share of itself, by which the time of a delay or lag must differ on
    # the validation data to be none: 14 and 0.6 of a robot's joint with an error of its gear (simulated, LuGre)
    other_time: float = 5.0
    far_other_time: float = 0.4
    # share of the gain of a delay from which on a lag is tried in its place, and the other way round
    other_timing: float = 0.3
    # share of the best gain from which on a late reading goes first: readings that do not belong together look
    # like play, friction or compliance (a robot's link encoder, real)
    timing_first: float = 0.6
    tie: float = 2.0  # gain by which the driven body goes first where places are indistinguishable
    # difference of projected gains up to which effects are alike for a log, such as friction and a constant force in
    # motion of one direction, and are all fitted
    alike: float = 0.1
    spoiled: float = 1.5  # factor by which the mean square of an output grows where a candidate goes last
    # share of the gain of Coulomb friction by which its refinement must exceed it: robot joints without friction in
    # their model showed 2 % more for presliding friction, whose reach the log determined badly
    hardly_more: float = 0.03
    # mean square of a fit, relative to that of another fit of the same effect or of a simpler one, below which it is
    # better whatever its cross-validated gain
    far_less: float = 0.5
    # Stribeck velocity, relative to the top speed, beyond which Stribeck friction without Coulomb friction is
    # that (machines without Coulomb friction in their model: 0.4 to 0.9; where drawn cases have it, below 0.2)
    hardly_falls: float = 0.3
    # variation of a friction level along the stroke, relative to its middle, below which the level comes first, its
    # variation after it: robot joints without friction in their model show 0.76 and 0.83 from halves of their logs
    # (real), drawn cases 1
    varies: float = 0.9
    # share of the gain of an effect by which its refinement must gain more to take its place beside others
    refined: float = 0.05
    stands_in: float = 0.5  # least share of the error removed by an effect that its substitute removes
    # factor on the mean square of the whole model that another order of its effects may leave
    as_good: float = 1.25
    # share of the gap by which another order may leave more of it (a drawn worldly case: 0.0006, which was a quarter of
    # the noise left); the error of the other log limits the order too
    hardly_more_left: float = 0.002
    # share of the error that separate parameters of a span must explain for the span to be reported: two machines in
    # one log took 0.85, a gain halved in a fifth of it 0.92, laws that the library lacks 0.6
    changed_span: float = 0.7
    # factor by which a mass may change where the effect found is none of masses: beyond it the axis has been lost
    # (friction by the load explained servo motors away)
    least_inertia: float = 2.0
    # factor by which it may grow beside any effect that does not explain all: a mode of the motor bench hid 9 tenths
    # of the inertia (9.0), one at 1.2 Hz that imitates cogging makes a motor 560 times as heavy (both real)
    heavier: float = 30.0
    least_independent: float = 1e-8  # share of a column, squared, that the others must leave of it
    deviations: float = 2.0  # standard deviations from 0 within which a value does not count as found
    # rms of a missing force relative to the largest of the drive: a spring that holds it may carry more
    largest_force: float = 5.0
    spring_ran_away: float = 1e4  # factor on a stiffness beyond which an effect has made the spring rigid
    # pushes, pushed: force along the motion, relative to the rms of all friction, and share of the motion with
    # it, from which on a friction that differs by direction or place would push the axis (weight of robot joints,
    # real; drawn cases of a force of position times velocity)
    pushes: float = 0.1
    pushed: float = 0.02
    # least fall of the error in a block, relative to the median one, of a disturbance at a mode of the axis: a
    # mode rings with another phase after each move (drawn pairs: disturbances 0.3 or more)
    steady_fall: float = 0.2
    # share of the logged force that must act on the axis: with less, the drive has been explained away
    least_acting: float = 0.5
    # share of the change of a force by a limit or a bent gain that must not be in proportion to the force: of a sine
    # cut to a fifth it is 0.016, of a force of two levels 0 (relay test of a cart, real)
    own_course: float = 0.01
    # least share of its stiffness that a spring loses within its play: a smaller play imitates other nonlinearities
    # (a spring of MuJoCo whose damping the model lacked, 0.08)
    least_play: float = 0.2
    # share of the excess mean square that an effect may leave and have an unusual size: a gain that bends by most of
    # it, a command that an integrator winds up to many times a limit
    explains_all: float = 0.01
    fit_of_noise: float = 1.5  # mean square of a fit that leaves noise alone
    # share of the mean square up to which a fit from another stiffness is the better one: it found the resonance
    other_stiffness: float = 0.1
    ran_away: float = 5.0  # factor by which a mass or a stiffness that is fitted has left where it began
    # share of the mean square up to which a fit from the values found with an effect, but without it, takes the
    # place of the first one
    astray: float = 0.5
    # share of the least mean square of other candidates up to which friction whose motion follows the measured force
    # is taken (drawn worldly cases: loads that stick and slip 0.1, play that friction imitated 0.97)
    follows: float = 0.5
    # samples by which a delay may differ from half a sample and count as a held force
    half_sample: float = 0.12
    # factor on its error to which an effect must lower that of data that took no part in the fit
    falls: float = 0.995
    # factor on the strength of the effect found first from which on another is the stronger one whatever share of the
    # gap it removes alone (a drawn worldly case: 4.4)
    clearly_stronger: float = 3.0
    strength_hz: float = (
        100.0  # band of the force by whose error effects are ranked, Hz: drives are controlled in it
    )
    no_excess: float = 0.05  # mean square above 1 below which there is nothing to explain
    # tempered_share, gain_deviations: gains are divided by 1 + `tempered_share` times the largest, plus
    # `gain_deviations` standard deviations of their difference over the blocks: laws differ a little from those of a
    # real axis (reliability of drawn cases)
    tempered_share: float = 0.006
    gain_deviations: float = 1.0
    # level_spread, level_elsewhere: relative deviation of a friction level from its nominal value, and
    # likelihood, relative to its peak, of one that has changed for other reasons
    level_spread: float = 0.08
    level_elsewhere: float = 0.05
    # steady, of_motion: correlation of position and time from which on a motion is steady, and logarithm of the
    # odds of a force of the time then, where the position explains as much (a motor that turns slowly, real)
    steady: float = 0.99
    of_motion: float = -3.0
    # distance of the quartiles of a load, relative to its median, below which friction with it counts as Coulomb
    # friction by the odds of `of_motion`: 0.07 of a filtered binary torque, 0.8 of a sine
    constant_load: float = 0.2
    driven_bonus: float = 0.3  # logarithm of the odds of the driven body
    # the same of a body whose friction was found too, for an asymmetry of friction (three drawn screws whose load has
    # friction in one direction: asymmetric friction of the motor, and Coulomb friction of the load)
    friction_there: float = 1.0
    # logarithm of the odds of a candidate with values that no machine has: its fit may have gone astray
    refused: float = -2.0
    # probability from which on a candidate counts as indistinguishable from the best
    indistinguishable: float = 0.15
    unlikely: float = 0.1  # probability, at most, of an effect that the validation data do not show
    noise_alone: float = 1.25  # error up to which nothing but noise is left
    # white, coloured: errors that white and wandering noise may leave: the floor is that of white noise, as the
    # signals show it at high frequencies, and a wandering record has several times of it at low ones
    white: float = 1.6
    coloured: float = 6.0
    # error, relative to the force, from which on it is not a slow drift of a record, whatever its course (drawn worldly
    # cases: some percent; a pendulum without its friction, whose error seemed independent of the motion, 0.2)
    coloured_share: float = 0.1
    # error, relative to the force, that a model may leave whatever the noise: the instants of reversals are known
    # to a fraction of a sample (0.13 % was left of exact axes whose friction is half of their force)
    negligible: float = 0.0015
    # worse_motion, worse_with_mode: factor on the error of the simulated motion from which on it speaks against an
    # effect, and against a mode: the right ones left at most 1.11 times as much (the damping of a spring in a log
    # that begins in motion; 1.02 on real logs and thirty of another simulator), a mode in place of friction in one
    # swing of a motor 1.13 to 1.43, a limit of the force of a relay 7 times (cart, not shipped)
    worse_motion: float = 1.5
    worse_with_mode: float = 1.1
    # factor on the error of the re-identified model that nominal values may leave
    nominal_is_good: float = 1.1
    # least_removed, removed_width: share of the excess that an effect must remove to be a cause, and the width of
    # that bound
    least_removed: float = 0.1
    removed_width: float = 0.02
    # covered, covered_width: the same for it to be the true cause and not a substitute for another one (reliability of
    # drawn cases: effects that took a third of the gap were right more often than not)
    covered: float = 0.3
    covered_width: float = 0.1
    # share of the gap that effects may leave and be taken for the causes without a look at laws of other shapes
    hardly_left: float = 0.02
    # share of the error above the noise that a law of any shape leaves by projection beside all effects, up to which it
    # is fitted
    may_outdo: float = 0.9
    # outdone, outdone_width: share of the error above the noise that a law of any shape leaves in the place of the
    # first effect and is then as probable as it, and the width of that bound in its logarithm (drawn cases: right
    # effects 0.8 or more, laws that the library lacks 0.02 and 0.36)
    outdone: float = 0.5
    outdone_width: float = 0.13
    # probability, at most, that such a law is the true one: beside further effects that are not in the model a law of
    # any shape explains some of them too (a dozen drawn cases leave room for one wrong test in seven)
    outdone_at_most: float = 0.85
    # nearly_all, nearly_width: the same of a gap hardly above the floor, whose level is not known better: only a
    # cause takes all of it away (exact axes whose encoder noise passes through a controller)
    nearly_all: float = 0.8
    nearly_width: float = 0.05
    # standard deviation, relative to it, of the share of the gap that an effect takes over from others beside it, or
    # leaves to them (11 drawn worldly cases: 0.07 with that of parts of a log, -0.12 to 0.09)
    taken_over: float = 0.05
    all_of_it: float = 0.1  # share of the gap that may stay where effects explain it and not a part of it
    # largest probability of an effect beside others, as it may explain the error that they leave (of 17 drawn ones
    # with 0.9 and more, 1.00 among them, 13 to 15 were there)
    further_effect: float = 0.95
    # other_order, order_off: factor on the probability of an effect that repeats an integer number of times in a pitch
    # of cogging, which has one order in the library, and relative deviation up to which the number is an integer
    # (cogging of orders 7 and 14, real)
    other_order: float = 0.5
    order_off: float = 0.02
    # impossible_deviations, impossible: deviations below zero from which on a value that cannot be negative speaks
    # against the effects beside it, and their probability at most then (an encoder of a load one sample late, called a
    # delay with 0.96: damping of -71 times its nominal value, 200 deviations; another load read late 10, right effects
    # of drawn cases 3)
    impossible_deviations: float = 6.0
    impossible: float = 0.5
    # absorbed_deviations, absorbed_share: standard deviations and relative change from which on a parameter had
    # absorbed an effect
    absorbed_deviations: float = 3.0
    absorbed_share: float = 0.01


THRESHOLDS = Thresholds()
