"""Library of recordings: list, describe, delete, prune."""

import math
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

from app.engine.target import is_simulated
from app.recordings.session_file import SUFFIX, read_head
from app.system.files import data_folder, lock
from app.text.i18n import tr
from app.text.messages import UserError, UserMessage, error_text, join_names, message, stopwatch
from protocol.translatable import marked

MAX_BYTES: Final = 5 * 1024**3 // 2


def recordings_folder() -> Path:
    """Return the folder of the recordings, in this user's folder for the program's data."""
    return data_folder() / "recordings"


class RecordingEntry(NamedTuple):
    """A recording as the list shows it."""

    path: Path
    started_at: datetime
    port: str = ""
    baud_rate: int = 0
    # The names that were said while it was recorded.
    modules: tuple[str, ...] = ()
    duration_s: float = 0.0
    sample_count: int = 0
    size_bytes: int = 0
    # It is being written, by this or another program.
    is_running: bool = False
    # It was not closed properly, and is valid up to there.
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
    """Thread-safe. `max_bytes` limits the recordings that are kept.

    A file's name has its time and its number. Numbers ascend in the order of recording, so a wrong calendar does no
    harm where the oldest are deleted.
    """

    def __init__(self, folder: Path | None = None, *, max_bytes: int = MAX_BYTES) -> None:
        self.folder = folder or recordings_folder()
        self.max_bytes = max_bytes

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads the heads of the files only. Never raises: an unreadable recording is an entry with
        `trouble`."""
        return tuple(map(entry_of, self._newest_first()))

    def new_path(self, started_at: datetime) -> Path:
        """The path of a recording that begins now."""
        number = 1 + max(map(_number_of, self._newest_first()), default=0)
        return self.folder / f"{started_at.astimezone(UTC):%Y%m%dT%H%M%SZ}-{number:05}{SUFFIX}"

    def delete(self, entry: RecordingEntry) -> None:
        """Delete a recording. Raises OSError, `UserError` for one that is being written, ValueError outside of this
        library, where nothing may be deleted."""
        if entry.path.parent != self.folder or entry.path.suffix != SUFFIX:
            raise ValueError(f"{entry.path} is not in this library")
        if _is_held(entry.path):
            raise UserError(marked("It is being written: not deleted."))
        entry.path.unlink(missing_ok=True)

    def prune(self) -> None:
        """Deletes the oldest recordings beyond the limit; running ones stay. What cannot be deleted is left for the
        next time."""
        total = 0
        for path in self._newest_first():
            with suppress(OSError):
                total += path.stat().st_size
                if total > self.max_bytes and not _is_held(path):
                    path.unlink()

    def _newest_first(self) -> list[Path]:
        with suppress(OSError):
            files = [one for one in self.folder.iterdir() if one.suffix == SUFFIX and not one.name.startswith(".")]
            return sorted(files, key=lambda path: (_number_of(path), path.name), reverse=True)
        return []


def _number_of(path: Path) -> int:
    """0 for a file that was named by somebody else."""
    number = path.stem.rpartition("-")[2]
    return int(number) if number.isdecimal() else 0


def entry_of(path: Path) -> RecordingEntry:
    """The present entry of this file; never raises."""
    entry = RecordingEntry(path, datetime.fromtimestamp(0, UTC))
    try:
        status = path.stat()
        entry = entry._replace(started_at=datetime.fromtimestamp(status.st_mtime, UTC), size_bytes=status.st_size)
        opening, state = read_head(path)
    except (OSError, UserError) as error:
        return entry._replace(trouble=unreadable(path, error))
    is_running = not state.is_ended and _is_held(path)
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


def _is_held(path: Path) -> bool:
    """Whether this or another program is writing the file."""
    with suppress(OSError), path.open("rb") as file:
        try:
            lock(file, is_shared=True)
        except (BlockingIOError, PermissionError):  # other errors of a lock come from file systems without locks
            return True
    return False


def unreadable(path: Path, error: Exception) -> UserMessage:
    why = error.message if isinstance(error, UserError) else error_text(error)
    return message(marked("{file} cannot be read: {why}."), file=path.name, why=why)


# Texts


def when_text(entry: RecordingEntry) -> str:
    """Start in local time."""
    return f"{entry.started_at.astimezone():%Y-%m-%d %H:%M:%S}"


def size_text(size_bytes: float) -> str:
    """Size in powers of 1024: "12 kB", "3.4 MB"."""
    if size_bytes < 1024**2:
        return f"{math.ceil(size_bytes / 1024)} kB"
    if size_bytes < 1024**3:
        return f"{size_bytes / 1024**2:.1f} MB"
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
    return join_names(filter(None, (*words, remarks(entry))))
