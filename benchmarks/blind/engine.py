"""One sampled closed loop of up to three bodies, integrated at 160 kHz by the classical Runge-Kutta method.

Absolute coordinates, forces written out one by one. A joint j lies between the bodies `plus[j]` and `minus[j]` (-1: the
ground); friction and the effects of `laws` act along it. Coulomb friction is exact: a joint that stands is held by
whatever force that takes, up to the level, and slides with a fixed sign until its velocity changes sign.

The controller works at 16 kHz, its force is held. Only `loop` is compiled by itself; what it calls is inlined by numba.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CONTROL_HZ, SUBSTEPS, LOG_TICKS = 16_000, 10, 4
STEP = 1 / (CONTROL_HZ * SUBSTEPS)
ROW = 7  # law, joint and five numbers

# Laws along a joint; the five numbers p of each stand in `laws.ENTRIES`.
(COULOMB, STRIBECK, LOAD_DEPENDENT, POSITION_DEPENDENT, DRIFT, STICKY_ZONE) = range(6)
(VISCOUS, DRAG, OFFSET, STIFFNESS, COGGING, PERIODIC, PRESLIDING) = range(10, 17)
(OUTSIDE, COUPLING, ACCELERATION) = range(20, 23)

# Without counting references to the arrays that are handed on: three times as fast.
_inner = njit(cache=True, error_model="numpy", _nrt=False)


@_inner
def _between(values, plus, minus):
    """Value of the body `plus` relative to that of `minus`."""
    return values[plus] - (values[minus] if minus >= 0 else 0.0)


@_inner
def _push(a, mass, plus, minus, force):
    """A force along a joint, as accelerations of its two bodies."""
    a[plus] += force / mass[plus]
    if minus >= 0:
        a[minus] -= force / mass[minus]


@_inner
def _weigh(inertia, mass, plus, minus):
    """Mass that a force along each joint has to move, written to `inertia`."""
    for j in range(plus.size):
        inertia[j] = 1 / (1 / mass[plus[j]] + (1 / mass[minus[j]] if minus[j] >= 0 else 0.0))


@_inner
def _level(j, sign, x, w, t, F, coulomb, rows):
    """Coulomb level of joint j for motion in the direction of `sign`."""
    level = coulomb[j]
    for i in range(rows.shape[0]):
        if int(rows[i, 1]) != j:
            continue
        law = int(rows[i, 0])
        if law == COULOMB:
            level += rows[i, 2] if sign > 0 else rows[i, 3]
        elif law == STRIBECK:
            level += rows[i, 2] * np.exp(-((w / rows[i, 3]) ** 2))
        elif law == LOAD_DEPENDENT:
            level += rows[i, 2] * abs(F)
        elif law == POSITION_DEPENDENT:
            level += rows[i, 5] + rows[i, 2] * np.sin(2 * np.pi * x / rows[i, 3] + rows[i, 4])
        elif law == DRIFT:
            level += rows[i, 2] * coulomb[j] * (1 - np.exp(-t / rows[i, 3]))
        elif law == STICKY_ZONE and abs(x - rows[i, 3]) < rows[i, 4]:
            level += rows[i, 2]
    return max(level, 0.0)


@_inner
def _bristle(z, w, reach, dt):
    """Dahl's state after dt at the velocity w: z' = w - |w| z / reach."""
    end = reach if w > 0 else -reach
    return end + (z - end) * np.exp(-abs(w) * dt / reach)


@_inner
def _law(law, rows, i, x, w, a, t, z, viscous, outside):
    """Force along a joint by the laws that are no Coulomb level."""
    if law == VISCOUS:
        return -rows[i, 2] * w
    if law == DRAG:
        return -rows[i, 2] * w * abs(w)
    if law == OFFSET:
        return rows[i, 2]
    if law == STIFFNESS:
        return -rows[i, 2] * x
    if law == COGGING:
        return rows[i, 2] * np.sin(2 * np.pi * x / rows[i, 3] + rows[i, 4])
    if law == PERIODIC:
        return rows[i, 2] * np.sin(2 * np.pi * rows[i, 3] * t + rows[i, 4])
    if law == PRESLIDING:
        return -rows[i, 2] * z / rows[i, 3]
    if law == DRIFT:
        return -rows[i, 2] * viscous * w * (1 - np.exp(-t / rows[i, 3]))
    if law == OUTSIDE:
        place = t * CONTROL_HZ / LOG_TICKS
        k = min(int(place), outside.size - 2)
        return rows[i, 2] * (outside[k] + (place - k) * (outside[k + 1] - outside[k]))
    if law == COUPLING:
        return -rows[i, 2] * x * w
    if law == ACCELERATION:
        return -rows[i, 2] * a * abs(a)
    return 0.0


@_inner
def _accelerations(
    x,
    v,
    last,
    t,
    dt,
    F,
    mass,
    plus,
    minus,
    viscous,
    coulomb,
    springs,
    rows,
    rubbing,
    inertia,
    sweeps,
    z,
    outside,
    mode,
    held,
    a,
):
    """Accelerations `a`; `held` receives the Coulomb forces. `mode`: sign of sliding, 0 for a joint that stands."""
    for i in range(springs.shape[0]):
        p, m = int(springs[i, 0]), int(springs[i, 1])
        d, w = _between(x, p, m), _between(v, p, m)
        gap = springs[i, 5]
        stretch = 0.0 if abs(d) <= gap else d - np.sign(d) * gap
        force = springs[i, 2] * stretch + springs[i, 4] * d**3
        if gap == 0 or stretch != 0:
            force += springs[i, 3] * w
        _push(a, mass, p, m, -force)
    for j in range(plus.size):
        d, w = _between(x, plus[j], minus[j]), _between(v, plus[j], minus[j])
        force = -viscous[j] * w
        for i in range(rows.shape[0]):
            if int(rows[i, 1]) == j:
                state = _bristle(z[i], w, rows[i, 3], dt) if int(rows[i, 0]) == PRESLIDING else 0.0
                acceleration = _between(last, plus[j], minus[j])
                force += _law(int(rows[i, 0]), rows, i, d, w, acceleration, t, state, viscous[j], outside)
        _push(a, mass, plus[j], minus[j], force)
    held[:] = 0.0
    for _ in range(sweeps):
        for j in range(plus.size):
            if not rubbing[j]:
                continue
            d, w = _between(x, plus[j], minus[j]), _between(v, plus[j], minus[j])
            need = held[j] - _between(a, plus[j], minus[j]) * inertia[j]
            sign = mode[j] if mode[j] != 0 else (-1.0 if need > 0 else 1.0)
            level = _level(j, sign, d, w, t, F, coulomb, rows)
            force = -sign * level if mode[j] != 0 or abs(need) > level else need
            _push(a, mass, plus[j], minus[j], force - held[j])
            held[j] = force


@_inner
def _settle(v, mass, plus, minus, rubbing, inertia, mode):
    """Joints whose sliding has changed its sign stand; a joint that stands has no velocity."""
    for j in range(plus.size):
        w = _between(v, plus[j], minus[j])
        if not rubbing[j] or mode[j] * w > 0:
            continue
        _push(v, mass, plus[j], minus[j], -w * inertia[j])
        mode[j] = 0.0


@njit(cache=True, error_model="numpy")
def loop(
    masses,
    plus,
    minus,
    viscous,
    coulomb,
    springs,
    rows,
    payload,
    drive,
    actuator,
    ripple,
    outside,
    gains,
    motion,
    noise,
):
    """Positions and accelerations of the bodies at 4 kHz and the commanded force at 16 kHz.

    masses (bodies,), springs (n, 6: plus, minus, k, c, k3, half the gap), rows (n, ROW), payload (body, mass, time),
    drive (plus, minus), actuator (delay in substeps, lag in s, limit, quadratic, cubic), ripple (amplitude, pitch,
    phase), gains (Kpp, Kpv, Kiv, low-pass of the velocity 0 to 1), motion (3, ticks: reference, its velocity, added
    force), noise (2, ticks: of the reading that the controller takes; its step, in the first element).
    """
    mass = masses.copy()
    bodies, ticks = mass.size, motion.shape[1]
    x, v, a, last = np.zeros(bodies), np.zeros(bodies), np.zeros(bodies), np.zeros(bodies)
    xs, vs, moved, gained = np.zeros(bodies), np.zeros(bodies), np.zeros(bodies), np.zeros(bodies)
    mode, held, z = np.zeros(plus.size), np.zeros(plus.size), np.zeros(rows.shape[0])
    samples = ticks // LOG_TICKS
    positions, accelerations = np.zeros((samples, bodies)), np.zeros((samples, bodies))
    command, applied = np.zeros(ticks), np.zeros(ticks)
    integral, previous, speed, force = 0.0, 0.0, 0.0, 0.0
    step, period = noise[1, 0], 1 / CONTROL_HZ
    h, lagged, late = STEP, actuator[1], int(actuator[0])
    decay_half, decay = (np.exp(-h / 2 / lagged), np.exp(-h / lagged)) if lagged > 0 else (0.0, 0.0)
    rubbing, inertia = coulomb > 0, np.zeros(plus.size)
    _weigh(inertia, mass, plus, minus)
    for r in range(rows.shape[0]):
        rubbing[int(rows[r, 1])] |= rows[r, 0] < VISCOUS
    sweeps = 4 if rubbing.sum() > 1 else 1
    changed = False
    for k in range(ticks):
        t = k * period
        if payload[0] >= 0 and not changed and t >= payload[2]:
            mass[int(payload[0])] += payload[1]
            _weigh(inertia, mass, plus, minus)
            changed = True
        reading = _between(x, drive[0], drive[1])
        reading += ripple[0] * np.sin(2 * np.pi * reading / ripple[1] + ripple[2]) + noise[0, k]
        if step > 0:
            reading = np.round(reading / step) * step
        difference = (reading - previous) / period if k > 0 else 0.0
        previous = reading
        speed += gains[3] * (difference - speed)
        error = motion[1, k] + gains[0] * (motion[0, k] - reading) - speed
        integral += period * error
        command[k] = gains[1] * error + gains[2] * integral + motion[2, k]
        u = min(max(command[k], -actuator[2]), actuator[2])
        applied[k] = u * (1 - actuator[3] * abs(u) - actuator[4] * u * u)
        for i in range(SUBSTEPS):
            at = k * SUBSTEPS + i - late
            goal = applied[at // SUBSTEPS] if at >= 0 else 0.0
            start = force if lagged > 0 else goal
            half, end = goal + (start - goal) * decay_half, goal + (start - goal) * decay
            _settle(v, mass, plus, minus, rubbing, inertia, mode)
            for s in range(4):
                f, dt = (start, 0.0) if s == 0 else ((end, h) if s == 3 else (half, h / 2))
                for b in range(bodies):
                    xs[b] = x[b] + dt * vs[b]
                    vs[b] = v[b] + dt * a[b]
                    a[b] = 0.0
                _push(a, mass, drive[0], drive[1], f)
                _accelerations(
                    xs,
                    vs,
                    last,
                    t + dt,
                    dt,
                    f,
                    mass,
                    plus,
                    minus,
                    viscous,
                    coulomb,
                    springs,
                    rows,
                    rubbing,
                    inertia,
                    sweeps,
                    z,
                    outside,
                    mode,
                    held,
                    a,
                )
                if s == 0:
                    last[:] = a
                    for j in range(plus.size):
                        d, pull = _between(x, plus[j], minus[j]), _between(a, plus[j], minus[j])
                        sign = -np.sign(held[j]) if held[j] != 0 else np.sign(pull)
                        if (
                            rubbing[j]
                            and mode[j] == 0
                            and abs(held[j]) >= _level(j, sign, d, 0.0, t, f, coulomb, rows)
                        ):
                            mode[j] = sign  # breaks loose
                    if i == 0 and k % LOG_TICKS == 0 and k // LOG_TICKS < samples:
                        positions[k // LOG_TICKS], accelerations[k // LOG_TICKS] = x, a
                share = h / 6 if s in (0, 3) else h / 3
                for b in range(bodies):
                    moved[b] += share * vs[b]
                    gained[b] += share * a[b]
            for r in range(rows.shape[0]):
                if int(rows[r, 0]) == PRESLIDING:
                    j = int(rows[r, 1])
                    w = _between(v, plus[j], minus[j]) + _between(gained, plus[j], minus[j]) / 2
                    z[r] = _bristle(z[r], w, rows[r, 3], h)
            for b in range(bodies):
                x[b] += moved[b]
                v[b] += gained[b]
                moved[b] = gained[b] = 0.0
            force = end
            t += h
    return positions, accelerations, command
