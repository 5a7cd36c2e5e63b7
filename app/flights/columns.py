"""Which columns of a CSV file hold what: chosen by a person, or recognised by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from app.flights.flight_log import Floats, unreadable
from app.flights.raw_log import STANDARD_GRAVITY_M_S2, force_of_axes, tilt_of_quaternion, tilt_of_roll_and_pitch
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked


class CsvRole(Enum):
    """Content of a column; the value is its name on the command line."""

    TIME_S = "time_s"
    TIME_MS = "time_ms"
    TIME_US = "time_us"
    TILT_DEG = "tilt_deg"
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


TIMES: Final[Mapping[CsvRole, float]] = {CsvRole.TIME_S: 1.0, CsvRole.TIME_MS: 1e-3, CsvRole.TIME_US: 1e-6}
"""Unit of each in seconds."""
NO_TIME: Final = marked("one column must be time_s, time_ms or time_us")
Computed = Mapping[tuple[CsvRole, ...], Callable[..., Floats]]
ATTITUDES: Final[Computed] = {
    (CsvRole.TILT_DEG,): np.abs,
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
_USUAL: Final[Mapping[CsvRole, tuple[str, ...]]] = {
    CsvRole.TIME_S: ("elapsed_s", "t_s", "time_s", "seconds"),
    CsvRole.TIME_MS: ("t_ms", "time_ms", "timems"),
    CsvRole.TIME_US: ("t_us", "time_us", "timeus", "timestamp"),
    CsvRole.QW: ("qw", "q[0]"),
    CsvRole.QX: ("qx", "q[1]"),
    CsvRole.QY: ("qy", "q[2]"),
    CsvRole.QZ: ("qz", "q[3]"),
}
"""Further column names that are recognised. `timestamp`: microseconds, as in PX4's exports."""


@dataclass(frozen=True, slots=True)
class CsvColumns:
    """Column names by role. Raises `UserError` where they are not enough."""

    names: Mapping[CsvRole, str]

    def __post_init__(self) -> None:
        if sum(role in self.names for role in TIMES) != 1:
            raise unreadable(NO_TIME)
        if not self.attitude and not self.force:
            raise unreadable(marked("no attitude and no acceleration"))

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
    return CsvColumns(names)


def recognised(head: Sequence[str]) -> CsvColumns:
    """Recognises columns by their names. Raises `UserError`."""
    places = {name.strip().lower(): name for name in reversed(head)}
    names: dict[CsvRole, str] = {}
    for role in CsvRole:
        column = next((places[name] for name in (role.value, *_USUAL.get(role, ())) if name in places), None)
        if column is not None and not (role in TIMES and names.keys() & TIMES.keys()):
            names[role] = column
    return CsvColumns(names)
