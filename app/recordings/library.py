"""Library of recordings: list, pin, trash, prune."""

import errno
import shutil
import threading
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

from app.recordings.commits import Extents, read_extents
from app.recordings.file_layout import (
    PINNED,
    SESSION,
    Opening,
    Unreadable,
    is_held,
    read_opening,
)
from app.system.files import private_opener
from app.text.messages import UserMessage, message
from app.text.sentences import error_text
from protocol.translatable import marked

MAX_BYTES = 2 * 1024**3
MAX_DAYS = 90
"""Days with recordings, so that a wrong clock in one session adds one day only."""
TRASH = ".trash"
_TRASH_SHARE = 4
"""The trash may take 1/4 of `max_bytes`."""
SIMULATED = "sim:"
_DELETING = ".going-"
"""Prefix of folders that are being deleted."""
_DISK_FULL = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
_UNFINISHED_DAYS = 1.0
"""Age after which a folder without heading, left by a crash, is moved to the trash."""


def recordings_folder() -> Path:
    """In this user's folder for the program's data."""
    from app.store.store import data_folder

    return data_folder() / "recordings"


class RecordingInUse(Exception):
    """A recording that is being written cannot be deleted."""


@dataclass(frozen=True, slots=True)
class RecordingEntry:
    """One recorded session."""

    folder: Path
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
    """Why it cannot be read."""
    part: int = 1
    """Long sessions continue in a further recording."""
    sequence: int = 0
    """See `Opening.sequence`."""

    @property
    def is_trashed(self) -> bool:
        return self.folder.parent.name == TRASH

    @property
    def is_simulated(self) -> bool:
        """Recorded from a simulated module."""
        return self.port.startswith(SIMULATED)


class RecordingLibrary:
    """Thread-safe. `max_bytes` and `max_days` limit the recordings that are not pinned."""

    def __init__(self, folder: Path | None = None, *, max_bytes: int = MAX_BYTES, max_days: int = MAX_DAYS) -> None:
        self.folder = folder or recordings_folder()
        self.trash = self.folder / TRASH
        self.max_bytes = max_bytes
        self.max_days = max_days
        self._pruning = threading.Lock()

    @property
    def size_bytes(self) -> int:
        """Total size, including pinned recordings and the trash."""
        return sum(size_of(folder) for folder in (*_folders(self.folder), *_folders(self.trash)))

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads headings only. Never raises: an unreadable recording is an entry with `trouble`."""
        return self._sorted(one for one in _folders(self.folder) if (one / SESSION).exists())

    def trashed(self) -> tuple[RecordingEntry, ...]:
        """Recordings in the trash, newest first."""
        return self._sorted(_folders(self.trash))

    def next_sequence(self) -> int:
        """`Opening.sequence` of the next recording."""
        return 1 + max((one.sequence for one in (*self.entries(), *self.trashed())), default=0)

    def _sorted(self, folders: Iterable[Path]) -> tuple[RecordingEntry, ...]:
        found = map(self.entry, folders)
        return tuple(sorted(found, key=lambda one: (one.sequence, one.started_at, one.folder.name), reverse=True))

    def entry(self, folder: Path) -> RecordingEntry:
        """The present entry of a folder; never raises."""
        try:
            opening = read_opening(folder)
            extents = read_extents(folder, opening)
        except (OSError, Unreadable) as error:
            return _unreadable_entry(folder, error)
        is_running = not extents.is_last and is_held(folder)
        return entry_of(folder, opening, extents, size_bytes=size_of(folder), is_running=is_running)

    def delete(self, entry: RecordingEntry) -> None:
        """Deletes permanently. Raises `RecordingInUse`, OSError."""
        folder = self._own(entry)
        if not folder.exists():
            return
        if is_held(folder):
            raise RecordingInUse(entry.folder.name)
        # Renamed first, so that an interrupted deletion does not look like a damaged recording.
        going = self.folder / (_DELETING + folder.name)
        folder.rename(going)
        shutil.rmtree(going)

    def set_pinned(self, entry: RecordingEntry, *, is_pinned: bool) -> RecordingEntry:
        """Pins or unpins; pinning restores from the trash. Returns the new entry. Raises OSError."""
        folder = self._own(entry)
        if entry.is_trashed and is_pinned:
            folder = self._move(folder, self.folder)
        mark = folder / PINNED
        if is_pinned:
            open(mark, "ab", opener=private_opener).close()
        else:
            mark.unlink(missing_ok=True)
        return replace(entry, folder=folder, is_pinned=is_pinned)

    def prune(self, now: datetime) -> tuple[RecordingEntry, ...]:
        """Moves the oldest recordings beyond the limits into the trash, and returns them. Pinned and running ones stay
        and do not count. Deletes the oldest of the trash beyond its size.

        What cannot be moved is left for the next time. `now` is used only for the age of folders left by a crash.
        """
        with self._pruning:
            self._delete_leftovers(now)
            total, days = 0, set[date]()
            gone: list[RecordingEntry] = []
            for one in self.entries():
                if one.is_pinned or one.is_running:
                    continue
                total += one.size_bytes
                days.add(one.started_at.date())
                if len(days) > self.max_days or total > self.max_bytes:
                    with suppress(OSError):
                        self._move(one.folder, self.trash)
                        gone.append(one)
            self._empty_trash(self.max_bytes // _TRASH_SHARE)
            return tuple(gone)

    def empty_trash(self) -> None:
        """Deletes everything in the trash permanently."""
        with self._pruning:
            self._empty_trash(0)

    def _move(self, folder: Path, target: Path) -> Path:
        target.mkdir(mode=0o700, exist_ok=True)
        return folder.rename(target / folder.name)

    def _empty_trash(self, max_bytes: int) -> None:
        """Keeps the newest that fit."""
        total = 0
        for one in self.trashed():
            total += one.size_bytes
            if total > max_bytes:
                shutil.rmtree(one.folder, ignore_errors=True)

    def _own(self, entry: RecordingEntry) -> Path:
        """The entry's folder. Raises ValueError outside of this library, where nothing may be deleted."""
        if entry.folder.parent not in (self.folder, self.trash) or not entry.folder.name:
            raise ValueError(f"{entry.folder} is not in this library")
        return entry.folder

    def _delete_leftovers(self, now: datetime) -> None:
        """Removes interrupted deletions and folders without heading that a crash left."""
        with suppress(OSError):
            for one in self.folder.iterdir():
                is_unfinished = False
                with suppress(OSError):
                    age = now - datetime.fromtimestamp(one.stat().st_mtime, UTC)
                    has_heading = (one / SESSION).exists()
                    is_unfinished = one.is_dir() and not has_heading and age > timedelta(days=_UNFINISHED_DAYS)
                if one.name.startswith(_DELETING):
                    shutil.rmtree(one, ignore_errors=True)
                elif is_unfinished and one.name != TRASH and not is_held(one):
                    with suppress(OSError):
                        self._move(one, self.trash)


def _folders(place: Path) -> list[Path]:
    try:
        return [one for one in place.iterdir() if not one.name.startswith(".") and one.is_dir()]
    except OSError:
        return []


def entry_of(folder: Path, opening: Opening, extents: Extents, *, size_bytes: int, is_running: bool) -> RecordingEntry:
    return RecordingEntry(
        folder=folder,
        started_at=opening.started_at,
        port=opening.port,
        baud_rate=opening.baud_rate,
        module=opening.module,
        duration_s=max(0.0, extents.at_s - opening.start_s),
        sample_count=extents.status_rows,
        size_bytes=size_bytes,
        is_pinned=(folder / PINNED).exists(),
        is_running=is_running,
        was_cut_off=not (is_running or extents.is_last),
        part=opening.part,
        sequence=opening.sequence,
    )


def unreadable(folder: Path, error: Exception) -> UserMessage:
    """Why a recording cannot be read."""
    why = message(str(error)) if isinstance(error, Unreadable) else error_text(error)
    return message(marked("{file} cannot be read: {why}."), file=folder.name, why=why)


def _unreadable_entry(folder: Path, error: OSError | Unreadable) -> RecordingEntry:
    try:
        at_s = folder.stat().st_mtime
    except OSError:
        at_s = 0.0
    return RecordingEntry(
        folder=folder,
        started_at=datetime.fromtimestamp(at_s, UTC),
        size_bytes=size_of(folder),
        is_pinned=(folder / PINNED).exists(),
        trouble=unreadable(folder, error),
    )


def stopped_message(error: Exception, folder: Path) -> UserMessage:
    """Why recording stopped."""
    if isinstance(error, OSError) and error.errno in _DISK_FULL:
        return message(marked("Not recording: the disk is full. Free some space, then connect again."))
    return message(marked("Not recording to {folder}: {why}."), folder=folder, why=error_text(error))


def size_of(folder: Path) -> int:
    total = 0
    with suppress(OSError):
        for one in folder.iterdir():
            with suppress(OSError):
                total += one.stat().st_size
    return total
