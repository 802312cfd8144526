"""Python code that advances an axis and its controller sample by sample within one mode.

A function is written for each mode of a loop, in plain numbers: matrices are written out, zeros left out. It stops
before the sample in which an event happens, and hands over the force of that sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.loop import Loop
from symid.simulation.mode import StickSlipMode
from symid.simulation.plant import JUST_MOVING
from symid.simulation.sensor_channel import SensorChannel


def compiled(loop: Loop, mode: StickSlipMode) -> Callable[..., Any]:
    """Function that runs samples of a loop in a mode.

    It takes columns of numbers by sample (number of the sample, position, velocity and acceleration of each drive's
    reference, noise of each controlled signal, given force of each drive), lists of the values on their way from each
    controlled sensor, state of the axis, state of the controllers and limits of the stuck joints. It returns numbers by
    sample (state at its end, forces, accelerations if a sensor reads one, values taken between samples), forces and
    controllers' state of the sample with an event (None if there is none), and the controllers' state.
    """
    writer = SampleCode(loop, mode)
    space: dict[str, Any] = {"array": np.array, "force": loop.force, "at": loop.at, **writer.functions}
    exec(compile(writer.text(), "<sample loop>", "exec"), space)
    return space["run"]  # type: ignore[no-any-return]  # exec is untyped


class SampleCode:
    """Writer of the code for a loop in a mode."""

    def __init__(self, loop: Loop, mode: StickSlipMode) -> None:
        self.loop, self.mode = loop, mode
        self.functions: dict[str, Callable[..., Any]] = {
            f"law{j}_{i}": function
            for j, (law, _) in enumerate(mode.varying)
            for i, (_, function) in enumerate(law.terms)
        }
        self.functions |= {f"hold{i}": mode.plant.laws[j].limits for i, j in enumerate(mode.flow.stuck)}
        self.functions |= {
            f"misread{i}": reader.misread for i, reader in enumerate(loop.controlled) if reader.misread
        }
        self._memories = loop.moment.memories if loop.moment else []
        self.functions |= {f"settle{i}": memory.settle for i, (_, memory) in enumerate(self._memories)}
        self._n = len(mode.plant.bodies)
        self._state = [f"x{i}" for i in range(2 * self._n)]
        self._memory = [f"c{i}" for i in range(len(loop.law.A))] if loop.law else []
        self._inputs = [f"r{i}" for i in range(3 * loop.n_drives)]
        self._forces_sent = [f"u{i}" for i in range(loop.n_drives)]
        self._given = [f"given{i}" for i in range(loop.n_drives)]
        self._readings = [f"y{i}" for i in range(len(loop.controlled))]
        self._values: dict[str, str] = {}

    def text(self) -> str:
        """Source text of the function."""
        end, readings = self._names("z"), range(len(self._readings))
        columns = ["k", *self._inputs, *(f"e{i}" for i in readings), *self._given, *self._readings]
        limits = [name for i in range(len(self.mode.flow.stuck)) for name in (f"low{i}", f"high{i}")]
        sample = [*self._control(), *self._motion()]
        sample += [
            f"settle{i}({_form(zip(end[: self._n], direction, strict=True))})"
            for i, (direction, _) in enumerate(self._memories)
        ]
        for names, values in ((self._state, end), self._next_memory()):
            sample += [f"{', '.join(names)} = {', '.join(values)}"] if names else []
        between = [self._values[reader.signal] for reader in self.loop.between]
        sample.append(f"emit(({', '.join([*end, *self._forces_sent, *self._accelerations, *between])},))")
        sample += [f"remember{i}({self._value(i, reader)})" for i, reader in enumerate(self.loop.controlled)]
        memory = f"({''.join(name + ', ' for name in self._memory)})" if self.loop.law else "memory"
        lines = [
            f"{', '.join(self._state)}, = state",
            *([f"{', '.join(limits)}, = limits"] if limits else []),
            *([f"{', '.join(self._memory)}, = memory"] if self._memory else []),
            *(f"remember{i} = pasts[{i}].append" for i in readings),
            "out, pending = [], None",
            "emit = out.extend",
            f"for {', '.join(columns)} in zip(*columns, *pasts):",
            *(f"    {line}" for line in sample),
            f"return out, pending, {memory}",
        ]
        return "\n    ".join(["def run(columns, pasts, state, memory, limits):", *lines])

    def _next_memory(self) -> tuple[list[str], list[str]]:
        if self.loop.law is None:
            return ["memory"], ["next_memory"]
        return self._memory, [f"k{i}" for i in range(len(self._memory))]

    def _control(self) -> list[str]:
        """Statements for the readings and the forces of the controllers."""
        lines = [
            _reading(f"y{i}", f"e{i}", reader.step, f"misread{i}" if reader.misread else "")
            for i, reader in enumerate(self.loop.controlled)
        ]
        readings = "".join(f"{name}, " for name in self._readings)
        law = self.loop.law
        called = f"force(k, ({', '.join(self._inputs)}), ({readings}), {{}})"
        forces = f"({', '.join(self._forces_sent)},)"
        if law is None:
            return [*lines, f"{forces}, next_memory = {called.format('memory')}", *self._moment()]
        inputs = [*self._inputs, *self._readings]
        for name, C, D, given, is_given in zip(
            self._forces_sent, law.C, law.D, self._given, law.is_given, strict=True
        ):
            terms = zip([*self._memory, *inputs], [*C, *D], strict=True)
            lines.append(f"{name} = {_form(terms, [given] if is_given else [])}")
        kept = self._next_memory()[1]
        within = (
            f"{-limit!r} <= {name} <= {limit!r}"
            for name, limit in zip(self._forces_sent, self.loop.limits, strict=True)
        )
        lines.append(f"if not ({' and '.join(within)}):")
        memory = f"array(({''.join(name + ', ' for name in self._memory)}))"
        lines.append(f"    {forces}, next_memory = {called.format(memory)}")
        if kept:
            lines.append(f"    {', '.join(kept)}, = next_memory.tolist()")
            lines.append("else:")
            for name, row in zip(kept, np.hstack([law.A, law.B]), strict=True):
                lines.append(f"    {name} = {_form(zip([*self._memory, *inputs], row, strict=True))}")
        return [*lines, *self._moment()]

    def _moment(self) -> list[str]:
        """Statements that update time, load and memories, and the limits of stuck joints that depend on them."""
        if self.loop.moment is None or not any(law.timed for law in self.mode.plant.laws):
            return []
        lines = [f"at(k, ({', '.join(self._forces_sent)},))"]
        for i, j in enumerate(self.mode.flow.stuck):
            if (law := self.mode.plant.laws[j]).timed:
                q = _form(zip(self._state[: self._n], law.direction, strict=True))
                lines.append(f"low{i}, high{i} = hold{i}({q})")
        return lines

    def _motion(self) -> list[str]:
        """All pieces of a sample, the conditions at their ends, and what sensors read there."""
        lines, names = [], self._state
        pieces = self.loop.pieces
        for p, (duration, readers) in enumerate(pieces):
            end = self._names("z" if p + 1 == len(pieces) else f"p{p}_")
            lines += self._piece(duration, names, end)
            for reader in readers:
                lines += self._read(reader, end)
            names = end
        self._accelerations = []
        if self.loop.is_accelerated:
            self._accelerations = [f"a{i}" for i in range(self._n)]
            lines += self._forces(names, "f")
            rows = self.mode.flow.acceleration_rows
            lines += [
                f"{name} = {self._linear(row, names, 'f')}"
                for name, row in zip(self._accelerations, rows, strict=True)
            ]
        return lines

    def _piece(self, duration: float, begin: Sequence[str], end: Sequence[str]) -> list[str]:
        """Motion over a duration; laws that vary act as at its middle."""
        step, lines, checks = self.mode.step(duration), self._forces(begin, "f"), []
        holding = self.mode.flow.holding_rows
        checks += self._outside(holding, begin, "f")
        force = "f"
        if self.mode.varying:
            half, middle = self.mode.step(duration / 2), self._names("m")
            lines += self._moved(np.hstack([half.transition, half.gain]), begin, middle, "f")
            lines += self._forces(middle, "g")
            force = "g"
        lines += self._moved(np.hstack([step.transition, step.gain]), begin, end, force)
        checks += [f"{_form(zip(end, row, strict=True))} < 0.0" for row in self.mode.speeds]
        checks += self._outside(holding, end, force)
        if checks:
            memory = ", ".join(self._next_memory()[1])
            pending = f"({memory},)" if self.loop.law and memory else memory or "()"
            forces = ", ".join(self._forces_sent)
            lines += [f"if {' or '.join(checks)}:", f"    pending = ({forces},), {pending}", "    break"]
        return lines

    def _outside(self, rows: FloatArray, names: Sequence[str], force: str) -> list[str]:
        held = [self._linear(row, names, force) for row in rows]
        return [f"not low{i} <= {text} <= high{i}" for i, text in enumerate(held)]

    def _moved(self, rows: FloatArray, begin: Sequence[str], end: Sequence[str], force: str) -> list[str]:
        return [f"{name} = {self._linear(row, begin, force)}" for name, row in zip(end, rows, strict=True)]

    def _linear(self, row: FloatArray, names: Sequence[str], force: str) -> str:
        """A row on the state and on the forces of drives, constants and varying laws."""
        state, forces, mode = row[: len(names)], row[len(names) :], self.mode
        terms = [*zip(names, state, strict=True)]
        terms += zip(self._forces_sent, forces @ mode.plant.drives, strict=True)
        terms += [(f"{force}{j}", -forces @ law.direction) for j, (law, _) in enumerate(mode.varying)]
        return _form(terms, [repr(float(forces @ mode.constant))])

    def _forces(self, names: Sequence[str], force: str) -> list[str]:
        """Forces of the varying laws at a state."""
        lines = []
        for j, (law, sign) in enumerate(self.mode.varying):
            lines.append(f"q = {_form(zip(names[: self._n], law.direction, strict=True))}")
            lines.append(f"v = {_form(zip(names[self._n :], law.direction, strict=True))}")
            if sign:
                least = sign * JUST_MOVING
                lines.append(f"if v {'<' if sign > 0 else '>'} {least!r}: v = {least!r}")
            parts = [f"{parameter!r} * law{j}_{i}(q, v)" for i, (parameter, _) in enumerate(law.terms)]
            lines.append(f"{force}{j} = {' + '.join(parts)}")
        return lines

    def _read(self, reader: SensorChannel, names: Sequence[str]) -> list[str]:
        """Value that a sensor takes between two samples."""
        value = f"value{len(self._values)}"
        self._values[reader.signal] = value
        row, n = np.zeros(3 * self._n), self._n
        if reader.order == 2:
            row = reader.row @ self.mode.flow.acceleration_rows
        else:
            row[reader.order * n : (reader.order + 1) * n] = reader.row
        return [*self._forces(names, "f"), f"{value} = {self._linear(row, names, 'f')}"]

    def _value(self, i: int, reader: SensorChannel) -> str:
        """Value of a controlled sensor in this sample."""
        if reader.is_between:
            return self._values[reader.signal]
        if reader.order == 2:
            return _form(zip(self._accelerations, reader.row, strict=True))
        names = self._names("z")[reader.order * self._n : (reader.order + 1) * self._n]
        return _form(zip(names, reader.row, strict=True))

    def _names(self, letter: str) -> list[str]:
        return [f"{letter}{i}" for i in range(2 * self._n)]


def _form(terms: Iterable[tuple[str, float]], constants: Sequence[str] = ()) -> str:
    """A sum of products, without what is zero.

    Examples
    --------
    >>> _form([("x", 1.0), ("y", 0.0), ("z", -2.5)], ["3.0"])
    'x + -2.5 * z + 3.0'
    """
    parts = [name if factor == 1.0 else f"{float(factor)!r} * {name}" for name, factor in terms if factor]
    parts += [constant for constant in constants if constant not in ("0.0", "-0.0")]
    return " + ".join(parts) or "0.0"


def _reading(value: str, noise: str, step: float, misread: str) -> str:
    noisy = f"({misread}({value}) + {noise})" if misread else f"({value} + {noise})"
    return f"{value} = {step!r} * round({noisy} / {step!r})" if step else f"{value} = {noisy}"
