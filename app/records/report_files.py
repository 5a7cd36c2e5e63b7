"""Files of a record: JSON, the PDF report that carries it, or the HTML page of older versions.

Writes FILE.pdf with FILE.json, the record alone, beside it, each atomically. What is read is untrusted.
"""

import json
import re
import unicodedata
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path

from app.records.labels import A4, Printer
from app.records.record import FORMAT, Record, as_text, recorded_verdict
from app.records.report_html import body
from app.system.files import write_whole
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked

LARGEST_FILE = 64_000_000
_IN_HTML = re.compile(rb'<script type="application/json" id="record">(.*?)</script>', re.DOTALL)
_STREAM = re.compile(rb"stream\r?\n(.*?)\r?\n?endstream", re.DOTALL)
_LARGEST_STREAM = 16_000_000
_MAX_STREAMS = 200
"""Bounds the work on a hostile file; our PDFs have a dozen."""


def is_report(data: bytes) -> bool:
    """Whether this is a PDF or an HTML page, not a bare record."""
    return data.startswith(b"%PDF-") or data.lstrip()[:1] == b"<"


def record_in(data: bytes) -> Record:
    """Raises `UserError`, also where a report carries several records: a person could be shown one and told another."""
    if len(data) > LARGEST_FILE:
        raise UserError(marked("too large"))
    if not is_report(data):
        return _from_json(data)
    carried = carried_in_pdf(data) if data.startswith(b"%PDF-") else (match[1] for match in _IN_HTML.finditer(data))
    records = [_from_json(text) for text in carried]
    if len(records) != 1:
        raise UserError(marked("several records") if records else marked("unknown kind of file"))
    return records[0]


def _from_json(data: bytes) -> Record:
    try:
        value = json.loads(data, parse_constant=_refuse, object_pairs_hook=_only_once)
    except (ValueError, RecursionError) as error:
        raise UserError(marked("damaged")) from error
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise UserError(marked("unknown kind of file"))
    return value


def _refuse(name: str) -> object:
    raise ValueError(name)


def _only_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Refuses duplicate names, of which programs read different values."""
    fields = dict(pairs)
    if len(fields) != len(pairs):
        raise ValueError("duplicate name")
    return fields


def carries(kind: str, data: bytes) -> bool:
    """Whether a PDF has a document of this format."""
    return any(carried_in_pdf(data, kind))


def carried_in_pdf(data: bytes, kind: str = FORMAT) -> Iterator[bytes]:
    """The JSON documents of this format that are attached to a PDF."""
    for stream in islice(_STREAM.finditer(data), _MAX_STREAMS):
        for content in (stream[1], _inflated(stream[1])):
            if content.lstrip()[:1] == b"{" and kind.encode() in content:
                yield content


def _inflated(data: bytes) -> bytes:
    try:
        return zlib.decompressobj().decompress(data, _LARGEST_STREAM)
    except zlib.error:
        return b""


_NOT_IN_NAMES = re.compile(r"[^\w\-]+")
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")
MAX_NAME_LENGTH = 60


def is_record(data: bytes) -> bool:
    try:
        record_in(data)
    except UserError:
        return False
    return True


def check_target(path: Path, is_ours: Callable[[bytes], bool] = is_record, *, beside: str = ".json") -> None:
    """Raises `UserError` where the PDF, and the file of this suffix beside it, cannot be written there. `is_ours`:
    whether a file of this content may be replaced."""
    if path.suffix.lower() != ".pdf":
        why = message(marked("expected {expected}"), expected=".pdf")
        raise UserError(marked("{value}: {why}."), value=path.name, why=why)
    if not path.parent.is_dir():
        raise UserError(marked("There is no folder {folder}."), folder=path.parent)
    for target in (path, path.with_suffix(beside)):
        if target.exists() and not is_ours(_content(target)):
            text = marked("{file} exists and is another kind of file.")
            raise UserError(text, file=target)


def _content(path: Path) -> bytes:
    with suppress(OSError):
        return path.read_bytes()
    return b""


def write_report(path: Path, record: Record, printer: Printer) -> tuple[Path, ...]:
    """Writes the record before it prints, so that a failing printer loses nothing; returns the files written. Raises
    `UserError` as `check_target`, `OSError` or `RuntimeError`; files written before that remain."""
    check_target(path)
    json_path, plain = path.with_suffix(".json"), as_text(record).encode()
    write_whole(json_path, plain)
    write_whole(path, printer([body(record)], A4, plain))
    return json_path, path


def suggested_name(record: Record) -> str:
    """A valid file name without suffix for any module name: "M-07 2026-11-21 1403 GO"."""
    parts = (str(record.get("module") or ""), str(record.get("at"))[:16].replace("T", " ").replace(":", ""))
    return file_name(*parts, recorded_verdict(record).value)


def file_name(*parts: str) -> str:
    """A valid file name without suffix from any texts."""
    words = [_NOT_IN_NAMES.sub("_", unicodedata.normalize("NFKC", part[:MAX_NAME_LENGTH])).strip("_") for part in parts]
    name = " ".join(word for word in words if word)[:MAX_NAME_LENGTH]
    return f"DPS-S {name}" if _RESERVED.match(name) else name
