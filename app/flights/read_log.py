"""Reads any flight log; finds the logs in folders."""

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from app.flights.assembly import assembled, flight_of_reports
from app.flights.columns import CsvColumns
from app.flights.flight_log import NO_PROGRESS, FlightLog, Progress, unreadable
from app.text.messages import message
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

SUFFIXES: Final = (".ulg", ".bin", ".csv", ".mcap")
_ULOG, _DATAFLASH, _SESSION = b"ULog\x01\x12\x35", b"\xa3\x95", b"\x89MCAP0\r\n"
"""What their files begin with."""


def read_flight_log(path: Path, columns: CsvColumns | None = None, on_progress: Progress = NO_PROGRESS) -> FlightLog:
    """Reads a file. `columns`: of a CSV file, None recognises them by name.

    Slow for large files: not for the window's thread. Raises only `UserError`, and what `on_progress` raises.
    """
    try:
        start = _start_of(path)
        if start.startswith(_ULOG):
            from app.flights.ulog import read_ulog

            return assembled(read_ulog(path))
        if start.startswith(_DATAFLASH):
            from app.flights.dataflash import read_dataflash

            return assembled(read_dataflash(path))
        if start.startswith(_SESSION):
            return _read_session(path)
        if is_csv(path):
            from app.flights.table import read_csv

            return read_csv(path, columns, on_progress)
    except OSError as error:
        raise unreadable(error_text(error)) from error
    except (ValueError, MemoryError) as error:  # ValueError: a NUL in the name
        raise unreadable(marked("cannot be read")) from error
    raise unreadable(marked("unknown kind of file"))


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
    return flight_of_reports(str(path), time_s, tilt_deg, acceleration_g, problems, resets)


def is_csv(path: Path) -> bool:
    """By its name, unless its first bytes are another format's. Raises OSError."""
    is_named = path.suffix.lower() == ".csv" and path.is_file()
    return is_named and not _start_of(path).startswith((_ULOG, _DATAFLASH, _SESSION))


def _start_of(path: Path) -> bytes:
    """Its first bytes; none of what is no file. Raises OSError."""
    if path.exists() and not path.is_file():  # opening a pipe or a device may block
        return b""
    with path.open("rb") as file:
        return file.read(16)


def find_logs(paths: Iterable[Path]) -> Iterator[Path]:
    """Yields files as given, and the logs and recordings in and below folders, by name. Raises OSError."""
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        for folder, names, files in os.walk(path):
            names.sort()
            yield from (Path(folder) / name for name in sorted(files) if Path(name).suffix.lower() in SUFFIXES)


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
