"""Was a record altered, where, and does its chain hold?

Reads the record out of whatever file it is in: the JSON, the HTML page (which carries it), or the PDF (attached).
The page of an HTML or PDF file has a seal of its own: SHA-256 of the file before it, and of the record's hash.
"""

import hashlib
import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import islice
from pathlib import Path

from app.preflight.record import FORMAT, READABLE_VERSIONS, FindRecord, Record, canonical, digest, digests_of
from app.preflight.wording import Said, clean, said
from protocol.text import marked

LARGEST_FILE = 64_000_000
_SEAL = re.compile(rb"\n(?:%|<!-- )DPS-S page seal ([0-9a-f]{64})(?: -->)?\n\Z")
_IN_HTML = re.compile(rb'<script type="application/json" id="record">(.*?)</script>', re.DOTALL)
_STREAM = re.compile(rb"stream\r?\n(.*?)\r?\n?endstream", re.DOTALL)
_LARGEST_STREAM = 16_000_000
_MOST_STREAMS = 200
"""Ours have a dozen; a file made to keep us busy has more."""


class State(Enum):
    INTACT = "intact"
    ALTERED = "altered"
    CHAIN_BROKEN = "chain broken"
    UNREADABLE = "unreadable"


class Chain(Enum):
    """The value is English, translatable."""

    FIRST = marked("the first record of this module")
    LINKED = marked("the record before it is there and intact")
    NOT_AT_HAND = marked("the record before it is not on this computer")
    ALONE = marked("it was not kept when it was made, so it is in no chain")
    BROKEN = marked("the record before it was altered or is another one")


@dataclass(frozen=True, slots=True)
class Verification:
    """`altered`: the parts that are not what was recorded ("checks.cell_voltage", "verdict", "page" …)."""

    state: State
    record: Mapping[str, object] | None = None
    altered: tuple[str, ...] = ()
    chain: Chain | None = None
    is_known_here: bool = False
    """The store of this computer holds the same record."""
    why: Said | None = None

    def sentences(self) -> tuple[Said, ...]:
        """What to tell a person: the judgement, which record it is, then its chain and whether it is kept here."""
        match self.state:
            case State.UNREADABLE:
                first = said(marked("No pre-flight record can be read in it: {why}."), why=self.why or Said(""))
            case State.ALTERED:
                first = said(marked("ALTERED: {parts}."), parts=", ".join(self.altered))
            case State.CHAIN_BROKEN:
                first = said(marked("CHAIN BROKEN: the record itself is intact."))
            case State.INTACT:
                first = said(marked("INTACT: every part is as it was recorded."))
        rest = [] if self.record is None else [_introduced(self.record)]
        if self.chain is not None:
            rest.append(said(marked("Chain: {what}."), what=Said(self.chain.value)))
        if self.record is not None:
            known = marked("This computer keeps the same record.")
            rest.append(said(known if self.is_known_here else marked("This computer does not keep this record.")))
        return (first, *rest)


def _introduced(record: Mapping[str, object]) -> Said:
    """Which record it is. What stands in a file may be anything: it is cleaned, and cut where it is long."""
    module, who = record.get("module"), record.get("who")
    return said(
        marked("Record {number} of {module}: {verdict}, {at}, checked by {who}."),
        number=_shown(record.get("number")),
        module=_shown(module) if module else said(marked("a module without a name")),
        verdict=_shown(record.get("verdict")),
        at=_shown(record.get("at")),
        who=_shown(who) if who else said(marked("nobody named")),
    )


def _shown(value: object) -> str:
    return clean(str(value), longest=60)


class NoRecord(Exception):
    def __init__(self, why: Said) -> None:
        super().__init__(why.in_english())
        self.why = why


def verify_file(path: Path, find: FindRecord | None = None) -> Verification:
    """Raises `OSError` where the file cannot be read."""
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    return verify_bytes(data, find)


def verify_bytes(data: bytes, find: FindRecord | None = None) -> Verification:
    try:
        record = record_in(data)
    except NoRecord as error:
        return Verification(State.UNREADABLE, why=error.why)
    verification = verify(record, find)
    fault = _page_fault(data, record)
    if fault is None or verification.state is State.UNREADABLE:
        return verification
    altered = (*verification.altered, fault)
    return Verification(
        State.ALTERED, record, altered, chain=verification.chain, is_known_here=verification.is_known_here
    )


def verify(record: Mapping[str, object], find: FindRecord | None = None) -> Verification:
    """`find` looks a record up by its hash, in the store of this computer."""
    if record.get("format") != FORMAT:
        return Verification(State.UNREADABLE, why=said(marked("it is another kind of file")))
    if record.get("version") not in READABLE_VERSIONS:
        return Verification(State.UNREADABLE, why=said(marked("it was written by a newer version of this program")))
    kept = find(str(record.get("hash"))) if find is not None else None
    try:
        altered = _altered(record, kept)
    except (ValueError, RecursionError):
        return Verification(State.UNREADABLE, why=said(marked("it holds what no record holds")))
    chain = _chain(record, find)
    state = State.ALTERED if altered else State.CHAIN_BROKEN if chain is Chain.BROKEN else State.INTACT
    return Verification(state, record, altered, chain, is_known_here=kept is not None and not altered)


def _altered(record: Mapping[str, object], kept: Mapping[str, object] | None) -> tuple[str, ...]:
    now, then = digests_of(record), record.get("digests")
    if not isinstance(then, Mapping):
        return ("digests",)
    names = [*now, *(name for name in then if name not in now)]
    altered = [clean(name, longest=80) for name in names if now.get(name) != then.get(name)]
    if record.get("hash") != digest(then):
        altered.append("hash")
    if not altered and kept is not None and canonical(kept) != canonical(record):
        altered.append("digests")
    return tuple(altered)


def _chain(record: Mapping[str, object], find: FindRecord | None) -> Chain:
    previous = record.get("previous")
    if previous is None and record.get("number") == 0:
        return Chain.ALONE
    if previous is None:
        return Chain.FIRST if record.get("number") == 1 else Chain.BROKEN
    before = find(str(previous)) if find is not None else None
    if before is None:
        return Chain.NOT_AT_HAND
    number = before.get("number")
    follows = isinstance(number, int) and record.get("number") == number + 1
    is_same_chain = _chain_name(before) == _chain_name(record)
    return Chain.LINKED if follows and is_same_chain and not _altered(before, None) else Chain.BROKEN


def _chain_name(record: Mapping[str, object]) -> tuple[object, object]:
    """Modules without a name have a chain for each adapter."""
    module = record.get("module")
    return module, record.get("adapter") if module is None else None


# Files


def record_in(data: bytes) -> Record:
    """Raises `NoRecord`."""
    if len(data) > LARGEST_FILE:
        raise NoRecord(said(marked("it is too large")))
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
        raise NoRecord(said(marked("it is no JSON, or damaged"))) from error
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise NoRecord(said(marked("it is another kind of file")))
    return value


def _refuse(name: str) -> object:
    raise ValueError(name)


def _only_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """A name that stands twice would show one value to one program and another to the next."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a name stands twice")
    return found


def _from_pdf(data: bytes) -> Record:
    for stream in islice(_STREAM.finditer(data), _MOST_STREAMS):
        for content in (stream[1], _inflated(stream[1])):
            if content.lstrip()[:1] == b"{" and FORMAT.encode() in content:
                return _from_json(content)
    raise NoRecord(said(marked("no record is attached to this PDF")))


def _inflated(data: bytes) -> bytes:
    try:
        return zlib.decompressobj().decompress(data, _LARGEST_STREAM)
    except zlib.error:
        return b""


def page_seal(data: bytes, record: Mapping[str, object]) -> str:
    return hashlib.sha256(data + str(record.get("hash")).encode()).hexdigest()


def sealed_pdf(data: bytes, record: Mapping[str, object]) -> bytes:
    """A PDF with its seal as a comment behind its end, where readers look past it."""
    return data + f"\n%DPS-S page seal {page_seal(data, record)}\n".encode()


def sealed_html(data: bytes, record: Mapping[str, object]) -> bytes:
    return data + f"\n<!-- DPS-S page seal {page_seal(data, record)} -->\n".encode()


def _page_fault(data: bytes, record: Mapping[str, object]) -> str | None:
    """What is wrong with the page around the record; None for a bare record."""
    if not data.startswith(b"%PDF-") and data.lstrip()[:1] != b"<":
        return None
    seal = _SEAL.search(data)
    if seal is None:
        return "page seal"
    return None if seal[1].decode() == page_seal(data[: seal.start()], record) else "page"
