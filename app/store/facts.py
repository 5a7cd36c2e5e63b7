"""Facts: what this station recorded, only ever added, in one chain.

    payload     a JSON object as ASCII text; "previous" in it is the hash of the fact before
    hash        SHA-256 of kind, time and payload
    id, station, signature    as the archive exchanges it (app/archive/facts.py); NULL until it is signed there
    module, link    what it is looked up by: the name of its module; the hash of a record or of an intent, an act
    state       what may change: a value by its key

An intent and its outcome are two facts. The chain has no key: whoever can write the file can recompute it; what was
signed and exchanged is known elsewhere.
"""

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from enum import Enum
from typing import Any, Final, NamedTuple

from app.store.database import Database
from app.text.messages import UserMessage, message
from protocol.translatable import marked


class FactKind(Enum):
    """The kinds that this version knows. Facts of other kinds, from newer versions, are stored and passed on."""

    STATION = "station"
    """A station introduces itself: the key that signs its records, and its name."""
    MODULE = "module"
    """A station named a module, or met it at another adapter."""
    SAID_NEW = "said_new"
    """A person's word that a module is new and has no records, or no longer."""
    TRIGGER_RECORD = "trigger_record"
    JUDGEMENT = "judgement"
    """A person's judgement of a trigger record."""
    VISIT = "visit"
    """One reading of a module's records."""
    SNAPSHOT = "settings_snapshot"
    CHECK = "preflight_check"
    GUIDED_TEST = "guided_test"
    ACT = "act"
    """The intent of an act."""
    BAUD = "baud_change"
    """The intent to change the baud rate, as logged before it was an act like the others."""
    OUTCOME = "outcome"
    """What came of an intent."""
    FIRED = "fired"
    """The module reported TRIGGERED, or got its name after it may have fired without one."""
    AUDIT = "audit_link"
    """An act as versions before layout 10 logged it: its start, or start and outcome."""
    SETTLEMENT = "settlement"
    """A person's decision whether two modules are the same one."""
    SERVICE = "service"
    """What a person did to a module: repacked it, changed a part; and when it is due again."""
    PROVISIONED = "provisioned"
    """A module of a batch: named, or set aside with the reason. Its link is the batch."""
    MIGRATED = "migrated"
    """The facts before it were taken over from a store of another layout."""


FORMER_ENTRY: Final = (
    "id", "module_id", "port", "origin", "at", "act", "frame", "detail", "settled_at", "outcome", "result",
)  # fmt: skip
"""Columns of the former audit log, in the order of the list "entry" of a fact `AUDIT`. `detail` is JSON as text; what
follows it is None in the fact of its start."""


class ChainFault(Enum):
    """The value is English, translatable, with the place for the entry."""

    ALTERED = marked("Entry {entry} was altered.")
    MISSING = marked("Entry {entry} was removed.")
    FOREIGN = marked("Entry {entry} was added from outside.")
    BROKEN = marked("The chain is broken at entry {entry}.")


class AuditFault(NamedTuple):
    """`entry`: the number of a fact, or of an entry of the former audit log."""

    entry: int
    fault: ChainFault

    @property
    def message(self) -> UserMessage:
        return message(self.fault.value, entry=self.entry)


class Kept(NamedTuple):
    """A fact of this station. `at`: ISO 8601 in UTC."""

    number: int
    at: str
    content: Mapping[str, Any]


class Facts:
    """The facts and the state in a database. Every method raises `StoreTrouble`."""

    def __init__(self, database: Database) -> None:
        self.database = database

    def add(
        self, kind: FactKind, content: Mapping[str, object], *, module: str | None = None, link: str | None = None,
        at: str | None = None,
    ) -> int:  # fmt: skip
        """Add a fact to the chain; its number. Durable on return. `at`: else now."""
        with self.database.transaction():
            rows = self.database.read("SELECT hash FROM facts ORDER BY number DESC LIMIT 1")
            made_at = at or self.database.now()
            payload = payload_of({**content, "module": module, "previous": rows[0][0] if rows else ""})
            return self.database.write(ADD_FACT, (kind.value, made_at, payload, module, link,
                                                  fact_hash(kind.value, made_at, payload)))  # fmt: skip

    def end(self, number: int, content: Mapping[str, object]) -> None:
        """Add what came of an intent, once."""
        with self.database.transaction():
            ((hash_, module),) = self.database.read("SELECT hash, module FROM facts WHERE number = ?", (number,))
            if not self.select(FactKind.OUTCOME, "AND link = ?", (hash_,)):
                self.add(FactKind.OUTCOME, {**content, "of": hash_}, module=module, link=hash_)

    def select(
        self, kind: FactKind, rest: str = "ORDER BY number", values: Sequence[object] = (), *, payload: str = "payload"
    ) -> list[Kept]:
        """`rest`: of the SQL statement. What is no JSON object is left out; `dps-s verify --log` names it."""
        query = f"SELECT number, made_at, {payload} FROM facts WHERE kind = ? AND json_valid(payload) {rest}"  # noqa: S608
        rows = self.database.read(query, (kind.value, *values))
        kept = [Kept(number, at, json.loads(text)) for number, at, text in rows]
        return [fact for fact in kept if isinstance(fact.content, dict)]

    def last_visit(self, module: str, known: str = "slots") -> Kept | None:
        """The last reading of a module's records of which this value is known."""
        which = f"AND module = ? AND json_extract(payload, '$.{known}') IS NOT NULL ORDER BY number DESC LIMIT 1"
        return next(iter(self.select(FactKind.VISIT, which, (module,))), None)

    def faults(self) -> list[AuditFault]:
        """What is wrong with the chain of this station, by entry; empty where it is whole."""
        ends = self.database.read("SELECT seq FROM sqlite_sequence WHERE name = 'facts'")
        rows = self.database.read("SELECT number, kind, made_at, payload, hash FROM facts ORDER BY number")
        links = [_Link(number, hash_, fact_hash(*fact) != hash_, fact[0], object_in(fact[2]))
                 for number, *fact, hash_ in rows]  # fmt: skip
        missing = set(range(1, ends[0][0] + 1 if ends else 1)) - {link.number for link in links}
        audit_faults = {AuditFault(number, ChainFault.MISSING) for number in missing} | set(_faults(links, missing))
        return sorted(audit_faults, key=lambda fault: (fault.entry, fault.fault.name))

    def state(self, key: str) -> dict[str, Any] | None:
        rows = self.database.read("SELECT value FROM state WHERE key = ?", (key,))
        return object_in(rows[0][0]) if rows else None

    def set_state(self, key: str, value: Mapping[str, object] | None) -> None:
        """None removes it."""
        if value is None:
            self.database.write("DELETE FROM state WHERE key = ?", (key,))
        else:
            self.database.write(SET_STATE, (key, payload_of(value)))


ADD_FACT: Final = "INSERT INTO facts (kind, made_at, payload, module, link, hash) VALUES (?, ?, ?, ?, ?, ?)"
SET_STATE: Final = "INSERT OR REPLACE INTO state (key, value) VALUES (?, ?)"
"""A row that is replaced is the last one: the order tells what was set last, whatever the clock said."""


class _Link(NamedTuple):
    number: int
    hash: str
    is_altered: bool
    kind: str
    content: Mapping[str, Any]


def _faults(links: Iterable[_Link], missing: Collection[int]) -> Iterator[AuditFault]:
    """Facts that were taken over from a former layout come first; the fact `MIGRATED` has a digest of them all."""
    last, former, is_begun = "", list[str](), False
    for link in links:
        previous, was_begun = link.content.get("previous"), is_begun
        is_begun |= "entry" not in link.content and isinstance(previous, str)
        if link.is_altered:
            yield AuditFault(link.number, ChainFault.ALTERED)
        elif was_begun and not isinstance(previous, str):
            yield AuditFault(link.number, ChainFault.FOREIGN)
        elif is_begun and previous != last and link.number - 1 not in missing:
            yield AuditFault(link.number, ChainFault.BROKEN)
        if link.kind == FactKind.MIGRATED.value:
            if link.content.get("digest") != digest_of(former):
                yield AuditFault(link.number, ChainFault.BROKEN)
            for entry, fault in link.content.get("faults", ()):
                yield AuditFault(entry, ChainFault[fault])
        elif not is_begun:
            former.append(link.hash)
        last = link.hash


def digest_of(hashes: Iterable[str]) -> str:
    return hashlib.sha256("".join(hashes).encode()).hexdigest()


def payload_of(content: Mapping[str, object]) -> str:
    """Raises `ValueError` if it is not JSON."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)


def utc_time(text: str) -> str:
    """A time in UTC with milliseconds, so that times sort as text. Raises `ValueError`."""
    at = datetime.fromisoformat(text)
    return at.replace(tzinfo=at.tzinfo or UTC).astimezone(UTC).isoformat(timespec="milliseconds")


def fact_hash(kind: str, made_at: str, payload: str) -> str:
    return hashlib.sha256(f"{kind}\n{made_at}\n{payload}".encode("utf-8", "surrogatepass")).hexdigest()


def object_in(text: Any) -> dict[str, Any]:
    """The JSON object in a text or in bytes, empty if there is none."""
    try:
        value = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
