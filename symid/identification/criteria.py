"""Every number that decides on a status or widens an interval, with its unit, its reason, and what fixed it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """Requirements for the status "ok".

    Figures "on random logs" are those of ``python -m benchmarks.ok_promise`` with seeds that its reports do not use.

    Parameters
    ----------
    undetermined : float
        Printed deviation, as part of the value, from which on a parameter is not determined: an interval of 95 % then
        holds zero and twice the value.
    change : float
        Relative change of a parameter within a log that is called another machine, gain or payload: well above the
        10 % by which friction warms up, below the factors of the faults that were tried (20 % and more).
    change_certain : float
        Standard deviations of that change; 15 segments make 105 spans, and residuals are not normal.
    change_explains : float
        Part of the residual's power that parameters of their own for the two parts must take away: a change that
        explains less is widened into the interval, but is not what is wrong with the log.
    nonlinear : float
        Part of the residual's power that a cubic of the predicted output or of the recorded force, or for a smoothed
        force the second derivative, must take away; on random undamaged logs a cubic takes 0 to 0.1, on clipped ones
        0.4 to 0.9, on softly limited ones 0.6 to 0.99.
    gain_certain : float
        Standard deviations of such a cubic, and of a drifting gain, that are as good: undamaged logs show up to 3.
    nonlinear_output : float
        Part of the output (rms) that this cubic must be.
    bent_force : float
        Part of the largest force by which it falls short, as the cube of the recorded force tells.
    smoothed_output : float
        The same of its second derivative, for a force that was smoothed: reversals of friction make 1 to 2 % of it.
    averaged : float
        Part that a mean takes from one signal at the cutoff, and from another not: sensors and forces of such logs are
        off by 5 % from about there on, since dampers and modes hang on what is fast.
    gain_drift : float
        Relative change of a force's gain from begin to end of a log: well above what 10 % of warm friction make of it.
    sensor_gain : float
        Relative error of a sensor's gain: far above what noise in W makes of it, below g for m/s^2.
    clock_drift : float
        Samples by which a delay grows over a log.
    clock_certain, clock_explains : float
        Standard deviations of that growth, and part of the residual's power that it takes away: a drift that is less is
        within the interval.
    lagging : float
        Residual that is left without a lag of first order, as part of that with it: 0.9 to 1 on undamaged random logs.
    worst_fit : float
        Residual, as part of the output, beyond which an equation says nothing where noise does not explain it: shares
        of damaged logs start there, EMPS leaves 0.04, a motor bench 0.1.
    cutoff_fit : float
        Such a residual from which on lower cutoffs are tried: real machines have modes that the model lacks, above
        what it describes. From there the highest cutoff is taken that leaves little more than the best.
    precise : float
        Printed deviation, as part of the value, up to which a result is as precise as wanted; beyond it, other cutoffs
        are tried.
    noise_explains : float
        Times the noise found in a log that a residual may be and count as explained.
    gain : float
        By how much the gain of a sensor may differ from that of sensors that it repeats: accelerometers are calibrated
        to a few per cent.
    dead_share : float
        Part of all samples that single repeated or zero values in motion may be; 3 samples at least.
    step_share : float
        Half a step of a quantised force, as part of the smallest friction level: a truncated force moves it by so much.
    """

    undetermined: float = 1.0
    change: float = 0.15
    change_certain: float = 6.0
    change_explains: float = 0.25
    nonlinear: float = 0.35
    gain_certain: float = 6.0
    nonlinear_output: float = 0.01
    bent_force: float = 0.05
    smoothed_output: float = 0.03
    averaged: float = 0.01
    gain_drift: float = 0.15
    sensor_gain: float = 0.3
    clock_drift: float = 0.5
    clock_certain: float = 3.5
    clock_explains: float = 0.1
    lagging: float = 0.5
    worst_fit: float = 0.3
    cutoff_fit: float = 0.1
    precise: float = 0.05
    noise_explains: float = 3.0
    gain: float = 0.05
    dead_share: float = 1e-3
    step_share: float = 0.05


CRITERIA = Criteria()
