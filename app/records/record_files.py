"""Extracts the record from a file: JSON, HTML page or PDF attachment. Input is untrusted."""

import json
import re
import zlib
from itertools import islice

from app.records.record import FORMAT, Record
from app.text.messages import UserMessage, message
from protocol.translatable import marked

LARGEST_FILE = 64_000_000
_IN_HTML = re.compile(rb'<script type="application/json" id="record">(.*?)</script>', re.DOTALL)
_STREAM = re.compile(rb"stream\r?\n(.*?)\r?\n?endstream", re.DOTALL)
_LARGEST_STREAM = 16_000_000
_MAX_STREAMS = 200
"""Bounds the work on a hostile file; our PDFs have a dozen."""


class NoRecord(Exception):
    def __init__(self, why: UserMessage) -> None:
        super().__init__(why.in_english())
        self.why = why


def record_in(data: bytes) -> Record:
    """Raises `NoRecord`."""
    if len(data) > LARGEST_FILE:
        raise NoRecord(message(marked("too large")))
    if data.startswith(b"%PDF-"):
        return _from_pdf(data)
    embedded = _IN_HTML.search(data) if data.lstrip()[:1] == b"<" else None
    if embedded is not None:
        return _from_json(embedded[1])
    return _from_json(data)


def _from_json(data: bytes) -> Record:
    try:
        value = json.loads(data, parse_constant=_refuse, object_pairs_hook=_only_once)
    except (ValueError, RecursionError) as error:
        raise NoRecord(message(marked("no JSON, or damaged"))) from error
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise NoRecord(message(marked("unknown kind of file")))
    return value


def _refuse(name: str) -> object:
    raise ValueError(name)


def _only_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Refuses duplicate names, of which programs read different values."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("duplicate name")
    return found


def _from_pdf(data: bytes) -> Record:
    for stream in islice(_STREAM.finditer(data), _MAX_STREAMS):
        for content in (stream[1], _inflated(stream[1])):
            if content.lstrip()[:1] == b"{" and FORMAT.encode() in content:
                return _from_json(content)
    raise NoRecord(message(marked("unknown kind of file")))


def _inflated(data: bytes) -> bytes:
    try:
        return zlib.decompressobj().decompress(data, _LARGEST_STREAM)
    except zlib.error:
        return b""
