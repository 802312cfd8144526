"""C functions for delayed signals: the forces of drives and the readings of sensors, each late by a known time.

Earlier values are stored in a ring buffer and interpolated linearly: of a reading the value itself, of a force its
integral, whose change over a step gives the mean force that arrives in the step.
"""

import math
from collections.abc import Iterator, Sequence

from symid.export.c_code import c_name
from symid.export.c_motion import force_parameters, lines, quantised, sent_forces
from symid.export.dynamics import SymbolicDynamics
from symid.export.imperfect_terms import DrivePath

SHORTEST_STEP = 5e-6
"""Shortest step for which the ring buffers suffice, s."""

_HEADER = """\
/* Signals delayed by up to {longest!r} s, in steps h of at least {shortest:.2g} s. Initialise it with zeros. */
typedef struct {{
    struct {{ double time[{cells}], value[{cells}]; int newest, count; }} lane[{lanes}];
    double now, sent[{drives}];
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

/* Interpolated value at a time; the oldest value before all of them, the newest after. */
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
{begin}
    for (int i = 0; i < {n_state}; i++) before[i] = x[i];
{late}
    {name}_step(p, x, {acting}, h);
    for (int i = 0; i < {n_state}; i++) change[i] = (x[i] - before[i])/h;
    {name}_sensors(x, change, y);
    way->now = now + h;
{read}
}}
"""


def delay_fields(dynamics: SymbolicDynamics, shortest: float) -> dict[str, str]:
    """Fields that delays add to header and source, for steps of at least `shortest` s; empty without delays."""
    axis, paths = dynamics.axis, dynamics.imperfect.drives
    late = [(i, sensor) for i, sensor in enumerate(axis.sensors) if sensor.delay]
    longest = max([*(path.delay for path in paths), *(sensor.delay for _, sensor in late)])
    if not longest:
        return {"way_header": "", "way_source": ""}
    # The first lanes are those of late forces; late readings follow.
    first_reading = sum(path.delay > 0 for path in paths)
    begin, arrive, forces = _late_forces(paths)
    begin = [*_constant_before(dynamics), *begin]
    read = list[str]()
    for lane, (i, sensor) in enumerate(late, first_reading):
        begin.append(f"note(way, {lane}, 0.0, y[{i}]);")
        read.append(f"note(way, {lane}, way->now, y[{i}]);")
        read.append(f"y[{i}] = noted(way, {lane}, way->now - {sensor.delay!r});  /* {sensor.signal} */")
        if sensor.resolution:
            read.append(quantised(f"y[{i}]", sensor.resolution))
    words = {
        "name": axis.name,
        "forces": force_parameters(axis),
        "acting": ", ".join(forces),
        "n_state": dynamics.n_states,
        "n_sensors": len(axis.sensors),
        "drives": len(paths),
        "cells": math.ceil(longest / shortest) + 3,
        "lanes": first_reading + len(late),
        "longest": longest,
        "shortest": shortest,
        "begin": "\n".join(
            ["    if (!way->lane[0].count) {", lines(f"    {line}" for line in begin), "    }"]
        ),
        "late": lines(arrive),
        "read": lines(read),
    }
    return {"way_header": _HEADER.format(**words), "way_source": _SOURCE.format(**words)}


def _constant_before(dynamics: SymbolicDynamics) -> Iterator[str]:
    """Statements before the first step: readings and forces were constant, and lags at rest."""
    name, forces = dynamics.axis.name, sent_forces(dynamics.axis)
    if any(memory for path in dynamics.imperfect.drives for _, memory in path.elements):
        yield f"{name}_settle(p, x, {forces});"
    yield f"{name}_derivative(p, x, {forces}, change);"
    yield f"{name}_sensors(x, change, y);"


def _late_forces(paths: Sequence[DrivePath]) -> tuple[list[str], list[str], list[str]]:
    """Statements before the first step, and in each step, for the delays of forces; and the forces that act."""
    begin, arrive, forces = list[str](), list[str](), list[str]()
    for k, path in enumerate(paths):
        lane = sum(other.delay > 0 for other in paths[:k])
        force, delay = c_name(path.drive.signal), path.delay
        forces.append(f"late_{lane}_" if delay else force)
        if delay:
            begin += [
                f"note(way, {lane}, {-2 * delay!r}, {-2 * delay!r}*{force});",
                f"note(way, {lane}, 0.0, 0.0);",
            ]
            arrive += [
                f"way->sent[{k}] += h*{force};",
                f"note(way, {lane}, now + h, way->sent[{k}]);",
                f"const double late_{lane}_ = (noted(way, {lane}, now + h - {delay!r}) "
                f"- noted(way, {lane}, now - {delay!r}))/h;",
            ]
    return begin, arrive, forces
