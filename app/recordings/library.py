"""Library of recordings: list, describe, pin, delete, prune."""

import errno
import math
import re
import threading
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

from app.engine.target import is_simulated
from app.recordings.session_file import SUFFIX, read_head
from app.system.files import data_folder, lock, private_opener
from app.text.i18n import tr
from app.text.messages import UserError, UserMessage, error_text, join_names, message, stopwatch
from protocol.translatable import marked

MAX_BYTES: Final = 5 * 1024**3 // 2
_PINNED: Final = ".kept"
_NUMBER: Final = re.compile(r"-(\d{1,9})$")
_DISK_FULL: Final = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
# Other errors of a lock come from file systems without locks.
_HELD: Final = frozenset({errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK})


def recordings_folder() -> Path:
    """In this user's folder for the program's data."""
    return data_folder() / "recordings"


class RecordingEntry(NamedTuple):
    """A recording as the list shows it. `modules`: the names that were said while it was recorded; `is_running`: it is
    being written, by this or another program; `was_cut_off`: it was not closed properly, and is valid up to there."""

    path: Path
    started_at: datetime
    port: str = ""
    baud_rate: int = 0
    modules: tuple[str, ...] = ()
    duration_s: float = 0.0
    sample_count: int = 0
    size_bytes: int = 0
    is_pinned: bool = False
    is_running: bool = False
    was_cut_off: bool = False
    trouble: UserMessage | None = None
    was_triggered: bool = False

    @property
    def name(self) -> str:
        return self.path.stem

    @property
    def module(self) -> str:
        return ", ".join(self.modules)

    @property
    def is_simulated(self) -> bool:
        return is_simulated(self.port)


class RecordingLibrary:
    """Thread-safe. `max_bytes` limits the recordings that are not pinned.

    A file's name has its time and its number. Numbers ascend in the order of recording, so a wrong calendar does no
    harm where the oldest are deleted.
    """

    def __init__(self, folder: Path | None = None, *, max_bytes: int = MAX_BYTES) -> None:
        self.folder = folder or recordings_folder()
        self.max_bytes = max_bytes
        self._pruning = threading.Lock()

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads the heads of the files only. Never raises: an unreadable recording is an entry with
        `trouble`."""
        return tuple(entry_of(path, is_pinned=is_pinned) for path, is_pinned in self._newest_first())

    def new_path(self, started_at: datetime) -> Path:
        """The path of a recording that begins now."""
        number = 1 + max((_number_of(path) for path in self._files(SUFFIX)), default=0)
        return self.folder / f"{started_at.astimezone(UTC):%Y%m%dT%H%M%SZ}-{number:05}{SUFFIX}"

    def delete(self, entry: RecordingEntry) -> None:
        """Raises OSError, or `UserError` for one that is being written."""
        self._own(entry.path)
        if is_held(entry.path):
            raise UserError(marked("It is being written: not deleted."))
        entry.path.unlink(missing_ok=True)
        entry.path.with_suffix(_PINNED).unlink(missing_ok=True)

    def set_pinned(self, entry: RecordingEntry, *, is_pinned: bool) -> RecordingEntry:
        """Pins or unpins. Returns the new entry. Raises OSError."""
        self._own(entry.path)
        mark = entry.path.with_suffix(_PINNED)
        if is_pinned:
            open(mark, "ab", opener=private_opener).close()
        else:
            mark.unlink(missing_ok=True)
        return entry._replace(is_pinned=is_pinned)

    def prune(self) -> None:
        """Deletes the oldest recordings beyond the limit. Pinned ones stay and do not count, running ones stay. What
        cannot be deleted is left for the next time."""
        total = 0
        with self._pruning:
            for path, is_pinned in self._newest_first():
                if is_pinned:
                    continue
                with suppress(OSError):
                    total += path.stat().st_size
                    if total > self.max_bytes and not is_held(path):
                        path.unlink()

    def _newest_first(self) -> list[tuple[Path, bool]]:
        """All recordings, and whether each is pinned."""
        pinned = {mark.stem for mark in self._files(_PINNED)}
        files = sorted(self._files(SUFFIX), key=lambda path: (_number_of(path), path.name), reverse=True)
        return [(path, path.stem in pinned) for path in files]

    def _files(self, suffix: str) -> Iterator[Path]:
        with suppress(OSError):
            for path in self.folder.iterdir():
                if path.suffix == suffix and not path.name.startswith("."):
                    yield path

    def _own(self, path: Path) -> None:
        """Raises ValueError outside of this library, where nothing may be deleted."""
        if path.parent != self.folder or path.suffix != SUFFIX:
            raise ValueError(f"{path} is not in this library")


def _number_of(path: Path) -> int:
    """0 for a file that was named by somebody else."""
    found = _NUMBER.search(path.stem)
    return 0 if found is None else int(found[1])


def entry_of(path: Path, *, is_pinned: bool = False) -> RecordingEntry:
    """The present entry of this file; never raises."""
    entry = RecordingEntry(path, datetime.fromtimestamp(0, UTC), is_pinned=is_pinned)
    try:
        status = path.stat()
        entry = entry._replace(started_at=datetime.fromtimestamp(status.st_mtime, UTC), size_bytes=status.st_size)
        opening, state = read_head(path)
    except (OSError, UserError) as error:
        return entry._replace(trouble=unreadable(path, error))
    is_running = not state.is_ended and is_held(path)
    return entry._replace(
        started_at=opening.started_at,
        port=opening.port,
        baud_rate=opening.baud_rate,
        modules=state.modules,
        duration_s=max(0.0, state.end_s - opening.start_s),
        sample_count=state.reports,
        is_running=is_running,
        was_cut_off=not state.is_ended and not is_running,
        was_triggered=state.was_triggered,
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
            return error.errno in _HELD
    return False


def unreadable(path: Path, error: Exception) -> UserMessage:
    why = error.message if isinstance(error, UserError) else error_text(error)
    return message(marked("{file} cannot be read: {why}."), file=path.name, why=why)


def stopped_message(error: Exception, folder: Path) -> UserMessage:
    if isinstance(error, OSError) and error.errno in _DISK_FULL:
        return message(marked("Not recording: the disk is full. Free some space, then connect again."))
    return message(marked("Not recording to {folder}: {why}."), folder=folder, why=error_text(error))


# Texts


def when_text(entry: RecordingEntry) -> str:
    """Start in local time."""
    return f"{entry.started_at.astimezone():%Y-%m-%d %H:%M:%S}"


def size_text(size_bytes: float) -> str:
    """Size in powers of 1024: "12 kB", "3.4 MB"."""
    if size_bytes < 1024**2:
        return f"{math.ceil(size_bytes / 1024)} kB"
    if size_bytes < 1024**3:
        megabytes = size_bytes / 1024**2
        return f"{megabytes:.{0 if megabytes >= 100 else 1}f} MB"
    return f"{size_bytes / 1024**3:.1f} GB"


def remarks(entry: RecordingEntry) -> str:
    if entry.trouble is not None:
        return tr("cannot be read")
    words = (
        (tr("being recorded"), entry.is_running),
        (tr("triggered"), entry.was_triggered),
        (tr("cut off"), entry.was_cut_off),
        (tr("simulated"), entry.is_simulated),
    )
    return " · ".join(word for word, holds in words if holds)


def entry_text(entry: RecordingEntry) -> str:
    """Description of a recording, for the tooltip and screen readers."""
    if entry.trouble is not None:
        return entry.trouble.translated()
    words = [when_text(entry), entry.module, entry.port, stopwatch(entry.duration_s), size_text(entry.size_bytes)]
    words += [remarks(entry), tr("pinned") if entry.is_pinned else ""]
    return join_names(filter(None, words))
