"""One sampled closed loop of up to three bodies, integrated at 160 kHz by the classical Runge-Kutta method.

Absolute coordinates, forces written out one by one. A joint j lies between the bodies `plus[j]` and `minus[j]` (-1: the
ground); friction and the effects of `laws` act along it. Coulomb friction is exact: a joint that stands is held by
whatever force that takes, up to the level, and slides with a fixed sign until its velocity changes sign.

The controller works at 16 kHz, its force is held. Only `loop` is compiled by itself; what it calls is inlined by numba.
"""

import numpy as np
from numba import njit

CONTROL_HZ, SUBSTEPS, LOG_TICKS = 16_000, 10, 4
STEP = 1 / (CONTROL_HZ * SUBSTEPS)
ROW = 7  # law, joint and five numbers

# Laws along a joint; the five numbers p of each stand in `laws.ENTRIES`.
(COULOMB, STRIBECK, LOAD_DEPENDENT, POSITION_DEPENDENT, DRIFT, STICKY_ZONE) = range(6)
(VISCOUS, DRAG, OFFSET, STIFFNESS, COGGING, PERIODIC, PRESLIDING) = range(10, 17)
(OUTSIDE, COUPLED, ACCELERATION, FORCE_CONSTANT, CUBIC, ROOT) = range(20, 26)

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
def _level(j, sign, x, w, t, F, plant):
    """Coulomb level of joint j for motion in the direction of `sign`."""
    coulomb, rows = plant[4], plant[6]
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
def _law(law, rows, i, x, w, a, t, F, z, viscous, outside):
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
    if law == COUPLED:
        return -rows[i, 2] * x * a
    if law == CUBIC:
        return -rows[i, 2] * x**3
    if law == ROOT:
        return -rows[i, 2] * np.sign(w) * np.sqrt(abs(w))
    if law == FORCE_CONSTANT:
        return -rows[i, 2] * F * np.sin(2 * np.pi * x / rows[i, 3] + rows[i, 4])
    if law == ACCELERATION:
        return -rows[i, 2] * a * abs(a)
    return 0.0


@_inner
def _springs(x, v, plant, a):
    """Accelerations by springs, stiffening or with a gap; in the gap there is no damping."""
    mass, springs = plant[0], plant[5]
    for i in range(springs.shape[0]):
        p, m = int(springs[i, 0]), int(springs[i, 1])
        d, w, gap = _between(x, p, m), _between(v, p, m), springs[i, 5]
        stretch = 0.0 if abs(d) <= gap else d - np.sign(d) * gap
        force = springs[i, 2] * stretch + springs[i, 4] * d**3
        if gap == 0 or stretch != 0:
            force += springs[i, 3] * w
        _push(a, mass, p, m, -force)


@_inner
def _joints(x, v, t, dt, F, plant, memory, a):
    """Accelerations by viscous friction and the laws along the joints that are no Coulomb level."""
    mass, plus, minus, viscous, _, _, rows, outside = plant[:8]
    last, z = memory[2], memory[3]
    for j in range(plus.size):
        d, w = _between(x, plus[j], minus[j]), _between(v, plus[j], minus[j])
        force = -viscous[j] * w
        for i in range(rows.shape[0]):
            if int(rows[i, 1]) == j:
                law = int(rows[i, 0])
                bent = _bristle(z[i], w, rows[i, 3], dt) if law == PRESLIDING else 0.0
                force += _law(
                    law, rows, i, d, w, _between(last, plus[j], minus[j]), t, F, bent, viscous[j], outside
                )
        _push(a, mass, plus[j], minus[j], force)


@_inner
def _coulomb(x, v, t, F, plant, memory, a):
    """Coulomb forces `held`: of the level against sliding, or what keeps a standing joint at rest, up to the level."""
    mass, plus, minus = plant[:3]
    rubbing, inertia = plant[8:]
    mode, held = memory[:2]
    held[:] = 0.0
    for _ in range(4 if rubbing.sum() > 1 else 1):  # two joints that share a body hold each other
        for j in range(plus.size):
            if not rubbing[j]:
                continue
            d, w = _between(x, plus[j], minus[j]), _between(v, plus[j], minus[j])
            need = held[j] - _between(a, plus[j], minus[j]) * inertia[j]
            sign = mode[j] if mode[j] != 0 else (-1.0 if need > 0 else 1.0)
            level = _level(j, sign, d, w, t, F, plant)
            force = -sign * level if mode[j] != 0 or abs(need) > level else need
            _push(a, mass, plus[j], minus[j], force - held[j])
            held[j] = force


@_inner
def _settle(v, plant, mode):
    """Joints whose sliding has changed its sign stand; a joint that stands has no velocity."""
    mass, plus, minus = plant[:3]
    rubbing, inertia = plant[8:]
    for j in range(plus.size):
        w = _between(v, plus[j], minus[j])
        if rubbing[j] and mode[j] * w <= 0:
            _push(v, mass, plus[j], minus[j], -w * inertia[j])
            mode[j] = 0.0


@_inner
def _break_loose(x, t, F, plant, memory, a):
    """Standing joints that their level no longer holds slide from here on."""
    plus, minus, rubbing = plant[1], plant[2], plant[8]
    mode, held = memory[:2]
    for j in range(plus.size):
        if rubbing[j] and mode[j] == 0:
            d, pull = _between(x, plus[j], minus[j]), _between(a, plus[j], minus[j])
            sign = -np.sign(held[j]) if held[j] != 0 else np.sign(pull)
            if abs(held[j]) >= _level(j, sign, d, 0.0, t, F, plant):
                mode[j] = sign


@_inner
def _substep(x, v, t, start, half, end, drive, plant, memory, work):
    """One step of Runge-Kutta; the drive force at its start, middle and end."""
    plus, minus, rows = plant[1], plant[2], plant[6]
    mode, _, last, z = memory
    a, xs, vs, moved, gained = work
    _settle(v, plant, mode)
    moved[:] = 0.0
    gained[:] = 0.0
    for s in range(4):
        F, dt = (start, 0.0) if s == 0 else ((end, STEP) if s == 3 else (half, STEP / 2))
        for b in range(x.size):
            xs[b] = x[b] + dt * vs[b]
            vs[b] = v[b] + dt * a[b]
            a[b] = 0.0
        _push(a, plant[0], drive[0], drive[1], F)
        _springs(xs, vs, plant, a)
        _joints(xs, vs, t + dt, dt, F, plant, memory, a)
        _coulomb(xs, vs, t + dt, F, plant, memory, a)
        if s == 0:
            for b in range(x.size):
                last[b] = a[b]
            _break_loose(x, t, F, plant, memory, a)
        share = STEP / 6 if s in (0, 3) else STEP / 3
        for b in range(x.size):
            moved[b] += share * vs[b]
            gained[b] += share * a[b]
    for r in range(rows.shape[0]):
        if int(rows[r, 0]) == PRESLIDING:
            j = int(rows[r, 1])
            w = _between(v, plus[j], minus[j]) + _between(gained, plus[j], minus[j]) / 2
            z[r] = _bristle(z[r], w, rows[r, 3], STEP)
    for b in range(x.size):
        x[b] += moved[b]
        v[b] += gained[b]


@_inner
def _command(k, x, drive, ripple, gains, motion, noise, state):
    """The controller's force from its reading; `state`: integral, last reading, velocity."""
    reading = _between(x, drive[0], drive[1])
    reading += ripple[0] * np.sin(2 * np.pi * reading / ripple[1] + ripple[2]) + noise[0, k]
    if noise[1, 0] > 0:
        reading = np.round(reading / noise[1, 0]) * noise[1, 0]
    difference = (reading - state[1]) * CONTROL_HZ if k > 0 else 0.0
    state[1] = reading
    state[2] += gains[3] * (difference - state[2])
    error = motion[1, k] + gains[0] * (motion[0, k] - reading) - state[2]
    state[0] += error / CONTROL_HZ
    return gains[1] * error + gains[2] * state[0] + motion[2, k]


@njit(cache=True, error_model="numpy")
def loop(machine, gains, motion, noise):
    """Positions and accelerations of the bodies at 4 kHz and the commanded force at 16 kHz.

    `machine` is the tuple of: mass (bodies,), plus, minus, viscous and coulomb (joints,), springs (n, 6: plus, minus,
    k, c, k3, half the gap), rows (n, ROW), outside (samples at 4 kHz of a force), payload (body, mass, time), drive
    (plus, minus), actuator (delay in substeps, lag in s, limit, quadratic, cubic), ripple (amplitude, pitch, phase).
    gains: Kpp, Kpv, Kiv, weight of the newest difference in the velocity. motion (3, ticks): reference, its velocity,
    added force. noise (2, ticks): of the reading that the controller takes; its step, in the first element.
    """
    constant, plus, minus, viscous, coulomb, springs, rows, outside, payload, drive, actuator, ripple = (
        machine
    )
    mass, inertia, rubbing = constant.copy(), np.zeros(plus.size), coulomb > 0
    for r in range(rows.shape[0]):
        rubbing[int(rows[r, 1])] |= rows[r, 0] < VISCOUS
    plant = (mass, plus, minus, viscous, coulomb, springs, rows, outside, rubbing, inertia)
    _weigh(inertia, mass, plus, minus)
    bodies, ticks, h = mass.size, motion.shape[1], STEP
    x, v, state = np.zeros(bodies), np.zeros(bodies), np.zeros(3)
    memory = (
        np.zeros(plus.size),
        np.zeros(plus.size),
        np.zeros(bodies),
        np.zeros(rows.shape[0]),
    )  # mode, held, last, z
    work = (np.zeros(bodies), np.zeros(bodies), np.zeros(bodies), np.zeros(bodies), np.zeros(bodies))
    positions, accelerations = np.zeros((ticks // LOG_TICKS, bodies)), np.zeros((ticks // LOG_TICKS, bodies))
    command, applied, force = np.zeros(ticks), np.zeros(ticks), 0.0
    lag, late = actuator[1], int(actuator[0])
    decay_half, decay = (np.exp(-h / 2 / lag), np.exp(-h / lag)) if lag > 0 else (0.0, 0.0)
    for k in range(ticks):
        if payload[0] >= 0 and (k - 1) / CONTROL_HZ < payload[2] <= k / CONTROL_HZ:
            mass[int(payload[0])] += payload[1]
            _weigh(inertia, mass, plus, minus)
        command[k] = _command(k, x, drive, ripple, gains, motion, noise, state)
        u = min(max(command[k], -actuator[2]), actuator[2])
        applied[k] = u * (1 - actuator[3] * abs(u) - actuator[4] * u * u)
        for i in range(SUBSTEPS):
            if i == 0 and k % LOG_TICKS == 0:
                positions[k // LOG_TICKS] = x
            at = k * SUBSTEPS + i - late
            goal = applied[at // SUBSTEPS] if at >= 0 else 0.0
            start = force if lag > 0 else goal
            half, end = goal + (start - goal) * decay_half, goal + (start - goal) * decay
            _substep(x, v, k / CONTROL_HZ + i * h, start, half, end, drive, plant, memory, work)
            if i == 0 and k % LOG_TICKS == 0:
                accelerations[k // LOG_TICKS] = memory[2]
            force = end
    return positions, accelerations, command
