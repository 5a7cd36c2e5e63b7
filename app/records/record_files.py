"""Extracts the record from a file: JSON, the PDF that carries it, or the HTML page of older versions.

Input is untrusted.
"""

import json
import re
import zlib
from collections.abc import Iterator
from itertools import islice

from app.records.record import FORMAT, Record
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
    carried = carried_in_pdf(data) if data.startswith(b"%PDF-") else (found[1] for found in _IN_HTML.finditer(data))
    records = [_from_json(text) for text in carried]
    if len(records) != 1:
        raise UserError(marked("several records") if records else marked("unknown kind of file"))
    return records[0]


def _from_json(data: bytes) -> Record:
    try:
        value = json.loads(data, parse_constant=_refuse, object_pairs_hook=_only_once)
    except (ValueError, RecursionError) as error:
        raise UserError(marked("no JSON, or damaged")) from error
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise UserError(marked("unknown kind of file"))
    return value


def _refuse(name: str) -> object:
    raise ValueError(name)


def _only_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Refuses duplicate names, of which programs read different values."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("duplicate name")
    return found


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
