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
    KEPT,
    SESSION,
    Opening,
    Unreadable,
    is_held,
    read_opening,
)
from app.system.files import private_opener
from app.text.i18n import tr
from app.text.sentences import reason_of

MOST_BYTES = 2 * 1024**3
MOST_DAYS = 90
"""Days on which something was recorded: a calendar that is wrong for one session adds one day."""
TRASH = ".trash"
_TRASH_SHARE = 4
"""The trash may take a quarter of what the recordings may."""
SIMULATED = "sim:"
_GOING = ".going-"
"""Begins the name of a folder that is being deleted."""
_DISK_FULL = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
_UNFINISHED_DAYS = 1.0
"""After which a folder without a heading, that a crash left behind, is taken away."""


def recordings_folder() -> Path:
    """Of this user, in the platform's folder for the program's data."""
    from app.store.store import data_folder

    return data_folder() / "recordings"


class RecordingInUse(Exception):
    """It is being written: it cannot be deleted."""


@dataclass(frozen=True, slots=True)
class RecordingEntry:
    """One recorded session."""

    folder: Path
    started_at: datetime
    """Aware, UTC."""
    port: str
    baud_rate: int
    module: str
    """ "": nobody named it."""
    duration_s: float
    sample_count: int
    """Status reports."""
    size_bytes: int
    is_kept: bool
    """Never pruned."""
    is_running: bool
    """Being written now, by this program or another one."""
    was_cut_off: bool
    """Not closed in an orderly way; what arrived until then is there all the same."""
    trouble: str | None = None
    """Why it cannot be read, in the language in use."""
    part: int = 1
    """Long sessions are continued in a further recording."""
    sequence: int = 0
    """The order in which they began, whatever the calendar said; 0: from before there were numbers."""

    @property
    def is_trashed(self) -> bool:
        return self.folder.parent.name == TRASH

    @property
    def is_simulated(self) -> bool:
        """Of a simulated module inside of this program."""
        return self.port.startswith(SIMULATED)


class RecordingLibrary:
    """All methods may be called from any thread. `most_bytes` and `most_days` bind what is not kept for good."""

    def __init__(self, folder: Path | None = None, *, most_bytes: int = MOST_BYTES, most_days: int = MOST_DAYS) -> None:
        self.folder = folder or recordings_folder()
        self.trash = self.folder / TRASH
        self.most_bytes = most_bytes
        self.most_days = most_days
        self._pruning = threading.Lock()

    @property
    def size_bytes(self) -> int:
        """Of everything in it, kept ones and the trash included."""
        return sum(size_of(folder) for folder in (*_folders(self.folder), *_folders(self.trash)))

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads headings only; never raises: what cannot be read is an entry with its trouble."""
        return self._sorted(one for one in _folders(self.folder) if (one / SESSION).exists())

    def trashed(self) -> tuple[RecordingEntry, ...]:
        """What was pruned and is not yet deleted, newest first."""
        return self._sorted(_folders(self.trash))

    def next_sequence(self) -> int:
        """The number of the recording that begins now."""
        return 1 + max((one.sequence for one in (*self.entries(), *self.trashed())), default=0)

    def _sorted(self, folders: Iterable[Path]) -> tuple[RecordingEntry, ...]:
        found = map(self.entry, folders)
        return tuple(sorted(found, key=lambda one: (one.sequence, one.started_at, one.folder.name), reverse=True))

    def entry(self, folder: Path) -> RecordingEntry:
        """As it is now; never raises."""
        try:
            opening = read_opening(folder)
            extents = read_extents(folder, opening, is_checked=False)
        except (OSError, Unreadable) as error:
            return _unreadable(folder, error)
        is_running = not extents.is_last and is_held(folder)
        return entry_of(folder, opening, extents, size_bytes=size_of(folder), is_running=is_running)

    def delete(self, entry: RecordingEntry) -> None:
        """For good. Raises `RecordingInUse`; OSError where the system does not let it go."""
        folder = self._own(entry)
        if not folder.exists():
            return
        if is_held(folder):
            raise RecordingInUse(entry.folder.name)
        # Renamed first: one that was deleted by half must not look like a damaged one.
        going = self.folder / (_GOING + folder.name)
        folder.rename(going)
        shutil.rmtree(going)

    def keep(self, entry: RecordingEntry, *, is_kept: bool) -> RecordingEntry:
        """The entry as it is then; what is to be kept comes back from the trash. Raises OSError."""
        folder = self._own(entry)
        if entry.is_trashed and is_kept:
            folder = self._move(folder, self.folder)
        mark = folder / KEPT
        if is_kept:
            open(mark, "ab", opener=private_opener).close()
        else:
            mark.unlink(missing_ok=True)
        return replace(entry, folder=folder, is_kept=is_kept)

    def prune(self, now: datetime) -> tuple[RecordingEntry, ...]:
        """Move into the trash what is too old or too much, in the order in which it was recorded; kept and running ones
        stay and do not count. From the trash the oldest go for good, and only because of their size.

        What was moved; what the system does not let go is left for the next time. `now` tells only what a crash left
        from what has just begun.
        """
        with self._pruning:
            self._clear_away(now)
            total, days = 0, set[date]()
            gone: list[RecordingEntry] = []
            for one in self.entries():
                if one.is_kept or one.is_running:
                    continue
                total += one.size_bytes
                days.add(one.started_at.date())
                if len(days) > self.most_days or total > self.most_bytes:
                    with suppress(OSError):
                        self._move(one.folder, self.trash)
                        gone.append(one)
            self._empty_trash(self.most_bytes // _TRASH_SHARE)
            return tuple(gone)

    def empty_trash(self) -> None:
        """The disk is full: delete what is in it for good."""
        with self._pruning:
            self._empty_trash(0)

    def _move(self, folder: Path, target: Path) -> Path:
        target.mkdir(mode=0o700, exist_ok=True)
        return folder.rename(target / folder.name)

    def _empty_trash(self, most_bytes: int) -> None:
        """The newest that fit stay."""
        total = 0
        for one in self.trashed():
            total += one.size_bytes
            if total > most_bytes:
                shutil.rmtree(one.folder, ignore_errors=True)

    def _own(self, entry: RecordingEntry) -> Path:
        """Nothing outside of the shelf is ever deleted."""
        if entry.folder.parent not in (self.folder, self.trash) or not entry.folder.name:
            raise ValueError(f"{entry.folder} is not on this shelf")
        return entry.folder

    def _clear_away(self, now: datetime) -> None:
        """What a crash left of a recording that was going, or had hardly begun."""
        with suppress(OSError):
            for one in self.folder.iterdir():
                is_unfinished = False
                with suppress(OSError):
                    age = now - datetime.fromtimestamp(one.stat().st_mtime, UTC)
                    has_heading = (one / SESSION).exists()
                    is_unfinished = one.is_dir() and not has_heading and age > timedelta(days=_UNFINISHED_DAYS)
                if one.name.startswith(_GOING):
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
        is_kept=(folder / KEPT).exists(),
        is_running=is_running,
        was_cut_off=not (is_running or extents.is_last),
        part=opening.part,
        sequence=opening.sequence,
    )


def _unreadable(folder: Path, error: OSError | Unreadable) -> RecordingEntry:
    text = str(error)
    why = tr(text) if isinstance(error, Unreadable) else error.strerror or text
    try:
        at_s = folder.stat().st_mtime
    except OSError:
        at_s = 0.0
    return RecordingEntry(
        folder=folder,
        started_at=datetime.fromtimestamp(at_s, UTC),
        port="",
        baud_rate=0,
        module="",
        duration_s=0.0,
        sample_count=0,
        size_bytes=size_of(folder),
        is_kept=(folder / KEPT).exists(),
        is_running=False,
        was_cut_off=False,
        trouble=tr("Recording cannot be read: {why}.", why=why),
    )


def stopped_sentence(error: Exception, folder: Path) -> str:
    """Why the session is no longer recorded in this folder, in the language in use."""
    if isinstance(error, OSError) and error.errno in _DISK_FULL:
        return tr("Not recording: the disk is full. Free some space, then connect again.")
    return tr("Not recording to {folder}: {why}.", folder=folder, why=reason_of(error))


def size_of(folder: Path) -> int:
    total = 0
    with suppress(OSError):
        for one in folder.iterdir():
            with suppress(OSError):
                total += one.stat().st_size
    return total
