"""A fact: one record of a station, with the same id on every computer.

    payload     a JSON object as ASCII text
    id          SHA-256 of kind, station, time and payload: the same fact, the same id
    station     the public key of the station that recorded it
    signature   that station's signature of the id

A fact is never changed. Everything that comes from a server or a file passes through `checked`, which detects altered
facts and facts forged in the name of another station.
"""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

from app.archive.content import DETAIL, content_of, is_time, object_of
from app.records.verification import is_of_row
from app.stations.station import KEY_BYTES, SIGNATURE_BYTES, Station, decoded, encoded, is_signature
from app.store.facts import FactKind, fact_hash
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

DOMAIN: Final = "dps-s fact 1"
"""Prefix of what is hashed and signed; distinguishes versions of the format."""
MAX_REFUSALS: Final = 1000
"""Rows that are named; further ones are only counted."""
ID_LENGTH: Final = 64
_ID: Final = re.compile(f"[0-9a-f]{{{ID_LENGTH}}}")
_KIND: Final = re.compile("[a-z][a-z_]{0,39}")

FactRow = tuple[object, ...]
"""An unchecked fact from outside, in the order of `FACT_COLUMNS`."""
FACT_COLUMNS: Final = ("id", "kind", "station", "made_at", "payload", "signature")


BUCKET: Final = 2
"""Number of leading characters of an id that select a part of a set of facts for comparison."""
Digests = Mapping[str, tuple[int, str]]
"""By bucket: the number of facts and their digest."""


class StoredRow(NamedTuple):
    """What is known of a row before it is read. `length`: of its payload, in characters."""

    digest: str
    length: int


@dataclass(frozen=True, slots=True)
class Fact:
    """Made by `fact_of`, so that its content is what a fact may contain. `content`: the payload, parsed."""

    id: str
    kind: str
    station: str
    made_at: str
    payload: str
    signature: str
    content: Mapping[str, Any] = field(compare=False, repr=False)

    @property
    def module(self) -> str | None:
        """Name of the module that it is about. Of an act in the former audit log it is in the detail."""
        is_former = self.kind == FactKind.AUDIT.value
        name = (object_of(self.content["entry"][DETAIL]) if is_former else self.content).get("module")
        return name if isinstance(name, str) else None

    @property
    def hash(self) -> str:
        """In the chain of its station."""
        return fact_hash(self.kind, self.made_at, self.payload)

    @property
    def row(self) -> tuple[str, ...]:
        return (self.id, self.kind, self.station, self.made_at, self.payload, self.signature)


class RefusedFact(NamedTuple):
    """A row that is not a valid fact. `id`, `kind`, `made_at`: as stated in the row."""

    id: str
    kind: str
    made_at: str
    why: UserMessage

    def sentence(self) -> UserMessage:
        text = marked("{kind} of {at} ({id}): {why}.")
        return message(text, kind=self.kind or "?", at=self.made_at or "?", id=self.id[:12] or "?", why=self.why)


def fact_id(kind: str, station: str, made_at: str, payload: str) -> str:
    text = f"{DOMAIN}\n{kind}\n{station}\n{made_at}\n{payload}"
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def make_fact(kind: str, made_at: str, payload: str, station: Station) -> Fact:
    """Signed by this station. Raises `ValueError` if it could not be read again."""
    public = encoded(station.public)
    id_ = fact_id(kind, public, made_at, payload)
    return fact_of((id_, kind, public, made_at, payload, encoded(station.sign(_signed(id_)))))


def fact_of(row: FactRow) -> Fact:
    """A fact from its columns, whose signature is good. Raises `ValueError` if it is nothing that a station records."""
    id_, kind, station, made_at, payload, signature = map(str, row)
    if not is_time(made_at):
        raise ValueError(made_at)
    return Fact(id_, kind, station, made_at, payload, signature, content_of(kind, payload))


def row_digest(row: FactRow) -> str:
    """Digest over all columns, as the server computes it: detects differences, and is not a proof."""
    return hashlib.md5("|".join(map(str, row)).encode("utf-8", "replace"), usedforsecurity=False).hexdigest()


def digests_of(rows: Mapping[str, str]) -> Digests:
    """Of rows by id, from the digests of their columns; differs for each bucket whose content differs."""
    parts: dict[str, list[str]] = {}
    for id_, digest in sorted(rows.items()):
        parts.setdefault(id_[:BUCKET], []).append(digest)
    return {bucket: (len(part), hashlib.md5("".join(part).encode(), usedforsecurity=False).hexdigest())
            for bucket, part in parts.items()}  # fmt: skip


def checked(row: FactRow) -> Fact | RefusedFact:
    """The fact in a row of a server or a file, verified, or why it is none."""
    if len(row) != len(FACT_COLUMNS) or not all(isinstance(value, str) for value in row):
        return _refused(row, marked("cannot be read"))
    id_, kind, station, made_at, payload, signature = map(str, row)
    public, seal = decoded(station, KEY_BYTES), decoded(signature, SIGNATURE_BYTES)
    if not _ID.fullmatch(id_) or not _KIND.fullmatch(kind) or public is None or seal is None:
        return _refused(row, marked("cannot be read"))
    if fact_id(kind, station, made_at, payload) != id_:
        return _refused(row, marked("it was altered"))
    if not is_signature(public, seal, _signed(id_)):
        return _refused(row, marked("its station did not sign it"))
    fact = _readable(row)
    if isinstance(fact, Fact) and fact.kind == FactKind.CHECK.value:
        content = fact.content
        said = {name: content[name] for name in ("verdict", "is_void", "is_simulated")}
        if not is_of_row(content["document"], said, module=fact.module, station=public.hex(), made_at=made_at):
            return _refused(row, marked("its record is another one"))
    return fact


def too_long(id_: str) -> RefusedFact:
    """A row that is not even read."""
    return RefusedFact(clean(id_, longest=ID_LENGTH), "", "", message(marked("too large")))


def stored_fact(row: FactRow, digest: str) -> Fact | RefusedFact:
    """A fact of this computer, verified when it was imported; `digest` is from then."""
    if row_digest(row) != digest:
        return _refused(row, marked("it was altered"))
    return _readable(row)


def _readable(row: FactRow) -> Fact | RefusedFact:
    try:
        return fact_of(row)
    except ValueError:
        return _refused(row, marked("cannot be read"))


def _signed(id_: str) -> bytes:
    return f"{DOMAIN}\n{id_}\n".encode("ascii")


def _refused(row: FactRow, why: str) -> RefusedFact:
    def shown(place: int) -> str:
        return clean(str(row[place]), longest=64) if place < len(row) else ""

    return RefusedFact(shown(0), shown(1), shown(3), message(why))
