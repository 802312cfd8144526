"""Options that several commands share: the logs, and their preparation."""

import re
from dataclasses import replace
from typing import Any

from click import Choice, get_current_context, option

from symid.axis import Axis
from symid.cli.options import (
    COUNT,
    ORDER,
    RATE,
    held_option,
    late_option,
    named_numbers,
    named_values,
    number,
    require_signals,
    seconds_of,
    shared,
    signal_list,
)
from symid.cli.terminal import say
from symid.data import Log
from symid.errors import SettingError
from symid.identification import LogMapping, Preparation, read_axis_log, read_mapping
from symid.identification.rows import DIFFERENCE_ORDER
from symid.identification.signals import require_known

log_options = shared(
    option("--column", multiple=True, metavar="SIGNAL=COLUMN", help="Column of a signal (t is the time)."),
    option("--unit", multiple=True, metavar="SIGNAL=UNIT", help="Unit of a signal's column, such as q2=mm."),
    option(
        "--gain", multiple=True, metavar="SIGNAL=FACTOR", help="Factor applied to a signal, such as ql=-1."
    ),
    option(
        "--mapping",
        metavar="FILE.json",
        help="Columns, units, gains and layout of a foreign file, from symid import; other options override it.",
    ),
    option(
        "--resample",
        type=RATE,
        metavar="HZ|own",
        help="Resample a log whose clock jitters, lacks some samples or differs between channels.",
    ),
)

preparation_options = shared(
    option(
        "--cutoff",
        metavar="HZ",
        help="Cutoff frequency of the zero-phase Butterworth filter [chosen from the log].",
    ),
    option("--order", type=ORDER, default=4, help="Order of one pass of the filter."),
    option(
        "--filter",
        "filtered",
        type=Choice(["all", "motion"]),
        default="all",
        help="Whether the force passes the filter too.",
    ),
    option(
        "--decimation", type=COUNT, metavar="N", help="One row for every N samples [chosen from the cutoff]."
    ),
    option(
        "--differences",
        type=int,
        default=DIFFERENCE_ORDER,
        metavar="ORDER",
        help="Order of accuracy of differences, an even number; 2 is the paper's.",
    ),
    option(
        "--trim", metavar="N or BEGIN,END", help="Samples left out at the ends [three periods of the cutoff]."
    ),
    option(
        "--standstill",
        metavar="SPEED",
        help="Speed below which rows do not enter friction equations; 0 keeps all [1 % of the highest].",
    ),
    held_option,
    late_option,
)


def read_log_of(declared: Axis, file: str, options: dict[str, Any]) -> Log:
    """A log by the log options; guesses of a mapping are printed on standard error and become notes of the log."""
    log = read_axis_log(declared, file, **log_settings(declared, options))
    return replace(log, notes=(*log.notes, *notes_on_guesses(options)))


def log_settings(declared: Axis, options: dict[str, Any]) -> dict[str, Any]:
    """Columns from the log options, and the sensors to read."""
    require_known(mapping_of(options), declared)
    return {"measured": signal_list(options["measured"]), **column_settings(options)}


def column_settings(options: dict[str, Any]) -> dict[str, Any]:
    """Columns of a foreign file from mapping and log options."""
    mapping = mapping_of(options)
    return {
        "columns": {**mapping.columns, **named_values(options["column"], "--column")},
        "units": {**mapping.units, **named_values(options["unit"], "--unit")},
        "gains": {**mapping.gains, **named_numbers(options["gain"], "--gain")},
        "layout": mapping.layout,
        "sampling_period": mapping.sampling_period,
        "resample": options.get("resample"),
    }


def notes_on_guesses(options: dict[str, Any]) -> tuple[str, ...]:
    """Guesses of a mapping as notes, printed on standard error with the first of several logs."""
    guesses, noted = mapping_of(options).guesses, get_current_context().meta
    if guesses and not noted.get("guesses"):
        noted["guesses"] = True
        say(f"{options['mapping']} guesses: {'; '.join(guesses)}", err=True)
    return tuple(f"guessed in the mapping: {guess}" for guess in guesses)


def mapping_of(options: dict[str, Any]) -> LogMapping:
    """The mapping of ``--mapping``, an empty one without it."""
    if not options.get("mapping"):
        return LogMapping()
    given = (
        [entry.partition("=")[0].strip() for entry in options.get(n, ())] for n in ("column", "gain", "unit")
    )
    return read_mapping(options["mapping"], *given)


def preparation_of(options: dict[str, Any], late: dict[str, float]) -> Preparation:
    """Preparation by the preparation options, except for ``--held``."""
    return Preparation(
        cutoff_hz=None if options["cutoff"] is None else number(options["cutoff"], "--cutoff"),
        order=options["order"],
        filter_force=options["filtered"] == "all",
        decimation=options["decimation"],
        trim=_trim(options["trim"]),
        standstill=None if options["standstill"] is None else number(options["standstill"], "--standstill"),
        late=late,
        difference_order=options["differences"],
    )


def known_late(declared: Axis, options: dict[str, Any]) -> dict[str, float]:
    """Seconds by which signals of an axis were recorded late, as given."""
    late = late_of(options)
    require_signals(declared, late)
    return late


def late_of(options: dict[str, Any]) -> dict[str, float]:
    """Seconds by which signals were recorded late, by ``--late`` and the mapping."""
    given = named_values(options["late"], "--late")
    return {
        **mapping_of(options).late,
        **{name: seconds_of(text, f"--late {name}") for name, text in given.items()},
    }


_SAMPLES = re.compile(r"[0-9]{1,12}")


def _trim(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) > 2 or not all(_SAMPLES.fullmatch(part.strip()) for part in parts):
        raise SettingError(f"--trim {text!r} is not N or BEGIN,END in samples: write for example --trim 49,0")
    begin, end = int(parts[0]), int(parts[-1])
    return begin, end
