"""Library of recordings: list, pin, trash, prune."""

import errno
import re
import secrets
import shutil
import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Final

from app.recordings.session_format import SUFFIX
from app.recordings.session_reader import read_heading
from app.system.files import lock, private_opener
from app.text.messages import UserMessage, message
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_BYTES = 2 * 1024**3
MAX_DAYS = 90
"""Days with recordings, so that a wrong clock in one session adds one day only."""
TRASH = ".trash"
_TRASH_SHARE = 4
"""The trash may take 1/4 of `max_bytes`."""
SIMULATED = "sim:"
_PINNED: Final = ".kept"
_PART: Final = re.compile(r"(.+?)(?:\.part(\d+))?" + re.escape(SUFFIX))
_DISK_FULL = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
_HELD: Final = frozenset({errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK})


def recordings_folder() -> Path:
    """In this user's folder for the program's data."""
    from app.system.folders import data_folder

    return data_folder() / "recordings"


@dataclass(frozen=True, slots=True)
class RecordingEntry:
    """One recorded session: one file, or several parts of a long one."""

    path: Path
    """The first part."""
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
    sequence: int = 0
    """See `Opening.sequence`."""
    was_triggered: bool = False
    """A report said that the module has triggered."""
    further: tuple[Path, ...] = ()
    """The parts behind the first."""

    @property
    def parts(self) -> tuple[Path, ...]:
        return (self.path, *self.further)

    @property
    def name(self) -> str:
        return self.path.stem

    @property
    def is_trashed(self) -> bool:
        return self.path.parent.name == TRASH

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
        return sum(_size_of(part) for place in (self.folder, self.trash) for part in _files(place))

    def entries(self) -> tuple[RecordingEntry, ...]:
        """Newest first. Reads headings only. Never raises: an unreadable recording is an entry with `trouble`."""
        return _sorted(self.folder)

    def trashed(self) -> tuple[RecordingEntry, ...]:
        """Recordings in the trash, newest first."""
        return _sorted(self.trash)

    def next_sequence(self) -> int:
        """`Opening.sequence` of the next recording."""
        from app.recordings.old_recordings import highest_sequence

        known = [entry.sequence for entry in (*self.entries(), *self.trashed())]
        return 1 + max((*known, highest_sequence(self.folder)))

    def delete(self, entry: RecordingEntry) -> None:
        """Deletes permanently. Raises OSError, or `UserError` for one that is being written."""
        self._own(entry)
        if any(is_held(part) for part in entry.parts):
            raise UserError(marked("It is being written: not deleted."))
        for part in reversed(entry.parts):  # interrupted, it leaves a shorter recording
            part.unlink(missing_ok=True)
        _mark_of(entry.path).unlink(missing_ok=True)

    def set_pinned(self, entry: RecordingEntry, *, is_pinned: bool) -> RecordingEntry:
        """Pins or unpins; pinning restores from the trash. Returns the new entry. Raises OSError."""
        self._own(entry)
        if entry.is_trashed and is_pinned:
            entry = self._move(entry, self.folder)
        mark = _mark_of(entry.path)
        if is_pinned:
            open(mark, "ab", opener=private_opener).close()
        else:
            mark.unlink(missing_ok=True)
        return replace(entry, is_pinned=is_pinned)

    def prune(self) -> tuple[RecordingEntry, ...]:
        """Moves the oldest recordings beyond the limits into the trash, and returns them. Pinned and running ones stay
        and do not count. Deletes the oldest of the trash beyond its size. What cannot be moved is left for the next
        time."""
        with self._pruning:
            total, days = 0, set[date]()
            gone: list[RecordingEntry] = []
            for entry in self.entries():
                if entry.is_pinned or entry.is_running:
                    continue
                total += entry.size_bytes
                days.add(entry.started_at.date())
                if len(days) > self.max_days or total > self.max_bytes:
                    with suppress(OSError):
                        self._move(entry, self.trash)
                        gone.append(entry)
            self._empty_trash(self.max_bytes // _TRASH_SHARE)
            return tuple(gone)

    def empty_trash(self) -> None:
        """Deletes everything in the trash permanently."""
        with self._pruning:
            self._empty_trash(0)

    def _move(self, entry: RecordingEntry, target: Path) -> RecordingEntry:
        target.mkdir(mode=0o700, exist_ok=True)
        moved = [part.rename(target / part.name) for part in entry.parts]
        return replace(entry, path=moved[0], further=tuple(moved[1:]))

    def _empty_trash(self, max_bytes: int) -> None:
        """Keeps the newest that fit."""
        total = 0
        for entry in self.trashed():
            total += entry.size_bytes
            if total > max_bytes:
                for part in entry.parts:
                    with suppress(OSError):
                        part.unlink()
        if not max_bytes:  # what an earlier version left there
            for folder in (place for place in _listed(self.trash) if place.is_dir()):
                shutil.rmtree(folder, ignore_errors=True)

    def _own(self, entry: RecordingEntry) -> None:
        """Raises ValueError outside of this library, where nothing may be deleted."""
        if entry.path.parent not in (self.folder, self.trash) or _PART.fullmatch(entry.path.name) is None:
            raise ValueError(f"{entry.path} is not in this library")


def new_path(library: Path, started_at: datetime) -> Path:
    """A path that sorts by time."""
    return library / f"{started_at.astimezone(UTC):%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}{SUFFIX}"


def part_path(first: Path, number: int) -> Path:
    """The path of a further part."""
    return first if number == 1 else first.with_name(f"{first.stem}.part{number}{SUFFIX}")


def entry_of(path: Path) -> RecordingEntry:
    """The present entry of the session that begins in this file; never raises."""
    numbered = ((_PART.fullmatch(file.name), file) for file in _files(path.parent))
    further = sorted((int(part[2]), file) for part, file in numbered if part and part[2] and part[1] == path.stem)
    parts = (path, *(file for _, file in further))
    is_running = any(map(is_held, parts))
    entry = RecordingEntry(
        path=path, further=parts[1:], started_at=_modified_at(path), size_bytes=sum(map(_size_of, parts)),
        is_pinned=_mark_of(path).exists(), is_running=is_running,
    )  # fmt: skip
    try:
        files = [read_heading(part) for part in parts]
    except (OSError, UserError) as error:
        return replace(entry, trouble=unreadable(path, error))
    opening, ends = files[0].opening, files[-1]
    return replace(
        entry,
        started_at=opening.started_at,
        port=opening.port,
        baud_rate=opening.baud_rate,
        sequence=opening.sequence,
        module=ends.opening.module,
        duration_s=max(0.0, ends.end_ns / 1e9 - opening.started_at.timestamp()),
        sample_count=sum(file.reports for file in files),
        was_cut_off=not (is_running or all(file.is_ended for file in files)),
        was_triggered=any(file.was_triggered for file in files),
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


def _sorted(place: Path) -> tuple[RecordingEntry, ...]:
    files = {file.name: file for file in _files(place)}
    # A further part without its first one is a recording by itself.
    firsts = [file for name, file in files.items() if _first_name(name) not in files or _first_name(name) == name]
    entries = map(entry_of, firsts)
    return tuple(sorted(entries, key=lambda entry: (entry.sequence, entry.started_at, entry.path.name), reverse=True))


def _first_name(name: str) -> str:
    part = _PART.fullmatch(name)
    return name if part is None else part[1] + SUFFIX


def _listed(place: Path) -> list[Path]:
    try:
        return list(place.iterdir())
    except OSError:
        return []


def _files(place: Path) -> list[Path]:
    return [file for file in _listed(place) if file.suffix == SUFFIX and not file.name.startswith(".")]


def _mark_of(path: Path) -> Path:
    return path.with_suffix(_PINNED)


def _size_of(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _modified_at(path: Path) -> datetime:
    try:
        return datetime.fromtimestamp(path.stat().st_mtime, UTC)
    except OSError:
        return datetime.fromtimestamp(0, UTC)


def unreadable(path: Path, error: Exception) -> UserMessage:
    """Why a recording cannot be read."""
    why = error.message if isinstance(error, UserError) else error_text(error)
    return message(marked("{file} cannot be read: {why}."), file=path.name, why=why)


def stopped_message(error: Exception, folder: Path) -> UserMessage:
    """Why recording stopped."""
    if isinstance(error, OSError) and error.errno in _DISK_FULL:
        return message(marked("Not recording: the disk is full. Free some space, then connect again."))
    return message(marked("Not recording to {folder}: {why}."), folder=folder, why=error_text(error))
