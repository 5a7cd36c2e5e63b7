"""Reads any flight log, by its first bytes and not by its name; finds the logs in folders."""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from app.flights.assembly import assembled, flight_of_reports
from app.flights.columns import CsvColumns
from app.flights.flight_log import NO_PROGRESS, FlightLog, Progress, unreadable
from app.flights.mavlink import is_telemetry
from app.flights.refused import READ, why_refused, why_unknown
from app.flights.table import encoding_of
from app.flights.unpacked import GZIP, ZIP, archive_of, members_of, unpacked
from app.text.messages import joined, message
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

SUFFIXES: Final = (".ulg", ".bin", ".log", ".tlog", ".csv", ".tsv", ".txt", ".mcap", ".gz", ".zip")
_ULOG, _DATAFLASH, _SESSION = b"ULog\x01\x12\x35", b"\xa3\x95", b"\x89MCAP0\r\n"
"""What their files begin with."""
_START_BYTES: Final = 1 << 16
_TEXT_FORMAT: Final = b"FMT,"
"""A line of a DataFlash log that was saved as text."""
_NOT_LOGS: Final = frozenset((
    ".jpg", ".jpeg", ".png", ".gif", ".svg", ".pdf", ".md", ".html", ".toml", ".py", ".mp4", ".mov", ".srt", ".kept",
))  # fmt: skip
"""Endings of what lies in folders beside logs, and is not opened there."""


def read_flight_log(path: Path, columns: CsvColumns | None = None, on_progress: Progress = NO_PROGRESS) -> FlightLog:
    """Reads a file. `columns`: of a table, None recognises them by name.

    Slow for large files: not for the window's thread. Raises only `UserError`, and what `on_progress` raises.
    """
    if "\0" in str(path):
        raise unreadable(marked("cannot be read"))
    try:
        member = archive_of(path)
        if member is None:
            return _read(path, columns, on_progress)
        with unpacked(*member) as file:
            return replace(_read(file, columns, on_progress), name=str(path))
    except OSError as error:
        raise unreadable(error_text(error)) from error
    except MemoryError as error:
        raise unreadable(marked("cannot be read")) from error


def _read(path: Path, columns: CsvColumns | None, on_progress: Progress, *, is_packed: bool = False) -> FlightLog:
    """Raises `UserError`, OSError, MemoryError, and what `on_progress` raises."""
    start = _start_of(path)
    if start.startswith(_ULOG):
        from app.flights.ulog import read_ulog

        return assembled(read_ulog(path))
    if start.startswith(_DATAFLASH):
        from app.flights.dataflash import read_dataflash

        return assembled(read_dataflash(path))
    if start.startswith(_SESSION):
        return _read_session(path)
    if is_telemetry(start):
        from app.flights.mavlink import read_telemetry

        return assembled(read_telemetry(path))
    if start.startswith((GZIP, ZIP)) and not is_packed:
        member = None
        if start.startswith(ZIP):
            members = members_of(path)
            if len(members) != 1:
                raise unreadable(marked("not one file in the archive"))
            member = members[0]
        with unpacked(path, member) as file:
            return replace(_read(file, columns, on_progress, is_packed=True), name=str(path))
    why = why_refused(start)
    if why is None and not is_text(start):
        why = why_unknown(path.suffix) or marked("Unknown kind of file.")
    if why is not None:
        raise UserError(joined((message(why), message(READ)), " "))
    if _is_dataflash_text(start):
        from app.flights.dataflash import raw_log_of
        from app.flights.dataflash_text import read_dataflash_text

        return assembled(raw_log_of(read_dataflash_text(path), str(path)))
    from app.flights.table import read_table

    return read_table(path, columns, on_progress)


def is_text(start: bytes) -> bool:
    """Whether bytes are text, in any encoding that is read."""
    if not start:
        return False
    text = start.decode(encoding_of(start), "replace")
    controls = sum(character < " " and character not in "\t\r\n\f\v" for character in text[:4096])
    return controls <= len(text[:4096]) // 100


def _is_dataflash_text(start: bytes) -> bool:
    return start.startswith(_TEXT_FORMAT) or b"\n" + _TEXT_FORMAT in start


def is_table(path: Path) -> bool:
    """Whether a file can be asked for its columns. Raises OSError."""
    start = _start_of(path)
    is_known = start.startswith((_ULOG, _DATAFLASH, _SESSION, GZIP, ZIP)) or is_telemetry(start)
    return not is_known and why_refused(start) is None and is_text(start) and not _is_dataflash_text(start)


def _read_session(path: Path) -> FlightLog:
    """A flight that a module measured. Raises `UserError`."""
    from app.recordings.library import entry_of
    from app.recordings.markers import STATE_LOST
    from app.recordings.recording import open_recording

    entry = entry_of(path)
    try:
        recording = open_recording(entry)
    except UserError as error:
        cause = error.__cause__
        raise unreadable(str(cause) if isinstance(cause, UserError) else marked("cannot be read")) from error
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    columns = (*excerpt.tilt, excerpt.acceleration.value)
    time_s, tilt_deg, acceleration_g = (np.array(column, np.float64) for column in columns)
    resets = [marker for marker in excerpt.markers if marker.kind in STATE_LOST]
    problems = [] if recording.damage is None else [recording.damage]
    if entry.was_cut_off:
        problems.append(message(marked("cut off")))
    # Where the end is damaged, the recording lasted until there.
    lost = [end_s for _, end_s in recording.damaged if np.isfinite(end_s)]
    span_s = None
    if lost and len(time_s):
        span_s = float(time_s[0]), max(lost)
    return flight_of_reports(str(path), time_s, tilt_deg, acceleration_g, problems, resets, span_s=span_s)


def _start_of(path: Path) -> bytes:
    """Its first bytes; none of what is no file. Raises OSError."""
    if path.exists() and not path.is_file():  # opening a pipe or a device may block
        return b""
    with path.open("rb") as file:
        return file.read(_START_BYTES)


def find_logs(paths: Iterable[Path]) -> Iterator[Path]:
    """Yields files as given, those in and below folders by name, and those of an archive with several. Raises OSError.

    In folders everything is a log but what is known to be none: what cannot be read has to be said.
    """
    for path in paths:
        if not path.is_dir():
            yield from _members(path)
            continue
        for folder, names, files in os.walk(path):
            names[:] = sorted(name for name in names if not name.startswith("."))
            for name in sorted(files):
                if not name.startswith(".") and not _is_beside_logs(Path(name)):
                    yield from _members(Path(folder) / name)


def _is_beside_logs(name: Path) -> bool:
    return name.suffix.lower() in _NOT_LOGS or name.stem.lower().startswith("readme")


def _members(path: Path) -> list[Path]:
    """The files of a zip archive with more than one, as paths below it; else the path itself."""
    if not path.is_file() or not _start_of(path).startswith(ZIP):
        return [path]
    try:
        members = members_of(path)
    except UserError:  # is said when it is read
        return [path]
    return [path / member for member in members] if len(members) > 1 else [path]


def distinct_names(paths: Sequence[Path]) -> list[str]:
    """The shortest ends of the paths by which they can be told apart."""
    names = [path.name for path in paths]
    for depth in range(2, max((len(path.parts) for path in paths), default=0) + 1):
        if len(set(names)) == len(names):
            break
        names = [
            str(Path(*path.parts[-depth:])) if names.count(name) > 1 else name
            for path, name in zip(paths, names, strict=True)
        ]
    return names
