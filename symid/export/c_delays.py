"""C functions for signals on their way: the force that was sent, and readings, each late by a known time.

Both are looked up in notes of earlier steps, on a straight line between two of them: a reading itself, and
for the force its integral, whose change over the step gives the mean of what arrives in it.
"""

from __future__ import annotations

import math

from symid.axis import Axis, Sensor
from symid.export.c_motion import force_parameters, in_steps, sent_forces
from symid.export.dynamics import SymbolicDynamics

SHORTEST_STEP = 5e-6
"""Steps, s, from which on everything on its way is kept."""

_HEADER = """\
/* What is on its way for up to {longest!r} s, in steps h of at least {shortest:.2g} s. Begin with all of it 0. */
typedef struct {{
    struct {{ double time[{cells}], value[{cells}]; int newest, count; }} lane[{lanes}];
    double now, sent;
}} {name}_way;

/* One step h with the delays, which the functions above leave out: x advances, y is what sensors read at its end. */
void {name}_advance(const {name}_parameters *p, {name}_way *way, double x[{n_state}], {forces}, double h,
                    double y[{n_sensors}]);

"""

_SOURCE = """\

static void note({name}_way *way, int lane, double time, double value)
{{
    const int cells = {cells}, next = (way->lane[lane].newest + 1)%cells;
    way->lane[lane].time[next] = time;
    way->lane[lane].value[next] = value;
    way->lane[lane].newest = next;
    if (way->lane[lane].count < cells) way->lane[lane].count++;
}}

/* What was noted for a time: on a line between two notes, the oldest before all of them, the newest after. */
static double noted(const {name}_way *way, int lane, double time)
{{
    const int cells = {cells}, count = way->lane[lane].count, newest = way->lane[lane].newest;
    int low = 0, high = count - 1;  /* ages of notes: low is not before the time, high is not after it */
    const double *t = way->lane[lane].time, *value = way->lane[lane].value;
    if (time >= t[newest]) return value[newest];
    if (time <= t[(newest - high + cells)%cells]) return value[(newest - high + cells)%cells];
    while (high - low > 1) {{
        const int middle = (low + high)/2;
        if (t[(newest - middle + cells)%cells] >= time) low = middle; else high = middle;
    }}
    const int a = (newest - high + cells)%cells, b = (newest - low + cells)%cells;
    return value[a] + (value[b] - value[a])*(time - t[a])/(t[b] - t[a]);
}}

void {name}_advance(const {name}_parameters *p, {name}_way *way, double x[{n_state}], {forces}, double h,
                    double y[{n_sensors}])
{{
    double before[{n_state}], change[{n_state}];
    const double now = way->now;
    for (int i = 0; i < {n_state}; i++) before[i] = x[i];
{begin}
{late}
    {name}_step(p, x, {acting}, h);
    for (int i = 0; i < {n_state}; i++) change[i] = (x[i] - before[i])/h;
    {name}_sensors(x, change, y);
    way->now = now + h;
{read}
}}
"""


def delay_fields(dynamics: SymbolicDynamics, shortest: float = SHORTEST_STEP) -> dict[str, str]:
    """Fields that delays add to header and source, for steps of at least `shortest` s; empty without delays."""
    axis, drive = dynamics.axis, dynamics.imperfect.delay
    late = [(i, s) for i, s in enumerate(axis.sensors) if s.delay]
    longest = max([drive, *(s.delay for _, s in late)])
    if not longest:
        return {"way_header": "", "way_source": ""}
    words = {
        "name": axis.name,
        "forces": force_parameters(axis),
        "acting": "late" if drive else sent_forces(axis),
        "n_state": dynamics.n_states,
        "n_sensors": len(axis.sensors),
        "cells": math.ceil(longest / shortest) + 3,
        "lanes": (drive > 0) + len(late),
        "longest": longest,
        "shortest": shortest,
    }
    source = _SOURCE.format(
        **words, begin=_begin(axis, drive), late=_late(axis, drive), read=_read(axis, drive)
    )
    return {"way_header": _HEADER.format(**words), "way_source": source}


def _begin(axis: Axis, delay: float) -> str:
    """Statements before the first step: readings and force are taken as constant until then."""
    found = [
        f"{axis.name}_derivative(p, x, {sent_forces(axis)}, change);",
        f"{axis.name}_sensors(x, change, y);",
    ]
    if delay:
        found.append(f"note(way, 0, {-2 * delay!r}, {-2 * delay!r}*{sent_forces(axis)});")
        found.append("note(way, 0, 0.0, 0.0);")
    for lane, i, _ in _lanes(axis, delay):
        found.append(f"note(way, {lane}, 0.0, y[{i}]);")
    inner = "".join(f"        {statement}\n" for statement in found)
    return f"    if (!way->lane[0].count) {{\n{inner}    }}"


def _late(axis: Axis, delay: float) -> str:
    """Statements for the force that arrives; only one drive has a delay (`symbolic_dynamics`)."""
    if not delay:
        return ""
    found = [
        f"way->sent += h*{sent_forces(axis)};",
        "note(way, 0, now + h, way->sent);",
        f"const double late = (noted(way, 0, now + h - {delay!r}) - noted(way, 0, now - {delay!r}))/h;",
    ]
    return "\n".join(f"    {statement}" for statement in found)


def _read(axis: Axis, delay: float) -> str:
    found = []
    for lane, i, sensor in _lanes(axis, delay):
        found.append(f"note(way, {lane}, way->now, y[{i}]);")
        found.append(f"y[{i}] = noted(way, {lane}, way->now - {sensor.delay!r});  /* {sensor.signal} */")
        if sensor.resolution:
            found.append(in_steps(f"y[{i}]", sensor.resolution))
    return "\n".join(f"    {statement}" for statement in found)


def _lanes(axis: Axis, delay: float) -> list[tuple[int, int, Sensor]]:
    """Lane, number and sensor of each late reading."""
    late = [(i, s) for i, s in enumerate(axis.sensors) if s.delay]
    return [(lane, i, s) for lane, (i, s) in enumerate(late, int(delay > 0))]
