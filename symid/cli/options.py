"""Options shared by several commands, and the parsing and checks of their values."""

import math
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import click
from click import option

from symid.axis import Axis
from symid.cli.outputs import Output
from symid.cli.terminal import is_closed, with_options
from symid.errors import SettingError
from symid.files import as_json, is_finite_number, read_json, shortened, write_whole
from symid.parameter_entries import parameter_entries
from symid.units import Unit, to_si


class Number(click.types.FloatParamType):
    """A finite number above a bound, or equal to it if `included`; some limits may be infinite."""

    def __init__(self, above: float = 0.0, *, included: bool = False, infinite: bool = False) -> None:
        self.above, self.included, self.infinite = above, included, infinite

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; click's error, which names the option, for invalid text."""
        number = float(super().convert(value, param, ctx))
        big_enough = number >= self.above if self.included else number > self.above
        if not big_enough or not (math.isfinite(number) or (self.infinite and number > 0)):
            least = f"{self.above:g} or more" if self.included else "positive"
            what = "finite" if self.above == -math.inf else least
            self.fail(f"{value} is not possible: it must be {what}", param, ctx)
        return number


class SamplingRate(Number):
    """A rate in Hz, or ``own``."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The rate, or ``own`` unchanged."""
        return value if value == "own" else super().convert(value, param, ctx)


POSITIVE = Number()
RATE = SamplingRate()
NOT_NEGATIVE = Number(included=True)
LIMIT = Number(infinite=True)
COUNT = click.IntRange(1, 10**9)
ORDER = click.IntRange(1, 50)

json_option = option(
    "--json",
    "json_file",
    metavar="FILE",
    type=Output("json"),
    help="Write the result as JSON (- for standard output).",
)
dark_option = option("--dark", is_flag=True, help="Draw on a dark background.")
held_option = option(
    "--held",
    multiple=True,
    metavar="SIGNAL",
    help="Force held from sample to sample, which acts half a sample late.",
)
late_option = option(
    "--late",
    multiple=True,
    metavar="SIGNAL=TIME",
    help="Time by which a signal was recorded late, such as q2=125us.",
)
measured_option = option("--measured", metavar="SIGNALS", help="Sensors to use, such as q2,ddq1.")
gain_option = option(
    "--controller-gain",
    "gains",
    multiple=True,
    metavar="NAME=VALUE",
    help="Kpp, Kpv, Kiv of the cascade (Kpp=0: a velocity loop), Kfa and Kfv of its feed-forward.",
)

report_option = option(
    "--report", metavar="OUT.html", type=Output("html"), help="Write a page that can be passed on."
)
bandwidth_option = option(
    "--bandwidth",
    type=POSITIVE,
    default=20.0,
    help="Bandwidth of the velocity loop that is tuned to the axis, in Hz.",
)

_LARGEST = 1e50
"""Largest parameter in SI units, and inverse of the smallest: products of others would overflow."""
_LONGEST_LAG = 1000.0
"""Longest time by which a signal may be late, s."""
_CASCADE = {
    "Kpp": "position_gain",
    "Kpv": "velocity_gain",
    "Kiv": "integral_gain",
    "Kfa": "acceleration_feedforward",
    "Kfv": "velocity_feedforward",
}


def plot_option(what: str) -> Callable[[Any], Any]:
    """Option ``--plot`` of a command that draws something."""
    return option("--plot", metavar="FILE", type=Output("picture"), help=f"Draw {what} (png, svg or pdf).")


def parameter_option(what: str) -> Callable[[Any], Any]:
    """Option ``--parameters`` of a command that needs the physical parameters."""
    return option("--parameters", "file", required=True, metavar="P.json", help=what)


def page_of(file: str | None) -> Path | None:
    """Path of a page; SettingError, before any work is done, if it cannot be written."""
    if not file:
        return None
    from symid.report.pages import html_path  # jinja2 and sympy are loaded only where a page is written

    return html_path(file)


def cascade_gains(values: tuple[str, ...]) -> dict[str, float]:
    """Gains of ``--controller-gain`` by the fields of a cascade.

    >>> cascade_gains(("Kpp=30",))
    {'position_gain': 30.0}
    """
    return {
        _CASCADE[name]: value for name, value in named_numbers(values, "--controller-gain", _CASCADE).items()
    }


def held_force(signals: tuple[str, ...], axis: Axis) -> bool | None:
    """True if ``--held`` names a force of the axis (all are then held); None without it: the declaration decides."""
    forces = [drive.signal for drive in axis.drives]
    if unknown := [name for name in signals if name not in forces]:
        raise SettingError(
            f"--held {unknown[0]} is not the force of axis {axis.name!r}: give {' or '.join(forces)}"
        )
    return True if signals else None


def bytes_of(text: str) -> int:
    """Bytes of ``--memory``, such as ``512MB``.

    >>> bytes_of("1.5GB")
    1500000000
    """
    factor = {"kB": 1e3, "MB": 1e6, "GB": 1e9}.get(text[-2:])
    if factor is None:
        raise SettingError(
            f"--memory {text!r} is not a size: write a number with kB, MB or GB, such as 512MB"
        )
    size = number(text[:-2], "--memory")
    if not 1 <= size * factor < 1e18:
        raise SettingError(f"--memory {text!r} is not possible: give a size such as 512MB")
    return int(size * factor)


def require_signals(axis: Axis, names: Iterable[str]) -> None:
    """Refuse names that are not signals of an axis."""
    if unknown := [name for name in names if name not in axis.signal_units]:
        raise SettingError(
            f"axis {axis.name!r} has no signal {unknown[0]!r}: choose from {', '.join(axis.signal_units)}"
        )


def signal_list(text: str | None) -> tuple[str, ...] | None:
    """Signals of a comma-separated list."""
    return None if text is None else tuple(part.strip() for part in text.split(",") if part.strip())


def named_numbers(
    values: tuple[str, ...], option: str, known: Collection[str] | None = None
) -> dict[str, float]:
    """Mapping of options such as ``--gain q2=-1`` to finite numbers, as `named_values`."""
    given = named_values(values, option, known)
    return {name: number(text, f"{option} {name}") for name, text in given.items()}


_EXAMPLES = {"--known": "Ml=0,12.5kg", "--bounds": "Fv=0..300", "--fix": "Ml=12.5kg", "--unit": "q2=mm"}
_EXAMPLES |= {"--gain": "q2=-1", "--late": "q2=125us", "--noise": "q2=1e-6", "--controller-gain": "Kpp=30"}
"""Kind of value of each option that sets values by name."""


def named_values(
    values: tuple[str, ...], option: str, known: Collection[str] | None = None
) -> dict[str, str]:
    """Mapping of options such as ``--column q2=pos_mm``: ``NAME=VALUE``, each name once and one of those `known`."""
    pairs: dict[str, str] = {}
    for value in values:
        name, equals, right = value.partition("=")
        if not (name and equals and right):
            example = _EXAMPLES.get(option, "q2=pos_mm")
            raise SettingError(f"{option} {value!r} is not NAME=VALUE: write for example {option} {example}")
        if pairs.setdefault(name.strip(), right.strip()) != right.strip():
            raise SettingError(
                f"{option} {name.strip()} is given as {pairs[name.strip()]} and as {right.strip()}: give it once"
            )
    if known is not None and (strange := [name for name in pairs if name not in known]):
        verb = "is" if len(strange) == 1 else "are"
        raise SettingError(f"{option} {', '.join(strange)} {verb} not known: choose from {', '.join(known)}")
    return pairs


def number(text: str, what: str) -> float:
    """A finite number; SettingError for any other text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SettingError(f"{what} is {text!r}: it must be a finite number")
    return value


def seconds_of(text: str, what: str) -> float:
    """A time such as 125us or -0.0001, in seconds.

    >>> seconds_of("125us", "--late q2")
    0.000125
    """
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyzµ")
    factor = to_si(text[len(digits) :], Unit.of("s")) if len(digits) < len(text) else 1.0
    seconds = number(digits, what) * factor
    if not abs(seconds) <= _LONGEST_LAG:
        raise SettingError(f"{what} is {text!r}: at most {_LONGEST_LAG:g} s are possible")
    return seconds


def parameter_file(file: str, axis: Axis, fixed: Mapping[str, float] | None = None) -> dict[str, float]:
    """Physical parameters, SI, of a JSON file: names with values, or the result of an identification or a diagnosis.

    Values of `fixed` go before those of the file.
    """
    record = read_json(file)
    if not isinstance(record, dict):
        raise SettingError(f'{file} holds no parameters: write {{"NAME": value, ...}} in SI units')
    parameters: dict[str, float] = {}
    for name, (value, *_) in parameter_entries(record).items():
        if value is None or (name not in axis.physical_parameters and not is_finite_number(value)):
            continue
        if not is_finite_number(value) or (value and not 1 / _LARGEST < abs(value) < _LARGEST):
            raise SettingError(f"{file}: {name} is {shortened(value)}: give a finite number in SI units")
        parameters[name] = float(value)
    parameters |= fixed or {}
    missing = [name for name in axis.physical_parameters if name not in parameters]
    if missing:
        raise SettingError(
            f"{file} lacks {', '.join(missing)}: give a value for each physical parameter of {axis.name!r}, "
            f"in the file or with --fix {missing[0]}=VALUE"
        )
    return parameters


def write_json(record: object, file: str) -> None:
    """Write a record as JSON to a file, or to standard output for ``-``; numbers that are not finite become null."""
    if file != "-":
        write_whole(file, as_json(record))
    elif is_closed(sys.stdout):
        raise SettingError("--json -: standard output is closed: give a file")
    else:
        encoding = (sys.stdout.encoding or "utf-8").lower().replace("-", "")
        sys.stdout.write(as_json(record, ascii_only=encoding != "utf8"))


def give_result(record: Any, json_file: str | None, show: Callable[[Any], object]) -> None:
    """Write a record as JSON if requested, and show it unless the JSON goes to standard output.

    Settings that it names become options.
    """
    record = with_options(record)
    if json_file:
        write_json(record, json_file)
    if json_file != "-":
        show(record)


def shared(*options: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Apply several option decorators; the help shows them in this order."""

    def decorate(function: Any) -> Any:
        for decorated in reversed(options):
            function = decorated(function)
        return function

    return decorate
