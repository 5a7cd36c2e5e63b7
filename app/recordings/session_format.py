"""Format of a recording: MCAP, as docs/recording.md describes it for other programs.

    metadata "dps-s recording"   where, when and by whom it was recorded; never changes
    metadata "dps-s state"       how far it is; of a fixed length, so it is written again in its place
    /line/rx, /line/tx           bytes of the module and of the host, one message for each half second
    /events                      marks, names, limits, polled values, what was sent
    /status                      decoded reports, at most ten a second, for other viewers

What the list of recordings shows is in the two records at the head of the file: ten thousand files are listed within a
second, and a file that was cut off tells as much as one that was closed.
"""

import json
import zlib
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Annotated, Final, TypeVar

import msgspec
from mcap.data_stream import RecordBuilder
from mcap.records import Metadata

from app.captures.line import NANOSECONDS
from app.text.user_error import UserError
from protocol.translatable import marked

SUFFIX: Final = ".mcap"
OPENING: Final = "dps-s recording"
STATE: Final = "dps-s state"
VERSION: Final = 1
RX, TX, EVENTS, STATUS = "/line/rx", "/line/tx", "/events", "/status"
LINE_ENCODING: Final = "dps-s-line-1"
_FLAG: Final = {"type": "boolean"}
_NUMBER: Final = {"type": "number"}
SCHEMAS: Final[Mapping[str, Mapping[str, object]]] = {
    EVENTS: {"event": {"type": "string"}},
    STATUS: {"tilt_deg": _NUMBER, "acceleration_g": _NUMBER, "triggered": _FLAG, "active": _FLAG},
}
"""Required fields of the JSON topics; names include the unit, as in all files of the program."""
MAX_CHUNK_BYTES: Final = 1 << 26
MAX_UPTIME_S: Final = 1e9
"""About thirty years."""
STATE_LENGTH: Final = 2000
"""Characters of the state's JSON; with more names the last ones are left out."""
_YEARS: Final = range(1970, 2201)
Count = Annotated[int, msgspec.Meta(ge=0, le=1 << 40)]


def is_time(value: float) -> bool:
    """Whether this is plausible as seconds of the program's clock."""
    return abs(value) <= MAX_UPTIME_S  # false for NaN


class Opening(msgspec.Struct, frozen=True, kw_only=True):
    """What is known when a recording begins. `start_s` is of the program's clock; `started_at` is the same moment."""

    started_at: datetime
    start_s: float
    port: str
    baud_rate: Count
    station: str = ""
    program: str = ""
    version: int = VERSION

    def __post_init__(self) -> None:
        """Raises ValueError for what no recording has."""
        if self.started_at.tzinfo is None or self.started_at.year not in _YEARS or not is_time(self.start_s):
            raise ValueError("no time of a recording")

    @property
    def wall_offset_ns(self) -> int:
        """Nanoseconds since 1970 minus those of the program's clock; whole microseconds."""
        return round((self.started_at.timestamp() - self.start_s) * 1e6) * 1000

    def wall_ns(self, at_s: float) -> int:
        """A time of the program's clock as files have it."""
        return round(at_s * NANOSECONDS) + self.wall_offset_ns

    def clock_s(self, wall_ns: int) -> float:
        return (wall_ns - self.wall_offset_ns) / NANOSECONDS


class State(msgspec.Struct, frozen=True, kw_only=True):
    """How far the recording is: what a list of recordings shows, and up to where the file must be whole."""

    end_s: float
    chunks: Count = 0
    reports: Count = 0
    was_triggered: bool = False
    modules: tuple[str, ...] = ()
    """The names that were said while it was recorded, in this order."""
    is_ended: bool = False
    """It was closed properly."""

    def __post_init__(self) -> None:
        """Raises ValueError for an end that no recording has."""
        if not is_time(self.end_s):
            raise ValueError("no time of a recording")


Head = TypeVar("Head", Opening, State)


def metadata_record(name: str, head: Opening | State) -> bytes:
    """The MCAP record of an opening or a state."""
    text = _json_text(head)
    if isinstance(head, State):
        while len(text) > STATE_LENGTH:
            head = msgspec.structs.replace(head, modules=head.modules[:-1])
            text = _json_text(head)
        text = text.ljust(STATE_LENGTH)
    builder = RecordBuilder()
    Metadata(name, {"json": text, "crc32": checksum(text)}).write(builder)
    raw: bytes = builder.end()  # type: ignore[no-untyped-call]
    return raw


def _json_text(head: Opening | State) -> str:
    # ASCII, so that the length in bytes does not depend on the names. Names of ports may have bytes that are no text.
    return json.dumps(msgspec.to_builtins(head))


def checksum(text: str) -> str:
    """MCAP has none for metadata."""
    return f"{zlib.crc32(text.encode()):08x}"


def head_of(record: Metadata, kind: type[Head]) -> Head:
    """The opening or state in a record. Raises `UserError` where it is damaged, or of a newer version."""
    text = record.metadata.get("json", "")
    if record.metadata.get("crc32") != checksum(text):
        raise UserError(marked("damaged"))
    try:
        plain = json.loads(text)
        if plain.get("version", VERSION) > VERSION:
            raise UserError(marked("written by a newer version"))
        return msgspec.convert(plain, kind)
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise UserError(marked("damaged")) from error


def time_of(wall_s: float) -> datetime:
    return datetime.fromtimestamp(wall_s, UTC)


def json_bytes(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode("utf-8", "backslashreplace")
