"""Reads any flight log, by its first bytes and not by its name; finds logs in folders and archives."""

import gzip
import os
import re
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from math import inf
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final, NamedTuple

import numpy as np

from app.flights.autopilots import MAGIC, TEXT_FORMAT, is_telemetry, read_dataflash, read_telemetry, read_ulog
from app.flights.flight_log import Channel, FlightLog, RawLog, assembled, unreadable
from app.flights.judging import FlightSummary
from app.flights.table import CsvColumns, UnreadTable, encoding_of, read_table
from app.text.messages import UserError, UserMessage, error_text, joined, message
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.recordings.recording import Recording

SUFFIXES: Final = (".ulg", ".bin", ".log", ".tlog", ".csv", ".tsv", ".txt", ".mcap", ".gz", ".zip")
_MAX_BYTES: Final = 1 << 30
_START_BYTES: Final = 1 << 16
# What files begin with.
_ULOG, _MCAP, _GZIP, _ZIP = b"ULog\x01\x12\x35", b"\x89MCAP0\r\n", b"\x1f\x8b", b"PK\x03\x04"
_READ: Final = marked(
    "Read are PX4 .ulg, ArduPilot .bin and .log, telemetry .tlog, tables .csv and .txt, each of them also in .gz or "
    ".zip, and recordings .mcap."
)
_DJI: Final = marked("This is a DJI log: convert it to CSV, for example with DatCon.")
_BLACKBOX: Final = marked(
    "This is a Betaflight or INAV blackbox log: convert it to CSV with “blackbox_decode --simulate-imu”."
)
# By what files begin with; by the ending of the name, where nobody knows the bytes.
_REFUSED: Final = {
    rb"(?i)\s*(<!doctype html|<html)": marked("This is a web page, not a log: download the file itself."),
    b"version https://git-lfs": marked("This is a Git LFS pointer, not the log: fetch the log with “git lfs pull”."),
    b"(?i)H Product:Blackbox": _BLACKBOX,
    b"(?s)LOGH|.{16}BUILD": _DJI,
    rb"\x89MCAP0": marked("This is a packed recording: unpack it."),
    rb"\Z": marked("This file is empty."),
}
_REFUSED_ENDINGS: Final = {".bbl": _BLACKBOX, ".bfl": _BLACKBOX, ".dat": _DJI}


def read_flight_log(path: Path, columns: CsvColumns | None = None) -> FlightLog:
    """Reads a file. `columns`: of a table, None recognises them by name.

    `path` may go on into a zip archive, such as `logs.zip/7.ulg`. Slow for large files: not for the window's thread.
    Raises only `UserError`.
    """
    from app.recordings.library import entry_of
    from app.recordings.recording import open_recording

    try:
        if path.is_file() and _begins(path, _MCAP):
            return flight_of_recording(open_recording(entry_of(path)))
        return assembled(_read(path, columns), str(path))
    except OSError as error:
        raise unreadable(error_text(error)) from error
    except MemoryError as error:
        raise unreadable(marked("cannot be read")) from error


def _read(path: Path, columns: CsvColumns | None) -> RawLog:
    """Read a log of any kind but a recording. Raises `UserError`, OSError, MemoryError."""
    data = _content(path)
    start = data[:_START_BYTES]
    if start.startswith(_ULOG):
        return read_ulog(data)
    if start.startswith(MAGIC):
        return read_dataflash(data)
    if is_telemetry(start):
        return read_telemetry(data)
    why = next((text for begin, text in _REFUSED.items() if re.match(begin, start)), None)
    if why is None:
        # Of a text in any encoding that is read.
        text = start.decode(encoding_of(start), "replace")[:4096]
        controls = sum(character < " " and character not in "\t\r\n\f\v" for character in text)
        if controls > len(text) // 100:
            why = _REFUSED_ENDINGS.get(path.suffix.lower(), marked("Unknown kind of file."))
    if why is not None:
        raise UserError(joined((message(why), message(_READ)), " "))
    if TEXT_FORMAT.search(start):
        return read_dataflash(data)
    return read_table(data, columns)


def flight_of_recording(recording: "Recording") -> FlightLog:
    """The flight that a module measured. Raises `UserError` where that is nothing to judge."""
    from app.recordings.markers import STATE_LOST

    tilt, acceleration = (one.window(-inf, inf) for one in (recording.tilt, recording.acceleration))
    if not len(tilt.time_s):
        raise unreadable(marked("no status reports"))
    # Of several reports of one time each is a nanosecond later.
    time_s = tilt.time_s + (np.arange(len(tilt.time_s)) - np.searchsorted(tilt.time_s, tilt.time_s)) * 1e-9
    raw = RawLog(is_of_module=True)
    # Rounded, since a recording has 32-bit floats.
    raw.tilts_deg = [Channel(time_s, tilt.value.astype(np.float64).round(3))]
    raw.forces_g = [Channel(time_s, acceleration.value.astype(np.float64).round(3))]
    raw.resets_s = np.array([marker.time_s for marker in recording.markers if marker.kind in STATE_LOST])
    end_s = float(time_s[-1])
    if recording.damage is not None:
        raw.problems.append(recording.damage)
        end_s = recording.end_s  # what is damaged at the end was a part of it
    if recording.entry.was_cut_off:
        raw.note(marked("cut off"))
    if recording.entry.is_running:
        raw.note(marked("being recorded"))
    raw.span_s = float(time_s[0]), end_s
    return assembled(raw, str(recording.entry.path))


# Files, archives and folders

# What the libraries raise for an archive that is damaged or encrypted.
_DAMAGED: Final = (zipfile.BadZipFile, gzip.BadGzipFile, zlib.error, EOFError, RuntimeError, NotImplementedError)
_MAX_MEMBERS: Final = 10_000
# Endings of what lies in folders beside logs, and is not opened there.
_NOT_LOGS: Final = frozenset((
    ".jpg", ".jpeg", ".png", ".gif", ".svg", ".pdf", ".md", ".html", ".toml", ".py", ".mp4", ".mov", ".srt",
))  # fmt: skip


def _begins(path: Path, first: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(first)) == first


def _content(path: Path) -> bytes:
    """Unpacked, and bounded. Raises `UserError`, OSError."""
    if path.is_dir():
        list(path.iterdir())  # `find_logs` gives a folder where it could not be listed, and this says why
    if path.exists() and not path.is_file():  # opening a pipe or a device may block
        raise unreadable(marked("unknown kind of file"))
    archive = next((parent for parent in path.parents if parent.is_file()), None)
    data = bytearray()
    try:
        with ExitStack() as files:
            if archive is not None:
                opened = files.enter_context(zipfile.ZipFile(archive))
                file: IO[bytes] | gzip.GzipFile = files.enter_context(opened.open(path.relative_to(archive).as_posix()))
            elif _begins(path, _ZIP):
                # Else `find_logs` gives its members.
                _members(path)
                raise unreadable(marked("no file in the archive"))
            elif _begins(path, _GZIP):
                file = files.enter_context(gzip.open(path))
            elif path.stat().st_size > _MAX_BYTES:
                raise unreadable(marked("too large"))
            else:
                return path.read_bytes()
            # In parts, since a few bytes may be packed gigabytes.
            while part := file.read(1 << 20):
                data += part
                if len(data) > _MAX_BYTES:
                    raise unreadable(marked("too large"))
    except KeyError as error:
        raise unreadable(marked("not in the archive any more")) from error
    except _DAMAGED as error:
        raise unreadable(marked("damaged, or encrypted")) from error
    return bytes(data)


def _members(path: Path) -> list[str]:
    """The names of the files in a zip archive, sorted. Raises `UserError`, OSError."""
    with zipfile.ZipFile(path) as archive:
        # A member without a name is none; asked whether it is a folder, zipfile raises an IndexError.
        names = [one.filename for one in archive.infolist()[:_MAX_MEMBERS] if one.filename and not one.is_dir()]
    if "[Content_Types].xml" in names or "mimetype" in names:
        raise UserError(marked("This is a spreadsheet: save it as CSV."))
    return sorted(name for name in names if not any(part.startswith((".", "__MACOSX")) for part in name.split("/")))


def find_logs(paths: Iterable[Path]) -> Iterator[Path]:
    """Yields files as given, those in and below folders by name, and those in archives; and folders that cannot be
    listed.

    In folders everything is a log but what is known to be none: what cannot be read has to be said.
    """
    for path in paths:
        refused: list[OSError] = []
        for folder, names, files in os.walk(path, onerror=refused.append):
            names[:] = sorted(name for name in names if not name.startswith("."))
            for name in sorted(files):
                if Path(name).suffix.lower() not in _NOT_LOGS and not name.lower().startswith((".", "readme")):
                    yield from _with_members(Path(folder) / name)
        for error in refused:  # also where the path is a file
            yield from _with_members(Path(error.filename))


def _with_members(path: Path) -> list[Path]:
    """The files in a zip archive, as paths below it; the path of any other file, and of what cannot be opened."""
    with suppress(OSError, UserError, *_DAMAGED):  # is said when it is read
        if path.is_file() and _begins(path, _ZIP):
            return [path / name for name in _members(path)] or [path]
    return [path]


def distinct_names(paths: Sequence[Path]) -> list[str]:
    """The names of the files; the whole path of those that share one."""
    counts = Counter(path.name for path in paths)
    return [path.name if counts[path.name] == 1 else path.as_posix() for path in paths]


# Many logs


class SummarisedLog(NamedTuple):
    """`flight` is None where the log cannot be read; then `why_not` says why."""

    path: Path
    flight: FlightSummary | None
    why_not: UserMessage | None = None
    # The names of the columns of a table that cannot be read.
    head: tuple[str, ...] = ()


def summarise_log(path: Path, columns: CsvColumns | None = None) -> SummarisedLog:
    """Reads and summarises one log. `columns`: of a table, None recognises them by name."""
    try:
        return SummarisedLog(path, FlightSummary(read_flight_log(path, columns)))
    except UserError as error:
        head = error.head if isinstance(error, UnreadTable) else ()
        return SummarisedLog(path, None, error.message, head)
