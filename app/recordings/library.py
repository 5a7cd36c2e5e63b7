"""Library of recordings: list, pin, delete, prune."""

import errno
import os
import threading
import time
from contextlib import suppress
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from app.engine.target import is_simulated
from app.recordings.session_format import SUFFIX
from app.recordings.session_reader import read_heading
from app.system.files import lock, private_opener
from app.system.folders import data_folder
from app.text.messages import UserMessage, message
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_BYTES = 5 * 1024**3 // 2
_PINNED: Final = ".kept"
SETTLED_S: Final = 2.0
"""More than a step of any file system's times."""
_DISK_FULL = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
_HELD: Final = frozenset({errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK})


def recordings_folder() -> Path:
    """In this user's folder for the program's data."""
    return data_folder() / "recordings"


class RecordingEntry(NamedTuple):
    path: Path
    started_at: datetime
    """Aware, UTC."""
    port: str = ""
    baud_rate: int = 0
    module: str = ""
    duration_s: float = 0.0
    sample_count: int = 0
    """Status reports."""
    size_bytes: int = 0
    is_pinned: bool = False
    """Never pruned."""
    is_running: bool = False
    """Being written, by this or another program."""
    was_cut_off: bool = False
    """Not closed properly; valid up to there."""
    trouble: UserMessage | None = None
    sequence: int = 0
    was_triggered: bool = False
    """A report said that the module has triggered."""

    @property
    def name(self) -> str:
        return self.path.stem

    @property
    def is_simulated(self) -> bool:
        return is_simulated(self.port)


class RecordingLibrary:
    """Thread-safe. `max_bytes` limits the recordings that are not pinned."""

    def __init__(self, folder: Path | None = None, *, max_bytes: int = MAX_BYTES) -> None:
        self.folder = folder or recordings_folder()
        self.max_bytes = max_bytes
        self._pruning = threading.Lock()

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads headings only. Never raises: an unreadable recording is an entry with `trouble`."""
        entries = map(entry_of, _files(self.folder))
        return tuple(
            sorted(entries, key=lambda entry: (entry.sequence, entry.started_at, entry.path.name), reverse=True)
        )

    def next_sequence(self) -> int:
        return 1 + max((entry.sequence for entry in self.entries()), default=0)

    def delete(self, entry: RecordingEntry) -> None:
        """Raises OSError, or `UserError` for one that is being written."""
        self._own(entry)
        if is_held(entry.path):
            raise UserError(marked("It is being written: not deleted."))
        entry.path.unlink(missing_ok=True)
        _mark_of(entry.path).unlink(missing_ok=True)

    def set_pinned(self, entry: RecordingEntry, *, is_pinned: bool) -> RecordingEntry:
        """Pins or unpins. Returns the new entry. Raises OSError."""
        self._own(entry)
        mark = _mark_of(entry.path)
        if is_pinned:
            open(mark, "ab", opener=private_opener).close()
        else:
            mark.unlink(missing_ok=True)
        return entry._replace(is_pinned=is_pinned)

    def prune(self, max_bytes: int | None = None) -> tuple[RecordingEntry, ...]:
        """Deletes the oldest recordings beyond the limit, and returns them. Pinned and running ones stay and do not
        count. What cannot be deleted is left for the next time."""
        limit, total, gone = self.max_bytes if max_bytes is None else max_bytes, 0, list[RecordingEntry]()
        with self._pruning:
            for entry in self.entries():
                if entry.is_pinned or entry.is_running:
                    continue
                total += entry.size_bytes
                if total > limit:
                    with suppress(OSError, UserError):
                        self.delete(entry)
                        gone.append(entry)
        return tuple(gone)

    def free_space(self) -> None:
        """Where the disk is nearly full: deletes the oldest fifth."""
        self.prune(self.max_bytes * 4 // 5)

    def _own(self, entry: RecordingEntry) -> None:
        """Raises ValueError outside of this library, where nothing may be deleted."""
        if entry.path.parent != self.folder or entry.path.suffix != SUFFIX:
            raise ValueError(f"{entry.path} is not in this library")


def new_path(library: Path, started_at: datetime) -> Path:
    """A path that sorts by time."""
    return library / f"{started_at.astimezone(UTC):%Y%m%dT%H%M%SZ}-{os.urandom(3).hex()}{SUFFIX}"


def entry_of(path: Path) -> RecordingEntry:
    """The present entry of this file; never raises."""
    try:
        status = path.stat()
        size_bytes, modified_s = status.st_size, status.st_mtime
    except OSError:
        size_bytes, modified_s = 0, 0.0
    is_running = is_held(path)
    try:
        # One that was just written may change again without another size and time.
        read = _read_entry if time.time() - modified_s > SETTLED_S else _read_entry.__wrapped__
        entry = read(path, size_bytes, modified_s)
    except (OSError, UserError) as error:
        at = datetime.fromtimestamp(modified_s, UTC)
        entry = RecordingEntry(path, at, size_bytes=size_bytes, trouble=unreadable(path, error))
    return entry._replace(
        is_pinned=_mark_of(path).exists(), is_running=is_running, was_cut_off=entry.was_cut_off and not is_running
    )


@lru_cache(maxsize=10_000)
def _read_entry(path: Path, size_bytes: int, _modified_s: float) -> RecordingEntry:
    """Once for each state of a file: with a thousand of them, reading takes the recorder half a second at each
    connection. Raises OSError, `UserError`."""
    file = read_heading(path)
    opening = file.opening
    return RecordingEntry(
        path=path,
        started_at=opening.started_at,
        port=opening.port,
        baud_rate=opening.baud_rate,
        module=opening.module,
        duration_s=max(0.0, file.end_ns / 1e9 - opening.started_at.timestamp()),
        sample_count=file.reports,
        size_bytes=size_bytes,
        was_cut_off=not file.is_ended,
        sequence=opening.sequence,
        was_triggered=file.was_triggered,
    )


def is_held(path: Path) -> bool:
    """Whether this or another program is writing the file."""
    try:
        file = path.open("rb")
    except OSError:
        return False
    with file:
        try:
            lock(file, is_shared=True)
        except OSError as error:
            # Other errors come from file systems without locks.
            return error.errno in _HELD
    return False


def _files(place: Path) -> list[Path]:
    try:
        return [file for file in place.iterdir() if file.suffix == SUFFIX and not file.name.startswith(".")]
    except OSError:
        return []


def _mark_of(path: Path) -> Path:
    return path.with_suffix(_PINNED)


def unreadable(path: Path, error: Exception) -> UserMessage:
    why = error.message if isinstance(error, UserError) else error_text(error)
    return message(marked("{file} cannot be read: {why}."), file=path.name, why=why)


def stopped_message(error: Exception, folder: Path) -> UserMessage:
    if isinstance(error, OSError) and error.errno in _DISK_FULL:
        return message(marked("Not recording: the disk is full. Free some space, then connect again."))
    return message(marked("Not recording to {folder}: {why}."), folder=folder, why=error_text(error))
