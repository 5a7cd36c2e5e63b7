"""Which columns of a table hold what, and in which unit: chosen by a person, or recognised by name.

A name with its unit is taken at its word. A bare name, such as "timestamp", gets the one unit that is plausible for a
flight; where none is, or more than one, the table is refused with its columns and what to say. Nothing is guessed.
"""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import LONGEST_LOG_S, SHORTEST_LOG_S
from app.flights.raw_log import STANDARD_GRAVITY_M_S2, Floats
from app.text.messages import UserMessage, clean, message
from app.text.user_error import UserError
from protocol.translatable import marked

_ANGLES: Final = {"deg": 1.0, "rad": 180 / np.pi}
_FORCES: Final = {"g": STANDARD_GRAVITY_M_S2, "m_s2": 1.0}
QUANTITIES: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "tilt": _ANGLES, "roll": _ANGLES, "pitch": _ANGLES,
    "qw": {"": 1.0}, "qx": {"": 1.0}, "qy": {"": 1.0}, "qz": {"": 1.0},
    "acceleration": _FORCES, "x": _FORCES, "y": _FORCES, "z": _FORCES,
    "altitude": {"m": 1.0},
    "armed": {"": 1.0},
}  # fmt: skip
"""What a column can hold, and what makes seconds, degrees, m/s² and metres of its units. "acceleration" is the length
of x, y and z."""
ATTITUDES: Final = (("tilt",), ("qw", "qx", "qy", "qz"), ("roll", "pitch"))
FORCES: Final = (("acceleration",), ("x", "y", "z"))
_CHOICES: Final[tuple[tuple[tuple[str, ...], ...], ...]] = (
    (("time",),), ATTITUDES, FORCES, (("altitude",),), (("armed",),),
)  # fmt: skip
# The word of a role on the command line, such as "time_ms".
_ROLES: Final = {
    f"{quantity}_{unit}".rstrip("_"): (quantity, unit) for quantity, units in QUANTITIES.items() for unit in units
}
# How names begin, in front of the unit, if any.
_NAMES: Final = {quantity: quantity for quantity in QUANTITIES} | {
    "timestamp": "time", "elapsed": "time", "t": "time", "q[0]": "qw", "q[1]": "qx", "q[2]": "qy", "q[3]": "qz",
    "acc_x": "x", "acc_y": "y", "acc_z": "z", "accx": "x", "accy": "y", "accz": "z", "ax": "x", "ay": "y", "az": "z",
    "accelerometer_m_s2[0]": "x", "accelerometer_m_s2[1]": "y", "accelerometer_m_s2[2]": "z",
}  # fmt: skip
UNITS: Final = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "ms": "ms", "msec": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "usec": "us", "microseconds": "us", "ns": "ns", "nanoseconds": "ns",
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad", "radian": "rad", "radians": "rad",
    "g": "g", "m/s²": "m_s2", "m/s^2": "m_s2", "m/s2": "m_s2", "m/s/s": "m_s2", "m_s2": "m_s2", "m/s**2": "m_s2",
    "m": "m", "meter": "m", "meters": "m", "metres": "m",
}  # fmt: skip
"""Units as they are written, and as roles end."""
# The quantities of which those without a unit have the same one.
_MEASURED_TOGETHER: Final = (("time",), ("tilt", "roll", "pitch"), ("acceleration", "x", "y", "z"))
# Steps that a log may have. Where more than one unit fits, only one may make a flight of up to `_USUAL_LENGTH_S`.
_STEPS_S: Final = (0.0005, 60.0)
_USUAL_LENGTH_S: Final = 4 * 3600.0
_LARGEST_DEG: Final = 180.5
_TURN_DEG: Final = 360.0
_REST_M_S2: Final = (8.0, 12.0)
_MIN_REST: Final = 0.05
_SHOCK_M_S2: Final = 60.0
_MAX_SHOCKS: Final = 0.1
_MAX_SHOWN: Final = 30


class CsvColumn(NamedTuple):
    name: str
    # As roles end; None for a bare name.
    unit: str | None


CsvColumns = Mapping[str, CsvColumn]
"""By quantity."""


def role_words(columns: CsvColumns) -> list[str]:
    """As they are typed: "roll_deg=ATT.Roll"."""
    return [f"{quantity}_{unit}={name}" if unit else f"{quantity}={name}" for quantity, (name, unit) in columns.items()]


def parse_choice(words: Iterable[str]) -> CsvColumns:
    """Parses words such as `roll_deg=ATT.Roll`. Raises `UserError`."""
    chosen: dict[str, CsvColumn] = {}
    for word in words:
        role, _, name = word.partition("=")
        if role not in _ROLES or not name:
            text = marked("“{word}”: ROLE=COLUMN is needed, of {roles}.")
            raise UserError(text, word=clean(word, longest=60), roles=", ".join(_ROLES))
        quantity, unit = _ROLES[role]
        if quantity in chosen:
            raise UserError(marked("Choose one column for “{quantity}”."), quantity=quantity)
        chosen[quantity] = CsvColumn(name, unit)
    return chosen


def parse_line(line: str) -> CsvColumns:
    """Parses one line as on the command line, with or without `--column`. Raises `UserError`."""
    try:
        words = shlex.split(line)
    except ValueError:  # a quote without its end
        words = line.split()
    return parse_choice(word for word in words if word != "--column")


def recognise(head: Sequence[str], units: Sequence[str], chosen: CsvColumns | None) -> CsvColumns:
    """The columns that are used, some of them still without a unit. `units`: from a line of units; empty where unknown.

    Raises `UserError` where a column that is used is not there, or twice, or has another unit than is said.
    """
    by_person = chosen or {}
    by_name: dict[str, CsvColumn] = {}
    # Where a quantity has several columns, the first one with a unit counts.
    for quantity, column in sorted(map(_meaning, head, units), key=lambda one: one[1].unit is None):
        by_name.setdefault(quantity, column)
    used: dict[str, CsvColumn] = {}
    for choices in _CHOICES:
        is_chosen = any(quantity in by_person for choice in choices for quantity in choice)
        known = by_person if is_chosen else by_name
        whole = [choice for choice in choices if all(quantity in known for quantity in choice)]
        whole.sort(key=lambda choice: any(known[quantity].unit is None for quantity in choice))
        # What is not needed must not make the table unreadable, such as a second attitude with bad cells.
        used.update((quantity, known[quantity]) for choice in whole[:1] for quantity in choice)
    for name, unit in (*by_person.values(), *used.values()):
        if name not in head:
            text = marked("“{name}” is unknown; the columns are {columns}.")
            raise UserError(text, name=clean(name, longest=60), columns=_shown(head))
        if head.count(name) > 1:
            raise UserError(marked("“{name}” is there twice."), name=clean(name, longest=60))
        said = units[head.index(name)]
        if unit and said and said != unit:
            raise UserError(marked("“{name}” is in {unit}."), name=clean(name, longest=60), unit=said)
    if "time" not in used:
        raise _refusal(head, message(marked("No column is known to hold the time.")), {"time": head[0]})
    if not any(choice[0] in used for choice in (*ATTITUDES, *FORCES)):
        why = message(marked("No column is known to hold attitude or acceleration."))
        raise _refusal(head, why, {"tilt": head[-1]})
    return used


def _meaning(name: str, unit: str) -> tuple[str, CsvColumn]:
    """The quantity of a column, and its unit; no quantity for a name that is unknown, or that contradicts its unit."""
    word = name.strip().lower()
    for begin, quantity in _NAMES.items():
        rest = word.removeprefix(begin).strip(" _[]()")
        if word.startswith(begin) and (not rest or rest in UNITS):
            named_unit = UNITS.get(rest, "") or unit
            if unit in ("", named_unit) and named_unit in QUANTITIES[quantity]:
                return quantity, CsvColumn(name, named_unit)
            if not named_unit and quantity != "altitude":  # metres or feet: nothing in it tells
                return quantity, CsvColumn(name, None)
    return "", CsvColumn(name, None)


def resolve(head: Sequence[str], columns: CsvColumns, values: Mapping[str, Floats]) -> dict[str, Floats]:
    """The values by quantity, in the units of `QUANTITIES`; a bare column gets its unit by its values.

    Raises `UserError` where one is not certain.
    """
    units = {quantity: unit for quantity, (_, unit) in columns.items()}
    for together in _MEASURED_TOGETHER:
        bare = [quantity for quantity in together if quantity in columns and units[quantity] is None]
        if bare:
            possible = _possible_units(bare[0], [values[quantity] for quantity in bare])
            if len(possible) != 1:
                text = marked("The unit of “{name}” is not certain.")
                unknown = {quantity: columns[quantity].name for quantity in bare}
                raise _refusal(head, message(text, name=clean(unknown[bare[0]], longest=60)), unknown)
            units.update(dict.fromkeys(bare, possible[0]))
    scaled = {quantity: values[quantity] * QUANTITIES[quantity][unit or ""] for quantity, unit in units.items()}
    for quantity in ("tilt", "roll", "pitch"):
        largest_deg = np.abs(scaled.get(quantity, np.zeros(1)))
        if (largest_deg > _TURN_DEG).any():
            text = marked("“{name}” reaches {value:.0f}°: its unit is another.")
            name = clean(columns[quantity].name, longest=60)
            raise UserError(text, name=name, value=float(np.nanmax(largest_deg)))
    return scaled


def _refusal(head: Sequence[str], why: UserMessage, unknown: Mapping[str, str]) -> UserError:
    """Why, the columns that are there, and what to say of the unknown ones, as it has to be typed."""
    likely = {quantity: CsvColumn(name, next(iter(QUANTITIES[quantity]))) for quantity, name in unknown.items()}
    cure = " ".join(f"--column {shlex.quote(word)}" for word in role_words(likely))
    text = marked("{why} Say which column holds what, in which unit: {cure} (columns: {columns}).")
    return UserError(text, why=why, columns=_shown(head), cure=cure)


def _shown(head: Sequence[str]) -> str:
    return ", ".join(clean(name, longest=40) for name in head[:_MAX_SHOWN])


def _possible_units(quantity: str, columns: Sequence[Floats]) -> list[str]:
    """The units in which these columns, all of one kind of quantity, can be of a flight."""
    scales = QUANTITIES[quantity]
    known = np.isfinite(sum(columns))
    columns = [column[known] for column in columns]
    if not known.any():
        return []
    possible = [unit for unit in scales if _is_plausible(quantity, unit, [one * scales[unit] for one in columns])]
    if quantity == "time" and len(possible) > 1:
        return [unit for unit in possible if np.ptp(columns[0]) * scales[unit] <= _USUAL_LENGTH_S]
    return possible


def _is_plausible(quantity: str, unit: str, columns: Sequence[Floats]) -> bool:
    """`columns`: known values, in seconds, degrees or m/s² if their unit is this one."""
    if quantity == "time":
        steps_s = np.diff(columns[0])
        steps_s = steps_s[steps_s > 0]
        if not len(steps_s) or not SHORTEST_LOG_S <= np.ptp(columns[0]) <= LONGEST_LOG_S:
            return False
        return bool(_STEPS_S[0] <= np.median(steps_s) <= _STEPS_S[1])
    if quantity in ("tilt", "roll", "pitch"):
        # Degrees may be few; only an angle that is none in a unit tells, such as hundredths of degrees.
        return float(np.abs(columns).max()) <= (_TURN_DEG if unit == "deg" else _LARGEST_DEG)
    # An aircraft is at rest for a part of the time, and survives few shocks.
    force_m_s2 = np.sqrt(sum(column * column for column in columns))
    is_rest = (force_m_s2 >= _REST_M_S2[0]) & (force_m_s2 <= _REST_M_S2[1])
    return bool(is_rest.mean() >= _MIN_REST and (force_m_s2 > _SHOCK_M_S2).mean() <= _MAX_SHOCKS)
