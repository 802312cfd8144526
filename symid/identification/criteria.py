"""All thresholds of a status and all factors of intervals, each with its unit, its reason and its source."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """Requirements for the status "ok".

    Figures "on random logs" are those of ``python -m benchmarks.ok_promise`` with seeds that its reports do not use.
    """

    # printed deviation, as part of the value, above which a parameter is not determined: an interval of 95 %
    # then holds zero and twice the value
    undetermined: float = 1.0
    # relative change of a parameter within a log that is called another machine, gain or payload: well above the
    # 10 % by which friction warms up, below the factors of the faults that were tried (20 % and more)
    change: float = 0.15
    # the same of a mass or an inertia, which does not warm up: the one of all rows is off by half of it
    inertia_change: float = 0.1
    # standard deviations of that change; 15 segments make 105 spans, and residuals are not normal
    change_certain: float = 6.0
    # part of the residual's power that separate parameters for the two parts must remove: a change that explains
    # less widens the interval, but is not reported as the fault of the log
    change_explains: float = 0.25
    # the same where the parameters of the rest differ from those of all rows by more than their printed deviations: a
    # gain halved in a part with most of the information on a mass took 0.16; the biased rest of an undamaged log, 0.06
    change_distorts: float = 0.1
    # part of the residual's power that a cubic of the predicted output or of the recorded force, or for a
    # smoothed force the second derivative, must take away; on random undamaged logs a cubic takes 0 to 0.1, on
    # clipped ones 0.4 to 0.9, on softly limited ones 0.6 to 0.99
    nonlinear: float = 0.35
    # standard deviations of such a cubic, and of a drifting gain, that also suffice: undamaged logs show up to 3
    gain_certain: float = 6.0
    nonlinear_output: float = 0.01  # part of the output (rms) that this cubic must be
    # part of the residual's power that a force which is cut off must explain, beside the part of the output: undamaged
    # logs show 0.05, or 0.3 of a residual that is tiny
    cut: float = 0.1
    # part of the largest force by which it falls short, by the cube of the recorded force
    bent_force: float = 0.05
    # the same of its second derivative, for a force that was smoothed: reversals of friction make 1 to 2 % of it
    smoothed_output: float = 0.03
    # part of the residual's power that friction of another course over the speed must explain, where that moves
    # parameters out of their intervals: undamaged random logs show up to 0.09 and EMPS 0.03, Stribeck 0.2 to 0.9
    friction_shape: float = 0.15
    # difference of a force's gain from its mean in either direction: twice as much moves masses by 5 %; EMPS, whose
    # friction is asymmetric, shows 0.014 and 2 to 6 % of its residual's power
    uneven_gain: float = 0.025
    # loss at the cutoff by averaging of one signal and not of another: above about this, parameters of such logs
    # are off by 5 %, since dampers and modes depend on fast motion
    averaged: float = 0.01
    # relative change of a force's gain from the start to the end of a log: a mass is off by half of it (creeps of 10 to
    # 15 %); of logs whose friction warms up as many are ok as with 0.15
    gain_drift: float = 0.1
    # relative error of a sensor's gain: far above what noise in W makes of it, below g for m/s^2
    sensor_gain: float = 0.3
    # standard deviations by which it must exceed what noise makes of it: right gains reach 2.4
    gain_beyond_noise: float = 3.0
    clock_drift: float = 0.5  # samples by which a delay grows over a log
    # clock_certain, clock_explains: standard deviations of that growth by the scatter of few blocks, and part of the
    # residual's power that it takes away: a drift that is less is within the interval. Clean logs with a constant delay
    # reach 3 and 0.02, one whose accelerometer misses half steps of a held force 5 and 0.5, clocks that drift by a
    # sample mostly 10 and more
    clock_certain: float = 8.0
    clock_explains: float = 0.1
    # residual that is left without a lag of first order, as part of that with it: 0.9 to 1 on undamaged random
    # logs
    lagging: float = 0.5
    # the same of a lag that is certain and moves parameters out of their intervals: none on 150 undamaged random logs
    lag_leaves: float = 0.9
    # ac_coupling, ac_coupling_leaves: standard deviations of the corner of a high-pass before the recorder, 3.3 on
    # most undamaged random logs, and residual that is left at most without it, as part of that with it: 0.9997 on one
    # with 5.5 deviations
    ac_coupling: float = 5.0
    ac_coupling_leaves: float = 0.99
    # the same of what a zero-phase low-pass took: on undamaged random logs at least 0.96 is left
    smoothing_leaves: float = 0.75
    # change of a parameter by that where a signal without noise shows a filter
    smoothing_moves: float = 0.025
    # residual, as part of the output, above which an equation is unusable if noise does not explain it: EMPS leaves
    # 0.04, a motor bench 0.1, a double pendulum's shoulder by a model without its weight and viscous friction 0.28
    # (Fc 80 % off), damaged logs 0.3 and more
    worst_fit: float = 0.2
    # such a residual above which lower cutoffs are tried: real machines have unmodelled modes, above
    # what it describes. From there the highest cutoff is taken that leaves little more than the best
    cutoff_fit: float = 0.1
    # cutoff_change, cutoff_certain: relative change of a parameter between two cutoffs, 1.6 times apart, and its size
    # in the larger printed deviation, from which it widens the interval: right undamaged logs show up to 1.8
    cutoff_change: float = 0.05
    cutoff_certain: float = 2.5
    # log_change, log_certain: relative difference of a parameter between one log and all, and its size in the
    # deviation of the one, from which the logs are not of one machine
    log_change: float = 0.05
    log_certain: float = 4.0
    # printed deviation, as part of the value, up to which a result is as precise as wanted; beyond it, other
    # cutoffs are tried: with 0.01 the default of `tuning_grid` was up to 5.4 times as far off as the best, now 1.7
    precise: float = 0.002
    # probability of the relations between minimal parameters, if the model is right, below which it is not: undamaged
    # random logs have 0.01 and more, a flexible axis whose force was averaged 1e-97
    disagreement: float = 1e-9
    # largest ratio of a residual to the noise of the log that counts as explained by it
    noise_explains: float = 3.0
    # the same of a residual that is noise alone. What a controller makes of the encoder's noise looks like a delay, a
    # drifting clock or a filter in it: drawn axes in closed loop, slow ones above all, have 0.4 to 1.07
    noise_alone: float = 1.1
    # largest difference of the gains of redundant sensors: accelerometers are
    # calibrated to a few per cent
    gain: float = 0.05
    # part of all samples that single repeated or zero values in motion may be; 3 samples at least
    dead_share: float = 1e-3
    # half a step of a quantised force, as part of the smallest friction level: truncation shifts the level by that
    # much
    step_share: float = 0.05
    # condition of the scaled observation matrix; above it, 0.001 % noise in a column changes parameters by 100 %
    highest_condition: float = 1e5
    # rows for each parameter below which a residual whose correlation does not decay within the lags that so few
    # rows show gives no deviation: with 16 rows for four parameters, an encoder 0.7 samples late moved Fv by 58 %
    # at 7
    few_rows: int = 10
    # residual beyond which, as part of the output, an equation is worthless: a quarter of the power is unexplained
    worthless_fit: float = 0.5
    # samples by which a force may act after it is recorded, as a hold and the lag of a drive explain, for a mere
    # note
    usual_lag: float = 0.85
    # residual that a smaller delay must leave at most to be reported: slow samples make much of a small part of one
    delay_explains: float = 0.5
    # samples of a delay that explains little: what noise of several sensors leaves looks like one of up to 0.01
    least_delay: float = 0.02
    # relative bias, or change by a delay, above which the status is not "ok"
    large_bias: float = 0.05
    # standard deviations that a change or a bias must have for a status
    bias_certain: float = 2.0
    # growth of a deviation by what a model lacks that is worth a note
    deviation_grown: float = 2.0
    # gain of the differences at the cutoff above which they are not the cause of a bias
    gain_of_differences: float = 0.997
    # part of the residual's power that another lag must leave at most, for the search to begin there
    delay_leaves: float = 0.7
    # times the residual's power at the best lag of the scan that a delay refined from zero may leave
    delay_as_much: float = 1.5
    # times the residual that a late sensor must leave less than a late force
    delay_preference: float = 1.25
    # a delay that is only scanned is known to half a row, taken as three deviations
    rows_a_deviation: float = 6.0
    # residual that must be left at most where all signals but one are moved: noise in W makes 0.97 of it
    delay_together: float = 0.9
    # standard deviations from which a delay is reported
    delay_certain: float = 5.0
    # samples from which a delay is reported, whatever it changes
    delay_noticeable: float = 0.2
    # standard deviations within which a delay is taken for a number of whole or half samples
    delay_round: float = 3.0
    # samples up to which a hold and a lag delay a force: beyond them a clock must leave less than `delay_leaves`
    delay_natural: float = 1.0
    # samples by which the delay of a held force may differ from half a sample
    delay_held: float = 0.1
    # seconds that clocks and drives hardly delay a signal
    delay_long: float = 0.05
    # part of the residual's power that a clock leaves which delays it by more: in a slow motion, friction acts late
    delay_all_but_noise: float = 0.1
    # standard deviations from which an effect, or a change between bands, counts: one of some thirty is tried
    effect_certain: float = 4.0
    # the same for changes of other parameters beside one that is certain: of these, what is beyond counts
    effect_likely: float = 3.0
    # most effects of one log
    most_effects: int = 6
    # part of what the best column explains from which the log does not distinguish another one from it
    effect_as_much: float = 0.5
    # part of a column's power that the model does not explain from which it counts as any other: with less, the
    # effect would be six times as large as what it explains (with 0.01, EMPS unfiltered has Fv within 59 %). One
    # with less, such as a constant force beside the weight of a pendulum, counts where it explains most; three
    # deviations make it certain, as few are imitated (mass on a sine: with four, drag in the noise had Fv off by 30
    # % at 20 deviations)
    independent: float = 0.025
    # size of one with less, as part of the output, beyond which it is no small effect, but noise that is made large
    imitated_largest: float = 0.1
    # part of the residual's power that such a large one must explain
    imitated_explains: float = 0.25
    # relative bias by noise in W, beyond the deviation, from which the residual shows this bias rather than effects
    noisy: float = 0.05
    # segments that the deviation of a change between bands needs
    fewest_segments: int = 6
    # part by which the column of dry friction, which a filter rounds beside rests, differs from its level, rms
    friction_level: float = 0.02
    # rms of a friction's sign beside the other columns, as part of it, below which these are the same force
    friction_alike: float = 1e-3
    # fewest rows per parameter at a lower cutoff: fewer do not show the cause of a fault
    rows_left: int = 50
    # ratio of two residuals, or of two deviations, that count as alike: noise of the output alone makes 1.26 per step
    little_more: float = 1.5
    # worth_another_cutoff, worth_a_lower_cutoff: ratio of deviations below which a higher and a lower cutoff are
    # better. By a lower one EMPS seems to gain a fifth, as fewer rows show less of what its model lacks
    worth_another_cutoff: float = 0.9
    worth_a_lower_cutoff: float = 0.7
    # relative deviation that is small enough: smaller ones are no improvement
    known_well: float = 1e-3
    # consecutive cutoffs without improvement that end the search in their direction
    cutoff_failures: int = 2
    # ratio of the cutoffs that are tried, which changes columns by half at most
    cutoff_step: float = 1.6
    # number of the lower cutoffs that are tried: to a tenth
    lower_cutoffs: int = 5
    # part of a column's power that rounding and filters leave of one that the model does explain
    resolved: float = 1e-4
    # the same of a course without jumps: a constant force beside a pendulum's weight within 0.6 rad has 2e-5
    resolved_smooth: float = 1e-8


CRITERIA = Criteria()
