"""Which columns of a table hold what, and in which unit: chosen by a person, or recognised by name.

A name with its unit is taken at its word. A bare name, such as "timestamp", gets the one unit that is plausible for a
flight; where none is, or more than one, the table is refused with its columns and what to say. Nothing is guessed.
"""

import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from app.flights.cells import UNITS
from app.flights.flight_log import LONGEST_LOG_S, SHORTEST_LOG_S, Floats
from app.flights.raw_log import STANDARD_GRAVITY_M_S2, force_of_axes, tilt_of_quaternion, tilt_of_roll_and_pitch
from app.text.messages import UserMessage, clean, message
from app.text.user_error import UserError
from protocol.translatable import marked


class CsvRole(Enum):
    """Content of a column; the value is its name on the command line."""

    TIME_S = "time_s"
    TIME_MS = "time_ms"
    TIME_US = "time_us"
    TIME_NS = "time_ns"
    TILT_DEG = "tilt_deg"
    TILT_RAD = "tilt_rad"
    ROLL_DEG = "roll_deg"
    PITCH_DEG = "pitch_deg"
    ROLL_RAD = "roll_rad"
    PITCH_RAD = "pitch_rad"
    QW = "qw"
    QX = "qx"
    QY = "qy"
    QZ = "qz"
    ACCELERATION_G = "acceleration_g"
    """Length of the specific force."""
    ACCELERATION_M_S2 = "acceleration_m_s2"
    X_G = "x_g"
    Y_G = "y_g"
    Z_G = "z_g"
    X_M_S2 = "x_m_s2"
    Y_M_S2 = "y_m_s2"
    Z_M_S2 = "z_m_s2"
    ALTITUDE_M = "altitude_m"
    ARMED = "armed"
    """Not 0: armed."""


TIMES: Final[Mapping[CsvRole, float]] = {
    CsvRole.TIME_S: 1.0, CsvRole.TIME_MS: 1e-3, CsvRole.TIME_US: 1e-6, CsvRole.TIME_NS: 1e-9,
}  # fmt: skip
"""Unit of each in seconds."""
Computed = Mapping[tuple[CsvRole, ...], Callable[..., Floats]]
ATTITUDES: Final[Computed] = {
    (CsvRole.TILT_DEG,): np.abs,
    (CsvRole.TILT_RAD,): lambda tilt: np.degrees(np.abs(tilt)),
    (CsvRole.QW, CsvRole.QX, CsvRole.QY, CsvRole.QZ): tilt_of_quaternion,
    (CsvRole.ROLL_DEG, CsvRole.PITCH_DEG): tilt_of_roll_and_pitch,
    (CsvRole.ROLL_RAD, CsvRole.PITCH_RAD): lambda *rad: tilt_of_roll_and_pitch(*np.degrees(rad)),
}
"""Roles, and the tilt of their columns."""
FORCES: Final[Computed] = {
    (CsvRole.ACCELERATION_G,): np.abs,
    (CsvRole.ACCELERATION_M_S2,): lambda length: np.abs(length) / STANDARD_GRAVITY_M_S2,
    (CsvRole.X_G, CsvRole.Y_G, CsvRole.Z_G): lambda *g: force_of_axes(*(axis * STANDARD_GRAVITY_M_S2 for axis in g)),
    (CsvRole.X_M_S2, CsvRole.Y_M_S2, CsvRole.Z_M_S2): force_of_axes,
}
"""Roles, and the specific force of their columns."""
_GROUPS: Final = (frozenset(TIMES), frozenset().union(*ATTITUDES), frozenset().union(*FORCES))
"""Of each group a person chooses all columns, or none."""
_ALSO: Final[Mapping[str, str]] = {
    "elapsed_s": "time_s", "t_s": "time_s", "seconds": "time_s", "t_ms": "time_ms", "timems": "time_ms",
    "t_us": "time_us", "timeus": "time_us", "t_ns": "time_ns",
    "q[0]": "qw", "q[1]": "qx", "q[2]": "qy", "q[3]": "qz",
    "accelerometer_m_s2[0]": "x_m_s2", "accelerometer_m_s2[1]": "y_m_s2", "accelerometer_m_s2[2]": "z_m_s2",
}  # fmt: skip
"""Further names with their unit."""
_BARE: Final[Mapping[str, str]] = {
    "time": "time", "timestamp": "time", "t": "time", "tilt": "tilt", "roll": "roll", "pitch": "pitch",
    "acceleration": "acceleration", "acc_x": "x", "acc_y": "y", "acc_z": "z", "accx": "x", "accy": "y", "accz": "z",
    "ax": "x", "ay": "y", "az": "z",
}  # fmt: skip
"""Names without a unit, and what they are of."""
_UNITS_OF: Final[Mapping[str, tuple[str, ...]]] = {
    "time": ("s", "ms", "us", "ns"), "tilt": ("deg", "rad"), "roll": ("deg", "rad"), "pitch": ("deg", "rad"),
    "acceleration": ("g", "m_s2"), "x": ("g", "m_s2"), "y": ("g", "m_s2"), "z": ("g", "m_s2"),
}  # fmt: skip
_BARE_ATTITUDES: Final = (("tilt",), ("roll", "pitch"))
_BARE_FORCES: Final = (("acceleration",), ("x", "y", "z"))
_IN_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(]([^\[\]()]+)[\])]")
_STEPS_S: Final = (0.0005, 60.0)
"""Steps that a log may have. Where more than one unit fits, only one may make a flight of up to `_USUAL_LENGTH_S`."""
_USUAL_LENGTH_S: Final = 4 * 3600.0
_REST_G: Final = (0.8, 1.25)
_MIN_REST: Final = 0.05
"""Share of a flight at rest by which the unit of an acceleration is known."""
_SHOCK_G: Final = 6.0
_MAX_SHOCKS: Final = 0.1
"""Share of a flight above `_SHOCK_G` that no aircraft survives."""
_MAX_SHOWN: Final = 30


@dataclass(frozen=True, slots=True)
class CsvColumns:
    """Column names by role."""

    names: Mapping[CsvRole, str]

    @property
    def time(self) -> CsvRole | None:
        return next((role for role in TIMES if role in self.names), None)

    @property
    def attitude(self) -> tuple[CsvRole, ...]:
        """Roles from which the tilt is computed; may be empty."""
        return next((roles for roles in ATTITUDES if all(role in self.names for role in roles)), ())

    @property
    def force(self) -> tuple[CsvRole, ...]:
        """Roles from which the specific force is computed; may be empty."""
        return next((roles for roles in FORCES if all(role in self.names for role in roles)), ())


def parse_choice(words: Sequence[str]) -> CsvColumns:
    """Parses words such as `roll_deg=ATT.Roll`. Raises `UserError`."""
    names: dict[CsvRole, str] = {}
    by_word = {role.value: role for role in CsvRole}
    for word in words:
        key, equals, name = word.partition("=")
        role = by_word.get(key)
        if role is None or not equals or not name:
            text, roles = marked("“{word}”: ROLE=COLUMN is needed, of {roles}."), ", ".join(by_word)
            raise UserError(text, word=clean(word, longest=60), roles=roles)
        names[role] = name
    if sum(role in TIMES for role in names) > 1:
        raise UserError(marked("Choose the one column with the time."))
    return CsvColumns(names)


def parse_line(line: str) -> CsvColumns:
    """Parses one line as on the command line, with or without `--column`. Raises `UserError`."""
    try:
        words = shlex.split(line)
    except ValueError:  # a quote without its end
        words = line.split()
    return parse_choice([word for word in words if word != "--column"])


class Recognised:
    """The columns of one table: `names` by role, and `bare` by what they are of, whose unit the values have to tell.

    `units`: of each column, from a line of units or from the cells; empty where unknown.
    """

    def __init__(self, head: Sequence[str], units: Sequence[str], chosen: CsvColumns | None) -> None:
        """Raises `UserError` where a chosen column is not there, or twice."""
        self._head = head
        self.names: dict[CsvRole, str] = {}
        self.bare: dict[str, str] = {}
        chosen_names = {} if chosen is None else chosen.names
        for name, unit in zip(head, units, strict=True):
            self._recognise(name, unit)
        for group in _GROUPS:
            if group & chosen_names.keys():
                stems = {role.value.partition("_")[0] for role in group}
                self.names = {role: name for role, name in self.names.items() if role not in group}
                self.bare = {stem: name for stem, name in self.bare.items() if stem not in stems}
        self.names.update(chosen_names)
        unit_of = dict(zip(head, units, strict=True))
        for role, name in chosen_names.items():
            unit = unit_of.get(name, "")
            if unit and not role.value.endswith(f"_{unit}"):
                text = marked("“{name}” is in {unit}.")
                raise UserError(text, name=clean(name, longest=60), unit=unit)
        self._drop_unused()
        if CsvColumns(self.names).time is not None:
            self.bare.pop("time", None)
        for name in (*self.names.values(), *self.bare.values()):
            if name not in head:
                shown = ", ".join(clean(one, longest=40) for one in head[:_MAX_SHOWN])
                raise UserError(
                    marked("“{name}” is unknown; the columns are {columns}."),
                    name=clean(name, longest=60),
                    columns=shown,
                )
            if head.count(name) > 1:
                raise UserError(marked("“{name}” is there twice."), name=clean(name, longest=60))

    def _drop_unused(self) -> None:
        """What is not needed must not make the table unreadable, such as a second attitude with bad cells."""
        columns = CsvColumns(self.names)
        used = {*columns.attitude, *columns.force, CsvRole.ALTITUDE_M, CsvRole.ARMED}
        if columns.time is not None:
            used.add(columns.time)
        self.names = {role: name for role, name in self.names.items() if role in used}
        wanted = {"time"}
        if not columns.attitude:
            wanted.update(self._first_whole(_BARE_ATTITUDES))
        if not columns.force:
            wanted.update(self._first_whole(_BARE_FORCES))
        self.bare = {stem: name for stem, name in self.bare.items() if stem in wanted}

    def _first_whole(self, choices: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
        """The first choice of bare columns that are all there."""
        whole = (stems for stems in choices if all(stem in self.bare for stem in stems))
        return next(whole, ())

    def quantity_of(self, name: str) -> str:
        """What a used column is of, such as "time"."""
        found = [role.value for role, known in self.names.items() if known == name]
        found += [stem for stem, known in self.bare.items() if known == name]
        return found[0].partition("_")[0]

    def _recognise(self, name: str, unit: str) -> None:
        word = name.strip().lower()
        bracketed = _IN_BRACKETS.fullmatch(word)
        if bracketed is not None and bracketed[2].strip() in UNITS:
            word, named_unit = bracketed[1], UNITS[bracketed[2].strip()]
            if unit not in ("", named_unit):
                return  # it contradicts itself
            unit = named_unit
        word = word.replace(" ", "_")
        word = _ALSO.get(word, word)
        role = next((role for role in CsvRole if role.value == word), None)
        if role is not None:
            if unit and role is not CsvRole.ARMED and not word.endswith(f"_{unit}"):
                return
            if role in TIMES and CsvColumns(self.names).time is not None:
                return  # the first one counts
            self.names.setdefault(role, name)
            return
        stem = _BARE.get(word)
        if stem is None:
            return
        if unit in _UNITS_OF[stem]:
            role = CsvRole(f"{stem}_{unit}")
            if role not in TIMES or CsvColumns(self.names).time is None:
                self.names.setdefault(role, name)
        elif not unit:
            self.bare.setdefault(stem, name)

    def resolve(self, values: Mapping[str, Floats]) -> CsvColumns:
        """Gives each bare column its unit, by its values. Raises `UserError` where one is not certain."""
        columns = CsvColumns(self.names)
        names = dict(self.names)
        if columns.time is None:
            if "time" not in self.bare:
                raise self.refusal_of_time()
            self._add(names, ("time",), time_units(values[self.bare["time"]]))
        if not columns.attitude:
            stems = self._first_whole(_BARE_ATTITUDES)
            if stems:
                self._add(names, stems, angle_units(*(values[self.bare[stem]] for stem in stems)))
        if not columns.force:
            stems = self._first_whole(_BARE_FORCES)
            if stems:
                self._add(names, stems, force_units(*(values[self.bare[stem]] for stem in stems)))
        columns = CsvColumns(names)
        if not columns.attitude and not columns.force:
            why = message(marked("No column is known to hold attitude or acceleration."))
            raise self.refusal(why, {"tilt": self._head[-1]})
        return columns

    def _add(self, names: dict[CsvRole, str], stems: Sequence[str], units: Sequence[str]) -> None:
        """Gives bare columns, which belong together, their one possible unit."""
        bare = {stem: self.bare[stem] for stem in stems}
        if len(units) != 1:
            text = marked("The unit of “{name}” is not certain.")
            raise self.refusal(message(text, name=clean(bare[stems[0]], longest=60)), bare)
        for stem, name in bare.items():
            names[CsvRole(f"{stem}_{units[0]}")] = name

    def refusal_of_time(self) -> UserError:
        return self.refusal(message(marked("No column is known to hold the time.")), {"time": self._head[0]})

    def refusal(self, why: UserMessage, unknown: Mapping[str, str]) -> UserError:
        """Why, the columns that are there, and what to say of the unknown ones, as it has to be typed."""
        shown = ", ".join(clean(name, longest=40) for name in self._head[:_MAX_SHOWN])
        words = [f"{stem}_{_UNITS_OF[stem][0]}={name}" for stem, name in unknown.items()]
        cure = " ".join(f"--column {shlex.quote(word)}" for word in words)
        text = marked("{why} Say which column holds what, in which unit: {cure} (columns: {columns}).")
        return UserError(text, why=why, columns=shown, cure=cure)


def time_units(values: Floats) -> list[str]:
    """The units in which these can be the times of a flight: by its length and its steps."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    steps = steps[steps > 0]
    if not len(steps):
        return []
    step, length = float(np.median(steps)), float(np.ptp(known))
    possible: list[str] = []
    usual: list[str] = []
    for role, scale in TIMES.items():
        if _STEPS_S[0] <= step * scale <= _STEPS_S[1] and SHORTEST_LOG_S <= length * scale <= LONGEST_LOG_S:
            unit = role.value.removeprefix("time_")
            possible.append(unit)
            if length * scale <= _USUAL_LENGTH_S:
                usual.append(unit)
    return usual if len(possible) > 1 else possible


def angle_units(*angles: Floats) -> list[str]:
    """Degrees where one of them is larger than any in radians; else they can be either."""
    largest = max(float(np.nanmax(np.abs(angle), initial=0.0)) for angle in angles)
    return ["deg"] if largest > np.pi + 0.01 else ["deg", "rad"]


def force_units(*axes: Floats) -> list[str]:
    """The units in which an aircraft is at rest for a part of the time, as every one is."""
    length = np.sqrt(sum(axis * axis for axis in axes))
    length = length[np.isfinite(length)]
    if not len(length):
        return []
    found: list[str] = []
    for unit, scale in (("g", 1.0), ("m_s2", 1 / STANDARD_GRAVITY_M_S2)):
        is_rest = (length * scale >= _REST_G[0]) & (length * scale <= _REST_G[1])
        if is_rest.mean() >= _MIN_REST and (length * scale > _SHOCK_G).mean() <= _MAX_SHOCKS:
            found.append(unit)
    return found
