"""Binary layout of recording files; docs/recording.md describes it for other programs.

A session is a folder with an append-only file for each column. A commit, written up to twice a second, states the
length of each file. Data behind the last commit is ignored, so a recording that was cut off is valid up to there.
"""

import errno
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import IO, Final

from app.captures.writer import Header
from app.system.files import lock, private_opener
from protocol.translatable import marked

FORMAT: Final = "dps-s recording"
VERSION: Final = 1
SESSION, COMMITS, JOURNAL, LINE, LOCK, PINNED = (
    "session.json", "commits.bin", "journal.jsonl", "line.dpscap", "lock", "kept"
)  # fmt: skip
COLUMNS: Final[Mapping[str, Mapping[str, str]]] = MappingProxyType(
    {
        "status": {
            "status.time_s.f8": "<f8",
            "status.tilt_deg.f4": "<f4",
            "status.acceleration_g.f4": "<f4",
            "status.flags.u1": "u1",
        },
        "cell": {"cell.time_s.f8": "<f8", "cell.voltage_v.f4": "<f4"},
        "light": {"light.time_s.f8": "<f8", "light.voltage_v.f4": "<f4"},
    }
)
"""Columns of each table with their numpy types."""
DATA_FILES: Final = (*(name for table in COLUMNS.values() for name in table), LINE, JOURNAL)
"""In the order of writing and of a commit's checksum."""
ACTIVE, TRIGGERED = 0x01, 0x02
"""Bits of `status.flags.u1`."""
_FIRST_YEAR: Final = 1970
_LAST_YEAR: Final = 2200
_MAX_HEADING_LENGTH: Final = 64 * 1024
_HELD: Final = frozenset({errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK})


MAX_UPTIME_S: Final = 1e9
"""About thirty years."""


def is_time(value: float) -> bool:
    """Whether this is plausible as monotonic seconds."""
    return abs(value) <= MAX_UPTIME_S  # false for NaN


class Unreadable(ValueError):
    """The folder is no readable recording; the message is English, marked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening:
    """Content of `session.json`. `start_s` is monotonic; `started_at` is the same moment in UTC."""

    started_at: datetime
    start_s: float
    port: str
    baud_rate: int
    module: str = ""
    program: str = ""
    part: int = 1
    sequence: int = 0
    """Ascending number within the library; 0 in recordings of versions without it."""

    @property
    def wall_offset_s(self) -> float:
        """Seconds since 1970 minus monotonic seconds."""
        return self.started_at.timestamp() - self.start_s

    @property
    def capture_header(self) -> Header:
        """Of the bytes on the line."""
        started = self.started_at.isoformat()
        return Header(program=self.program, port=self.port, baud_rate=self.baud_rate, started=started)

    def encoded(self) -> bytes:
        fields = {"format": FORMAT, "version": VERSION, **asdict(self), "started_at": self.started_at.isoformat()}
        return json.dumps(fields, indent=1, ensure_ascii=False).encode("utf-8", "backslashreplace") + b"\n"


def read_opening(folder: Path) -> Opening:
    """Raises `Unreadable`, OSError."""
    with (folder / SESSION).open("rb") as file:
        raw = file.read(_MAX_HEADING_LENGTH)
    try:
        fields = json.loads(raw)
        if fields["format"] != FORMAT:
            raise Unreadable(marked("not a recording by this program"))
        if fields["version"] != VERSION:
            raise Unreadable(marked("written by a newer version"))
        started_at = datetime.fromisoformat(fields["started_at"])
        if started_at.tzinfo is None or not is_time(float(fields["start_s"])):
            raise ValueError(started_at)
        if not _FIRST_YEAR <= started_at.year <= _LAST_YEAR:
            raise ValueError(started_at)
        return Opening(
            started_at=started_at,
            start_s=float(fields["start_s"]),
            port=str(fields["port"]),
            baud_rate=int(fields["baud_rate"]),
            module=str(fields.get("module", "")),
            program=str(fields.get("program", "")),
            part=int(fields.get("part", 1)),
            sequence=int(fields.get("sequence", 0)),
        )
    except Unreadable:
        raise
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
        raise Unreadable(marked("damaged heading")) from error


def hold(folder: Path) -> IO[bytes] | None:
    """Locks the session until the returned file is closed or the program ends.

    None where it is locked already. Raises OSError.
    """
    file = open(folder / LOCK, "ab", opener=private_opener)  # noqa: SIM115
    try:
        lock(file)
    except OSError:
        file.close()
        return None
    return file


def is_held(folder: Path) -> bool:
    """Whether this or another program is writing the session."""
    try:
        with (folder / LOCK).open("rb+") as file:
            lock(file, is_shared=True)
    except OSError as error:
        # Other errors come from file systems without locks.
        return error.errno in _HELD
    return False


def journal_lines(raw: bytes) -> Iterator[dict[str, object]]:
    """The objects of a journal; skips other lines."""
    for line in raw.splitlines():
        try:
            found = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(found, dict):
            yield found
