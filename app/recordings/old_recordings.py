"""Converts what versions before session files wrote: folders of columns, and captures as text (`.dpscap`).

Nothing else knows these formats; this module can be deleted once nobody has such files any more.
"""

import json
import struct
import zlib
from collections.abc import Iterator
from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from typing import Final

import numpy as np

from app.captures.entries import CaptureEntry, Way
from app.captures.reader import CaptureReader, read_text
from app.recordings.library import TRASH, is_held
from app.recordings.markers import MarkerKind
from app.recordings.session_format import SUFFIX, Opening, Unreadable, is_time
from app.recordings.writer import Note, SessionWriter, write_session
from app.system.files import draft_of
from protocol.translatable import marked

CAPTURE: Final = ".dpscap"
_SESSION: Final = "session.json"
_COLUMNS: Final = {
    "status.time_s.f8": (8, 0), "status.tilt_deg.f4": (4, 0), "status.acceleration_g.f4": (4, 0),
    "status.flags.u1": (1, 0), "cell.time_s.f8": (8, 1), "cell.voltage_v.f4": (4, 1), "light.time_s.f8": (8, 2),
    "light.voltage_v.f4": (4, 2), "line.dpscap": (1, 3), "journal.jsonl": (1, 4),
}  # fmt: skip
"""Bytes of a row, and which count of a commit is theirs."""
_COMMIT: Final = struct.Struct("<d5Q4L")
_EXACT_S: Final = 1e-6
"""The line's times have six decimals; those of the reports are exact."""


def is_old(path: Path) -> bool:
    return path.suffix.lower() == CAPTURE or (path / _SESSION).is_file()


def old_recordings(library: Path) -> list[Path]:
    """The folders in a library that are still to be converted, without those being written."""
    try:
        return sorted(path for path in library.iterdir() if (path / _SESSION).is_file() and not is_held(path / "lock"))
    except OSError:
        return []


def highest_sequence(library: Path) -> int:
    """Of the recordings that are still to be converted."""
    found = 0
    for folder in old_recordings(library):
        try:
            found = max(found, _opening_of(folder).sequence)
        except (OSError, Unreadable):
            continue
    return found


def convert_in(library: Path, folder: Path) -> Path:
    """Converts a folder of a library beside itself, then moves it to the trash. Raises OSError, `Unreadable`."""
    target = folder.with_name(folder.name + SUFFIX)
    if not target.exists():
        convert(folder, target)
    if (folder / "kept").exists():
        target.with_suffix(".kept").touch(mode=0o600)
    trash = library / TRASH
    trash.mkdir(mode=0o700, exist_ok=True)
    folder.rename(trash / folder.name)
    return target


def convert(path: Path, target: Path) -> None:
    """Writes a recording or a capture as a session file. Raises OSError, `Unreadable`, `CaptureRefused`."""
    if path.suffix.lower() == CAPTURE:
        _convert_capture(path, target)
    else:
        _convert_folder(path, target)


def _convert_capture(path: Path, target: Path) -> None:
    reader = CaptureReader()
    with path.open("rb") as file:
        entries = [entry for some in read_text(file, reader) for entry in some]
    header = reader.header
    try:
        started_at = datetime.fromisoformat(header.started)
    except ValueError:
        started_at = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    opening = Opening(
        started_at=started_at if started_at.tzinfo else started_at.replace(tzinfo=UTC),
        start_s=0.0, port=header.port, baud_rate=header.baud_rate or 0, program=header.program,
    )  # fmt: skip
    write_session(target, opening, entries)


def _opening_of(folder: Path) -> Opening:
    try:
        fields = json.loads((folder / _SESSION).read_bytes())
        if fields["version"] != 1:
            raise Unreadable(marked("written by a newer version"))
        return Opening(
            started_at=datetime.fromisoformat(fields["started_at"]), start_s=float(fields["start_s"]),
            port=str(fields["port"]), baud_rate=int(fields["baud_rate"]), module=str(fields.get("module", "")),
            program=str(fields.get("program", "")), sequence=int(fields.get("sequence", 0)),
        )  # fmt: skip
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
        raise Unreadable(marked("damaged heading")) from error


def _convert_folder(folder: Path, target: Path) -> None:
    opening = _opening_of(folder)
    data, gaps, is_ended, end_s = _committed(folder, opening)
    times = np.frombuffer(data["status.time_s.f8"], "<f8")
    notes = [Note(at_s, MarkerKind.DAMAGED.value, {}) for at_s in gaps]
    for table, name, key in (("cell", "voltage_v", "cell_voltage_v"), ("light", "voltage_v", "light_v")):
        columns = (np.frombuffer(data[f"{table}.{column}"], kind) for column, kind in
                   (("time_s.f8", "<f8"), (f"{name}.f4", "<f4")))  # fmt: skip
        notes += [Note(at_s, "reading", {key: round(float(value), 4)}) for at_s, value in zip(*columns, strict=True)]
    notes += _journal(data["journal.jsonl"])
    notes.sort(key=lambda note: note.at_s)
    with draft_of(target, is_private=True) as draft:
        draft.unlink()
        writer = SessionWriter(draft, opening)
        try:
            last_s = writer.put_recorded(_line(data["line.dpscap"], opening.start_s, times), notes)
            writer.flush(max(last_s, end_s))
            if is_ended:
                writer.flush(max(last_s, end_s), is_last=True)
            writer.sync()
        finally:
            writer.close()


def _committed(folder: Path, opening: Opening) -> tuple[dict[str, bytes], list[float], bool, float]:
    """What was committed and is whole, where something else is left out, whether it was closed, and when it ends."""
    raw = {name: (folder / name).read_bytes() for name in _COLUMNS}
    whole = {name: bytearray() for name in raw}
    commits = (folder / "commits.bin").read_bytes()
    before, before_s, gaps, is_ended = (0,) * 5, opening.start_s, list[float](), False
    for record in _COMMIT.iter_unpack(commits[: len(commits) // _COMMIT.size * _COMMIT.size]):
        at_s, *counts, is_last, crc, _, own = record
        if zlib.crc32(_COMMIT.pack(*record)[:60]) != own or not is_time(at_s):
            continue
        spans = {name: slice(before[row] * width, counts[row] * width) for name, (width, row) in _COLUMNS.items()}
        if any(span.start > span.stop or span.stop > len(raw[name]) for name, span in spans.items()):
            continue
        found = 0
        for name, span in spans.items():
            found = zlib.crc32(raw[name][span], found)
        if found == crc:
            for name, span in spans.items():
                whole[name] += raw[name][span]
        else:
            gaps.append(before_s)
        before, before_s, is_ended = tuple(counts), at_s, bool(is_last)
    return {name: bytes(part) for name, part in whole.items()}, gaps, is_ended, before_s


def _line(text: bytes, start_s: float, times: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Iterator[CaptureEntry]:
    for some in read_text_of(text):
        for since_s, way, raw in some:
            at_s = start_s + since_s
            place = int(np.searchsorted(times, at_s - _EXACT_S)) if way is Way.IN else len(times)
            is_report = place < len(times) and abs(times[place] - at_s) <= _EXACT_S
            yield CaptureEntry(float(times[place]) if is_report else at_s, way, raw)


def read_text_of(text: bytes) -> Iterator[list[CaptureEntry]]:
    reader = CaptureReader()
    for line in BytesIO(text):
        yield list(reader.feed(line.decode("utf-8", "replace")))


def _journal(raw: bytes) -> Iterator[Note]:
    for line in raw.splitlines():
        try:
            fields = json.loads(line)
            at_s, what = float(fields.pop("at")), fields.pop("what")
        except (ValueError, RecursionError, KeyError, AttributeError, TypeError):
            continue
        if is_time(at_s):
            yield Note(at_s, str(fields.pop("kind", what)).replace("_", " "), fields)
