"""A fact: one record of a station, with the same id on every computer.

    payload     a JSON object as ASCII text
    id          SHA-256 of kind, station, time and payload: the same fact, the same id
    station     the public key of the station that recorded it
    signature   that station's signature of the id

A fact is never changed. Everything that comes from a server or a file passes through `checked`, which detects altered
facts and facts forged in the name of another station.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import Enum
from typing import Final

from app.stations.station import KEY_BYTES, Station, decoded, encoded, is_signature
from app.store.audit_chain import AuditRow
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

DOMAIN: Final = "dps-s fact 1"
"""Prefix of what is hashed and signed; distinguishes versions of the format."""
MAX_PAYLOAD_LENGTH: Final = 8_000_000
MAX_TIME_LENGTH: Final = 40
SIGNATURE_BYTES: Final = 64
_ID: Final = re.compile("[0-9a-f]{64}")
_KIND: Final = re.compile("[a-z][a-z_]{0,39}")

FactRow = tuple[object, ...]
"""An unchecked fact from outside, in the order of `FACT_COLUMNS`."""
FACT_COLUMNS: Final = ("id", "kind", "station", "made_at", "payload", "signature")


class FactKind(Enum):
    """The kinds that this version knows. Facts of other kinds, from newer versions, are stored and passed on."""

    MODULE = "module"
    """A station named a module."""
    TRIGGER_RECORD = "trigger_record"
    JUDGEMENT = "judgement"
    """A person's judgement of a trigger record."""
    SNAPSHOT = "settings_snapshot"
    CHECK = "preflight_check"
    GUIDED_TEST = "guided_test"
    AUDIT = "audit_link"
    """One link of a station's audit chain: the start of an act, or its outcome."""
    SETTLEMENT = "settlement"
    """A person's decision whether two modules are the same one."""


@dataclass(frozen=True, slots=True)
class Fact:
    """Made by `make_fact` or `checked`."""

    id: str
    kind: str
    station: str
    made_at: str
    payload: str
    signature: str

    @property
    def content(self) -> Mapping[str, object]:
        value = json.loads(self.payload)
        return value if isinstance(value, dict) else {}

    @property
    def module(self) -> str | None:
        """Name of the module that it is about. Of an act on a module it is in the detail, which the chain covers."""
        row = self.audit_row
        name = (self.content if row is None else _object_in(row.detail)).get("module")
        return name if isinstance(name, str) else None

    @property
    def audit_row(self) -> AuditRow | None:
        """None for facts of other kinds."""
        entry = self.content.get("entry") if self.kind == FactKind.AUDIT.value else None
        return AuditRow(*entry) if isinstance(entry, list) and len(entry) == len(AuditRow._fields) else None

    @property
    def row(self) -> tuple[str, ...]:
        return (self.id, self.kind, self.station, self.made_at, self.payload, self.signature)


@dataclass(frozen=True, slots=True)
class RefusedFact:
    """A row that is not a valid fact. `id`, `kind`, `made_at`: as stated in the row."""

    id: str
    kind: str
    made_at: str
    why: UserMessage

    def sentence(self) -> UserMessage:
        text = marked("{kind} of {at} ({id}): {why}.")
        return message(text, kind=self.kind or "?", at=self.made_at or "?", id=self.id[:12] or "?", why=self.why)


class FactRefused(Exception):
    """The row is not imported."""

    def __init__(self, refusal: RefusedFact) -> None:
        super().__init__(refusal.why.in_english())
        self.refusal = refusal


def fact_id(kind: str, station: str, made_at: str, payload: str) -> str:
    text = f"{DOMAIN}\n{kind}\n{station}\n{made_at}\n{payload}"
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def payload_of(content: Mapping[str, object]) -> str:
    """Raises `ValueError` if it is not JSON."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)


def make_fact(kind: FactKind, made_at: str, content: Mapping[str, object], station: Station) -> Fact:
    """Signed by this station."""
    public, payload = encoded(station.public), payload_of(content)
    id_ = fact_id(kind.value, public, made_at, payload)
    return Fact(id_, kind.value, public, made_at, payload, encoded(station.sign(_signed(id_))))


def row_digest(row: FactRow) -> str:
    """Digest over all columns, as the server computes it: detects differences, and is not a proof."""
    return hashlib.md5("|".join(map(str, row)).encode("utf-8", "replace"), usedforsecurity=False).hexdigest()


def checked(row: FactRow) -> Fact:
    """Verify a row of a server or a file. Raises `FactRefused`."""
    if len(row) != len(FACT_COLUMNS) or not all(isinstance(one, str) for one in row):
        raise _refused(row, marked("it is not whole"))
    id_, kind, station, made_at, payload, signature = map(str, row)
    public, seal = decoded(station, KEY_BYTES), decoded(signature, SIGNATURE_BYTES)
    is_shaped = _ID.fullmatch(id_) and _KIND.fullmatch(kind) and public is not None and seal is not None
    if not is_shaped or len(payload) > MAX_PAYLOAD_LENGTH or not payload.isascii() or not _is_time(made_at):
        raise _refused(row, marked("it is not whole"))
    if fact_id(kind, station, made_at, payload) != id_:
        raise _refused(row, marked("it was altered"))
    if public is None or seal is None or not is_signature(public, seal, _signed(id_)):
        raise _refused(row, marked("its station did not sign it"))
    if not _is_object(payload):
        raise _refused(row, marked("it is not whole"))
    return Fact(id_, kind, station, made_at, payload, signature)


def stored_fact(row: FactRow, digest: str) -> Fact:
    """A fact of this computer, verified when it was imported; `digest` is from then. Raises `FactRefused`."""
    if row_digest(row) != digest:
        raise _refused(row, marked("it was altered"))
    return Fact(*map(str, row))


def utc_time(text: str) -> str:
    """A time in UTC with milliseconds, so that times sort as text. Raises `ValueError`."""
    at = datetime.fromisoformat(text)
    return at.replace(tzinfo=at.tzinfo or UTC).astimezone(UTC).isoformat(timespec="milliseconds")


def _object_in(text: object) -> Mapping[str, object]:
    try:
        value = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}


def _signed(id_: str) -> bytes:
    return f"{DOMAIN}\n{id_}\n".encode("ascii")


def _refused(row: FactRow, why: str) -> FactRefused:
    def shown(place: int) -> str:
        return clean(str(row[place]), longest=64) if place < len(row) else ""

    return FactRefused(RefusedFact(shown(0), shown(1), shown(3), message(why)))


def _is_time(text: str) -> bool:
    try:
        return len(text) <= MAX_TIME_LENGTH and text.isascii() and datetime.fromisoformat(text).tzinfo is not None
    except ValueError:
        return False


def _is_object(payload: str) -> bool:
    try:
        return isinstance(json.loads(payload, parse_constant=_no_constant), dict)
    except (ValueError, RecursionError):
        return False


def _no_constant(name: str) -> float:
    raise ValueError(name)
