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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.captures.entries import CaptureEntry, Way
from app.text.user_error import UserError
from protocol.translatable import marked

SUFFIX: Final = ".mcap"
FORMAT: Final = "dps-s session"
END: Final = "dps-s end"
OLD_EXPORT: Final = "dps-s recording"
"""In files that versions before session files exported."""
VERSION: Final = 1
RX, TX, EVENTS, STATUS, PROGRESS = "/line/rx", "/line/tx", "/events", "/status", "/progress"
LINE_ENCODING: Final = "dps-s-line-1"
TOPIC_OF_WAY: Final = {Way.IN: RX, Way.OUT: TX}
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
NANOSECONDS: Final = 1_000_000_000
MAX_UPTIME_S: Final = 1e9
"""About thirty years."""
_FIRST_YEAR: Final = 1970
_LAST_YEAR: Final = 2200
_COUNT = np.dtype("<u4")
_MAX_OFFSET_NS: Final = 0xFFFFFFFF


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
    part: int = 1
    sequence: int = 0
    """Ascending number within the library, the same for all parts of a session; 0: unknown."""

    @property
    def wall_offset_s(self) -> float:
        """Seconds since 1970 minus monotonic seconds."""
        return self.started_at.timestamp() - self.start_s

    @property
    def wall_offset_ns(self) -> int:
        return round(self.wall_offset_s * 1e6) * 1000

    def fields(self) -> dict[str, str]:
        """The metadata record."""
        values = {key: str(value) for key, value in asdict(self).items()}
        values |= {"version": str(VERSION), "started_at": self.started_at.isoformat(), "start_s": repr(self.start_s)}
        return with_checksum({key: _storable(value) for key, value in values.items()})


def _storable(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()


def with_checksum(fields: Mapping[str, str]) -> dict[str, str]:
    """The fields and the CRC-32 of their lines "name=value", in order of the names."""
    lines = "".join(f"{key}={fields[key]}\n" for key in sorted(fields) if key != CHECKSUM)
    return {**fields, CHECKSUM: f"{zlib.crc32(lines.encode()):08x}"}


def is_whole(fields: Mapping[str, str]) -> bool:
    return with_checksum(fields)[CHECKSUM] == fields.get(CHECKSUM)


def opening_of(fields: Mapping[str, str]) -> Opening:
    """The heading in a metadata record. Raises `UserError`."""
    if not is_whole(fields):
        raise UserError(marked("damaged heading"))
    try:
        if fields["version"] != str(VERSION):
            raise UserError(marked("written by a newer version"))
        started_at, start_s = datetime.fromisoformat(fields["started_at"]), float(fields["start_s"])
        if started_at.tzinfo is None or not _FIRST_YEAR <= started_at.year <= _LAST_YEAR or not is_time(start_s):
            raise ValueError(started_at)
        return Opening(
            started_at=started_at,
            start_s=start_s,
            port=fields["port"],
            baud_rate=int(fields["baud_rate"]),
            module=fields["module"],
            station=fields["station"],
            program=fields["program"],
            part=int(fields["part"]),
            sequence=int(fields["sequence"]),
        )
    except (ValueError, KeyError, OverflowError) as error:
        raise UserError(marked("damaged heading")) from error


# Messages


def json_bytes(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode("utf-8", "backslashreplace")


def json_fields(data: bytes) -> dict[str, object]:
    """Empty for anything but an object."""
    try:
        found = json.loads(data)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def line_messages(entries: Iterable[tuple[int, bytes]]) -> Iterator[tuple[int, bytes]]:
    """Messages of /line/…, each as log time and data, for entries of time in ns and bytes. Usually it is one."""
    some: list[tuple[int, bytes]] = []
    for entry in entries:
        if some and entry[0] - some[0][0] > _MAX_OFFSET_NS:
            yield _line_message(some)
            some = []
        some.append(entry)
    if some:
        yield _line_message(some)


def _line_message(entries: Sequence[tuple[int, bytes]]) -> tuple[int, bytes]:
    times, raws = zip(*entries, strict=True)
    columns = np.array([[at - times[0] for at in times], [len(raw) for raw in raws]], _COUNT)
    return times[0], b"".join((np.array(len(raws), _COUNT).tobytes(), columns.tobytes(), *raws))


@dataclass(frozen=True, slots=True)
class LinePart:
    """Bytes of one direction. `times_ns`, `lengths`: of the reads or writes that they came in."""

    times_ns: NDArray[np.int64]
    lengths: NDArray[np.int64]
    raw: bytes


def line_part(messages: Iterable[tuple[int, bytes]]) -> LinePart:
    """Joins messages of one direction, given as log time and data; one that contradicts itself is left out."""
    whole = [
        (log_ns, count, data)
        for log_ns, data in messages
        if (count := int.from_bytes(data[:4], "little")) and len(data) > 4 + 8 * count
    ]
    if not whole:
        return LinePart(np.empty(0, np.int64), np.empty(0, np.int64), b"")
    counts = np.array([count for _, count, _ in whole])
    lengths = np.frombuffer(b"".join(data[4 + 4 * n : 4 + 8 * n] for _, n, data in whole), _COUNT).astype(np.int64)
    totals = np.add.reduceat(lengths, np.cumsum(counts) - counts)
    is_good = totals == [len(data) - 4 - 8 * count for _, count, data in whole]
    if not is_good.all():
        return line_part((one[0], one[2]) for one, good in zip(whole, is_good.tolist(), strict=True) if good)
    offsets = np.frombuffer(b"".join(data[4 : 4 + 4 * n] for _, n, data in whole), _COUNT)
    times = np.repeat(np.array([log_ns for log_ns, _, _ in whole], np.int64), counts) + offsets
    return LinePart(times, lengths, b"".join(data[4 + 8 * n :] for _, n, data in whole))


def entries_of_line(received: LinePart, sent: LinePart, start_ns: int) -> list[CaptureEntry]:
    """Both directions in order; times count from `start_ns`."""
    merged: list[tuple[int, Way, bytes]] = []
    for way, part in ((Way.IN, received), (Way.OUT, sent)):
        ends = np.cumsum(part.lengths)
        spans = zip((ends - part.lengths).tolist(), ends.tolist(), strict=True)
        merged += [
            (at, way, part.raw[first:end]) for at, (first, end) in zip(part.times_ns.tolist(), spans, strict=True)
        ]
    merged.sort(key=lambda entry: entry[0])
    return [CaptureEntry((at - start_ns) / NANOSECONDS, way, raw) for at, way, raw in merged]
