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
    # cutoffs are tried
    precise: float = 0.01
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


CRITERIA = Criteria()
