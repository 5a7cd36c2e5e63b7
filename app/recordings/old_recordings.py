"""Converts what versions before session files wrote: folders of columns, captures as text (`.dpscap`), MCAP exports.

Nothing else knows these formats; this module can be deleted once nobody has such files any more.
"""

import base64
import json
import struct
import zlib
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from operator import itemgetter
from pathlib import Path
from typing import Final

import numpy as np

from app.captures.entries import CaptureEntry, Way
from app.captures.text import TimedLines
from app.recordings.library import TRASH, is_held
from app.recordings.markers import MarkerKind
from app.recordings.session_format import OLD_EXPORT, RX, SUFFIX, TX, Opening, is_time
from app.recordings.writer import Note, write_session
from app.text.user_error import UserError
from protocol.translatable import marked

_SESSION: Final = "session.json"
_COLUMNS: Final = {
    "status.time_s.f8": (8, 0), "status.tilt_deg.f4": (4, 0), "status.acceleration_g.f4": (4, 0),
    "status.flags.u1": (1, 0), "cell.time_s.f8": (8, 1), "cell.voltage_v.f4": (4, 1), "light.time_s.f8": (8, 2),
    "light.voltage_v.f4": (4, 2), "line.dpscap": (1, 3), "journal.jsonl": (1, 4),
}  # fmt: skip
"""Bytes of a row, and which count of a commit is theirs."""
_COMMIT: Final = struct.Struct("<d5Q4L")
_LIMITS: Final = {"attitude_threshold_deg": "fires_deg", "reset_angle_deg": "rearms_deg",
                  "freefall_acceleration_g": "free_fall_g", "light_threshold_v": "light_v"}  # fmt: skip
_EXACT_S: Final = 1e-6
"""The line's times have six decimals; those of the reports are exact."""


def old_recordings(library: Path) -> list[Path]:
    """The folders in a library that are still to be converted, without those being written."""
    try:
        return sorted(path for path in library.iterdir() if (path / _SESSION).is_file() and not is_held(path / "lock"))
    except OSError:
        return []


def highest_sequence(library: Path) -> int:
    """Of the recordings that are still to be converted."""
    highest = 0
    for folder in old_recordings(library):
        try:
            highest = max(highest, _opening_of(folder).sequence)
        except (OSError, UserError):
            continue
    return highest


def convert_in(library: Path, folder: Path) -> Path:
    """Converts a folder of a library beside itself, then moves it to the trash. Raises OSError, `UserError`."""
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
    """Writes a recording, a capture or an export as a session file. Raises OSError, `UserError`."""
    if path.is_dir():
        _convert_folder(path, target)
    elif path.suffix.lower() == SUFFIX:
        _convert_export(path, target)
    else:
        _convert_capture(path, target)


def _convert_capture(path: Path, target: Path) -> None:
    lines = path.read_text("utf-8-sig", "replace").splitlines()
    fields = dict(line[1:].strip().partition(": ")[::2] for line in reversed(lines) if line.startswith("#"))
    rate = fields.get("baud_rate", "")
    opening = Opening(
        started_at=_time_of(fields.get("started", ""), path), start_s=0.0, port=fields.get("port", ""),
        baud_rate=int(rate) if rate.isdecimal() else 0, program=fields.get("program", ""),
    )  # fmt: skip
    write_session(target, opening, entries_in(lines))


def entries_in(lines: Iterable[str]) -> Iterator[CaptureEntry]:
    """Of a capture as text; what cannot be read is left out."""
    return filter(None, map(TimedLines().feed, lines))


def _time_of(text: str, path: Path) -> datetime:
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        time = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    return time if time.tzinfo else time.replace(tzinfo=UTC)


def _convert_export(path: Path, target: Path) -> None:
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    try:
        with path.open("rb") as file:
            reader = make_reader(file)
            about = next((record.metadata for record in reader.iter_metadata() if record.name == OLD_EXPORT), None)
            if about is None:
                raise UserError(marked("not a recording by this program"))
            opening = Opening(
                started_at=_time_of(about["started_at"], path), start_s=0.0, port=about["port"],
                baud_rate=int(about["baud_rate"]), module=about["module"], program=about["program"],
            )  # fmt: skip
            entries, notes = list[CaptureEntry](), list[Note]()
            ways = {RX: Way.IN, TX: Way.OUT}
            for _schema, channel, message in reader.iter_messages():
                at_s, fields = opening.mono_s(message.log_time), json.loads(message.data)
                if channel.topic in ways:
                    entries.append(CaptureEntry(at_s, ways[channel.topic], base64.b64decode(fields["data"])))
                elif channel.topic == "/limits":
                    notes.append((at_s, {"event": "limits"} | {_LIMITS[key]: value for key, value in fields.items()}))
                elif channel.topic == "/events":
                    notes.append((at_s, fields))
                elif channel.topic != "/status":  # which is in the bytes
                    notes.append((at_s, {"event": "reading", **fields}))
    except (McapError, ValueError, KeyError, TypeError, AttributeError, RecursionError, struct.error) as error:
        raise UserError(marked("cannot be read")) from error
    write_session(target, opening, entries, notes, is_ended=about.get("was_cut_off") != "true")


def _opening_of(folder: Path) -> Opening:
    try:
        fields = json.loads((folder / _SESSION).read_bytes())
        if fields["version"] != 1:
            raise UserError(marked("written by a newer version"))
        return Opening(
            started_at=datetime.fromisoformat(fields["started_at"]), start_s=float(fields["start_s"]),
            port=str(fields["port"]), baud_rate=int(fields["baud_rate"]), module=str(fields.get("module", "")),
            program=str(fields.get("program", "")), sequence=int(fields.get("sequence", 0)),
        )  # fmt: skip
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
        raise UserError(marked("damaged")) from error


def _convert_folder(folder: Path, target: Path) -> None:
    opening = _opening_of(folder)
    data, gaps, is_ended, end_s = _committed(folder, opening)
    times = np.frombuffer(data["status.time_s.f8"], "<f8")
    notes: list[Note] = [(at_s, {"event": MarkerKind.DAMAGED.value}) for at_s in gaps]
    for table, name, key in (("cell", "voltage_v", "cell_voltage_v"), ("light", "voltage_v", "light_v")):
        columns = (np.frombuffer(data[f"{table}.{column}"], kind) for column, kind in
                   (("time_s.f8", "<f8"), (f"{name}.f4", "<f4")))  # fmt: skip
        notes += [(float(at_s), {"event": "reading", key: round(float(value), 4)})
                  for at_s, value in zip(*columns, strict=True)]  # fmt: skip
    notes += _journal(data["journal.jsonl"])
    notes.sort(key=itemgetter(0))
    entries = _line(data["line.dpscap"], opening.start_s, times)
    write_session(target, opening, entries, notes, end_s=end_s, is_ended=is_ended, is_private=True)


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
        checksum = 0
        for name, span in spans.items():
            checksum = zlib.crc32(raw[name][span], checksum)
        if checksum == crc:
            for name, span in spans.items():
                whole[name] += raw[name][span]
        else:
            gaps.append(before_s)
        before, before_s, is_ended = tuple(counts), at_s, bool(is_last)
    return {name: bytes(part) for name, part in whole.items()}, gaps, is_ended, before_s


def _line(text: bytes, start_s: float, times: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> Iterator[CaptureEntry]:
    for since_s, way, raw in entries_in(text.decode("utf-8", "replace").splitlines()):
        at_s = start_s + since_s
        place = int(np.searchsorted(times, at_s - _EXACT_S)) if way is Way.IN else len(times)
        is_report = place < len(times) and abs(times[place] - at_s) <= _EXACT_S
        yield CaptureEntry(float(times[place]) if is_report else at_s, way, raw)


def _journal(raw: bytes) -> Iterator[Note]:
    for line in raw.splitlines():
        try:
            fields = json.loads(line)
            at_s, what = float(fields.pop("at")), fields.pop("what")
        except (ValueError, RecursionError, KeyError, AttributeError, TypeError):
            continue
        if is_time(at_s):
            yield at_s, {"event": str(fields.pop("kind", what)).replace("_", " "), **fields}
