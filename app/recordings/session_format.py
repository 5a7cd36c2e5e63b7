"""Format of a session file: MCAP, as docs/recording.md describes it for other programs.

    metadata "dps-s session"   the heading, with its own checksum; again whenever the module is named
    /line/rx, /line/tx         bytes of the module and of the host, one message for each half second
    /events                    marks, limits, polled values, what was sent
    /status                    decoded reports, at most ten a second, for other viewers
    /progress                  number of reports so far, once in every chunk
    metadata "dps-s end"       the session was closed properly

A chunk holds what came within half a second; its checksum tells whether it is whole.
"""

import json
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Final

from app.captures.line import NANOSECONDS
from app.text.user_error import UserError
from protocol.translatable import marked

SUFFIX: Final = ".mcap"
FORMAT: Final = "dps-s session"
END: Final = "dps-s end"
VERSION: Final = 1
RX, TX, EVENTS, STATUS, PROGRESS = "/line/rx", "/line/tx", "/events", "/status", "/progress"
LINE_ENCODING: Final = "dps-s-line-1"
CHECKSUM: Final = "crc32"
_NUMBER: Final = {"type": "number"}
_FLAG: Final = {"type": "boolean"}
SCHEMAS: Final[Mapping[str, Mapping[str, object]]] = {
    EVENTS: {"event": {"type": "string"}},
    STATUS: {"tilt_deg": _NUMBER, "acceleration_g": _NUMBER, "triggered": _FLAG, "active": _FLAG},
    PROGRESS: {"reports": _NUMBER, "triggered": _FLAG},
}
"""Required fields of the JSON topics; names include the unit, as in all files of the program."""
CHANNELS: Final[Mapping[int, str]] = dict(enumerate((RX, TX, *SCHEMAS), start=1))
"""Their numbers are always the same, so that a file whose first chunk is damaged can still be read."""
MAX_UPTIME_S: Final = 1e9
"""About thirty years."""
_FIRST_YEAR: Final = 1970
_LAST_YEAR: Final = 2200
_LAST_SEQUENCE: Final = 10**15


def is_time(value: float) -> bool:
    """Whether this is plausible as monotonic seconds."""
    return abs(value) <= MAX_UPTIME_S  # false for NaN


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening:
    """The heading. `start_s` is monotonic; `started_at` is the same moment in UTC."""

    started_at: datetime
    start_s: float
    port: str
    baud_rate: int
    module: str = ""
    station: str = ""
    program: str = ""
    sequence: int = 0
    """Ascending number within the library; 0: unknown."""

    def __post_init__(self) -> None:
        """Raises `UserError` for what no recording has, and no reader would take back."""
        is_dated = self.started_at.tzinfo is not None and _FIRST_YEAR <= self.started_at.year <= _LAST_YEAR
        if not (is_dated and is_time(self.start_s) and 0 <= self.sequence <= _LAST_SEQUENCE):
            raise UserError(marked("damaged"))

    @property
    def wall_offset_s(self) -> float:
        """Seconds since 1970 minus monotonic seconds."""
        return self.started_at.timestamp() - self.start_s

    @property
    def wall_offset_ns(self) -> int:
        return round(self.wall_offset_s * 1e6) * 1000

    def wall_ns(self, at_s: float) -> int:
        """A monotonic time as files have it."""
        return round(at_s * NANOSECONDS) + self.wall_offset_ns

    def mono_s(self, wall_ns: int) -> float:
        return (wall_ns - self.wall_offset_ns) / NANOSECONDS

    def fields(self) -> dict[str, str]:
        values = {key: str(value) for key, value in asdict(self).items()}
        values |= {"version": str(VERSION), "started_at": self.started_at.isoformat(), "start_s": repr(self.start_s)}
        storable = {key: value.encode("utf-8", "backslashreplace").decode() for key, value in values.items()}
        return with_checksum(storable)


def with_checksum(fields: Mapping[str, str]) -> dict[str, str]:
    """The fields and the CRC-32 of their lines "name=value", in order of the names."""
    lines = "".join(f"{key}={fields[key]}\n" for key in sorted(fields) if key != CHECKSUM)
    return {**fields, CHECKSUM: f"{zlib.crc32(lines.encode()):08x}"}


def is_whole(fields: Mapping[str, str]) -> bool:
    return with_checksum(fields)[CHECKSUM] == fields.get(CHECKSUM)


def opening_of(fields: Mapping[str, str]) -> Opening:
    """The heading in a metadata record. Raises `UserError`."""
    if not is_whole(fields):
        raise UserError(marked("damaged"))
    try:
        if fields["version"] != str(VERSION):
            raise UserError(marked("written by a newer version"))
        return Opening(
            started_at=datetime.fromisoformat(fields["started_at"]),
            start_s=float(fields["start_s"]),
            port=fields["port"],
            baud_rate=int(fields["baud_rate"]),
            module=fields["module"],
            station=fields["station"],
            program=fields["program"],
            sequence=int(fields["sequence"]),
        )
    except (ValueError, KeyError, OverflowError) as error:
        raise UserError(marked("damaged")) from error


# Messages


def json_bytes(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode("utf-8", "backslashreplace")
