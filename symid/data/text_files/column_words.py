"""Words and units by which columns of foreign files are named, in the languages of drives and scopes."""

import re
from typing import Final, Literal

Quantity = Literal[
    "time", "position", "velocity", "acceleration", "force", "current", "voltage", "percent", "command"
]
"""Quantity of a column; a command is sent by a controller to a drive, in a unit that the file does not state."""

UNITS: Final[tuple[tuple[Quantity, tuple[str, ...]], ...]] = (
    ("time", ("s",)),
    ("velocity", ("m/s", "rad/s")),
    ("acceleration", ("m/s^2", "rad/s^2")),
    ("force", ("N", "N*m")),
    ("current", ("A",)),
    ("voltage", ("V",)),
    ("position", ("m", "rad")),
)
"""Units in SI of each quantity."""
EFFORTS: Final[tuple[Quantity, ...]] = "force", "current", "voltage", "percent", "command"
"""Quantities that a column of a drive may hold, whatever its name says."""
WEIGHTS: Final = "kg", "lb", "lbs"
"""Masses in which load cells show forces."""
WORDS: Final[tuple[tuple[Quantity, str], ...]] = (
    (
        "time",
        r"t|ts|time|(?:time)?stamps?|zeit\w*|temps|tempo|tiempo|время|\w*[时時][间間]|sec(?:onds?)?|elapsed|uptime|"
        r"ms(?:ec)?|milli(?:s|seconds?)|us(?:ec)?|micro(?:s|seconds?)|ns(?:ec)?|nano(?:s|seconds?)",
    ),
    ("acceleration", r"acc\w*|ddot|acel\w*|(?:ist|soll)?beschl\w*|ddq\w*|qdd|ускорение|\w*加速度\w*"),
    (
        "velocity",
        r"vel\w*|speed|dot|omega|dtheta|dq|qd|(?:ist|soll)?(?:geschw|drehzahl)\w*|vitesse|скорость|\w*(?:速度|转速)\w*|v",
    ),
    (
        "force",
        r"torque|trq|tcmd|effort|(?:ist|soll)?(?:dreh)?moment\w*|force|(?:ist|soll)?kraft\w*|forza|fuerza|coppia|"
        r"couple|сила|усилие|момент|\w*(?:力|转矩|扭矩|トルク)\w*|fm?|tau",
    ),
    (
        "current",
        r"current|cur|iq|i|(?:ist|soll)?strom\w*|courant|corr?iente|corrente|ток|\w*[电電]流\w*|amps?",
    ),
    ("voltage", r"voltage|volts?|spannung|tensione?|voltaje|напряжение|\w*(?:电压|電圧)\w*"),
    (
        "position",
        r"(?:ist|soll|f|r)?(?:pos|lage)\w*|weg|angle|winkel|theta|phi|displ\w*|enc(?:oder)?|scale|положение|перемещение|координата|\w*(?:位置|位移|角度)\w*|q\w?|x|y|z",
    ),
    (
        "command",
        r"out(?:put)?|control|ctrl|duty\w*|pwm|u|throttle|dac|manipulated|stell(?:gr\w*|wert)|sortie|salida|uscita",
    ),
)
"""Words in the name of a column of each quantity; the first that fits counts."""
CLOCKS_NAMED: Final = {"ms": r"ms(?:ec)?|milli\w*", "us": r"us(?:ec)?|micro\w*", "ns": r"ns(?:ec)?|nano\w*"}
"""Units of a time that a word of its name states."""
SETPOINT: Final = (
    r"set\w*|soll\w*|\w*soll(?:wert)?|t?cmd|command\w*|ref\w*|target\w*|nom(?:l|inal)?|des(?:ired)?|cmptd|input|rpos|rvel|demand\w*|goal|qg|consigne|"
    r"consigna|задан\w*|\w*(?:指令|目标|目標|给定)\w*"
)
"""Words of what is commanded and not measured."""
DIFFERENCE: Final = (
    r"\w*err(?:or|eur|ore)?|following|droop|schlepp\w*|\w*(?:fehler|abweichung)|deviation|\w*ошибка|рассогласование|"
    r"\w*(?:误差|誤差|偏差)"
)
"""Words of what is commanded less what is measured."""
COUNTS: Final = (
    r"inc|incr\w*|increments?|inkr\w*|counts?(?:\d+bit)?|q?cts|cnts?|qc|impuls\w*|pulses?|lsbs?|digits?|"
    r"ticks?|steps?|bits?|units|usr(?:_\w)?"
)
"""Units of unknown length."""
IN_TURNS: Final = re.compile(r"(?:^|[\W_])(?:(?:pos|vel)_(?:estimate|setpoint)|input_(?:pos|vel))$")
"""Names of ODrive, whose positions count turns."""
ANGLES: Final = r"theta|phi|angle|winkel|\w*角度|угол|d?theta|omega|q\w?"
"""Words of a position or velocity that is an angle in rad or deg, not a number of turns."""
TORQUE_CURRENT: Final = r"i?q|quadrature|torque|(?:dreh)?moment\w*"
"""Words of the current that makes torque."""
TORQUE: Final = (
    r"torque|trq|tcmd|(?:ist|soll)?(?:dreh)?moment\w*|coppia|couple|момент|\w*(?:转矩|扭矩|トルク)\w*"
)
"""Words of a torque, which drives record in N*m or as a share of the rated one."""
NUMBERS: Final = r"samples?|index|idx|count\w*|cycles?|row|line|nr|no|seq\w*"
"""Words of columns that number the samples."""
SPELLED: Final = {
    "Nm": "N*m",
    "°": "deg",
    "µm": "um",
    "μm": "um",
    "1/min": "rpm",
    "U/min": "rpm",
    "r/min": "rpm",
    "N-m": "N*m",
    "G": "g",
    "inlb": "lbf*in",
    "inlbf": "lbf*in",
    "lbin": "lbf*in",
    "lbfin": "lbf*in",
    "ftlb": "lbf*ft",
    "ftlbf": "lbf*ft",
    "lbft": "lbf*ft",
    "lbfft": "lbf*ft",
    "ozin": "ozf*in",
    "inoz": "ozf*in",
    "pct": "%",
    "percent": "%",
    "permille": "‰",
    "sec": "s",
    "msec": "ms",
    "usec": "us",
    "Arms": "A",
    "Apk": "A",
    "A rms": "A",
    "Aeff": "A",
    "A eff": "A",
    "с": "s",
    "мс": "ms",
    "м": "m",
    "мм": "mm",
    "мкм": "um",
    "м/с": "m/s",
    "мм/с": "mm/s",
    "рад": "rad",
    "град": "deg",
    "об/мин": "rpm",
    "Н": "N",
    "кН": "kN",
    "Нм": "N*m",
    "Н·м": "N*m",
    "Н*м": "N*m",
    "А": "A",
    "В": "V",
}
"""Units as written, and as they are read."""
