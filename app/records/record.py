"""The record of a pre-flight check: what was found, by whom and when, as one signed JSON document.

    {"format": "dps-s pre-flight record", "record": {...}, "station": "<public key>", "signature": "<Ed25519>"}

What is signed is the canonical record. The signature tells which key signed and that nothing was changed since. It does
not tell that a person told the truth.

The standard library reads the document and makes it canonical, because a signature must not hang on a library's way to
write numbers. msgspec says what a record may contain: every text, list and number in it is bounded, as a record may be
a stranger's.
"""

import json
from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

import msgspec
from msgspec import Meta, Struct

from app import version
from app.engine.target import is_simulated
from app.guided.results import GuidedKind, StoredTest
from app.preflight.checks import CheckResult
from app.preflight.reading_object import readings_of
from app.preflight.verdict import Assessment, Verdict, verdict_of
from app.store.rows import Key, Text, Whole, Word
from app.store.station import Station
from app.text.messages import UserError, UserMessage, clean, joined, message
from protocol.translatable import marked

FORMAT = "dps-s pre-flight record"
VERSION = 5
# A fact may have a million.
MAX_DOCUMENT_BYTES = 900_000
# What no check can prove, said on each record.
NOTES = (
    marked("Triggers: enabled in this conversation only. Whether a restart keeps them is not known."),
    marked("This program was never tried on a real module."),
)
# Before the signed bytes, so that the signature of another kind of document never fits.
_SIGNED_FOR = b"dps-s pre-flight record 5\n"

Hex = Annotated[str, Meta(max_length=60, pattern=r"^[0-9A-F ]*$")]
# Of `UserMessage.to_json`, so that it prints in any language years later.
Message = dict[str, Any] | str


class RecordedCheck(Struct, frozen=True, kw_only=True):
    id: Word
    title: Text
    result: CheckResult
    measured: bool | Whole | float | Text | None
    shown: Message
    limit: Message
    why: Text
    do: Message


class RecordedItem(Struct, frozen=True, kw_only=True):
    """A manual item. `is_done` is null where it was skipped."""

    text: Text
    is_done: bool | None
    is_required: bool


class Record(Struct, frozen=True, kw_only=True):
    """`adapter`: its USB identity, else the port."""

    version: Literal[5]
    verdict: Verdict
    void: Word | None
    at: Annotated[datetime, Meta(tz=True)]
    zone: Word
    program: Text
    who: Text
    module: Text | None
    aircraft: Text
    adapter: Text
    is_simulated: bool
    activated_by: Literal["person", "aircraft"]
    profile: Text | None
    settings_code: Word | None
    softer_limits: Annotated[list[Word], Meta(max_length=100)]
    checks: Annotated[list[RecordedCheck], Meta(max_length=100)]
    manual: Annotated[list[RecordedItem], Meta(max_length=200)]
    tests: Annotated[list[StoredTest], Meta(max_length=20)]
    read: dict[str, Any]
    trigger_records: Annotated[list[Hex], Meta(max_length=20)]
    notes: Annotated[list[Text], Meta(max_length=20)]

    @property
    def caveats(self) -> list[UserMessage]:
        """Restrictions that are shown beside the verdict."""
        restrictions = [message(marked("SIMULATED MODULE: no evidence."))] if self.is_simulated else []
        signature = {marked("Checked by"): self.who, marked("Module"): self.module, marked("Aircraft"): self.aircraft}
        missing = [UserMessage(title) for title, entry in signature.items() if not entry]
        if missing and self.verdict is not Verdict.NO_GO:
            restrictions.append(message(marked("UNSIGNED, missing: {missing}."), missing=joined(missing)))
        titles = [UserMessage(check.title) for check in self.checks if check.id in self.softer_limits]
        if titles:
            restrictions.append(message(marked("Looser than advised: {checks}."), checks=joined(titles)))
        return restrictions

    @property
    def cell_voltage_v(self) -> float | None:
        """As it was measured."""
        measured = next((check.measured for check in self.checks if check.id == "cell_voltage"), None)
        return float(measured) if isinstance(measured, int | float) and not isinstance(measured, bool) else None

    @property
    def follows(self) -> Verdict:
        """The verdict that the checks, the manual items and the activation as the module reported it last give."""
        is_fine = self.void is None and bool(self.checks)
        is_fine &= all(check.result in (CheckResult.PASS, CheckResult.WARN) for check in self.checks)
        is_fine &= all(item.is_done or (item.is_done is None and not item.is_required) for item in self.manual)
        status = self.read.get("status")
        active = status.get("active") if isinstance(status, Mapping) else None
        return verdict_of(is_fine=is_fine, is_active=active if isinstance(active, bool) else None)


class SignedRecord(NamedTuple):
    """`text`: the document as it is stored, sent and attached to the report. `station`: the key that signed it."""

    record: Record
    station: str
    text: str


class Document(Struct, frozen=True, kw_only=True):
    """A record as it came: fields of a newer version stay under the signature. Keys and signatures are hexadecimal."""

    format: Literal["dps-s pre-flight record"]
    record: dict[str, Any]
    station: Key
    signature: Annotated[str, Meta(pattern="^[0-9a-f]{128}$")]

    @property
    def signed_bytes(self) -> bytes:
        return _SIGNED_FOR + canonical(self.record)


class SignedDocument(Document, frozen=True, kw_only=True):
    """The same with all that this version knows of a record, for its schema."""

    record: Record  # type: ignore[assignment]


def make_record(assessment: Assessment, *, at: datetime, adapter: str = "") -> Record:
    """The record of a check. `adapter`: USB identity or port. Raises `ValueError` for a time without its zone."""
    case, evidence, person = assessment.case, assessment.case.evidence, assessment.case.person
    plain = {
        "version": VERSION,
        "verdict": assessment.verdict.value,
        "void": None if evidence.void is None else evidence.void.word,
        "at": at.isoformat(timespec="microseconds"),
        "zone": clean(at.tzname() or "", longest=60),
        "program": f"DPS-S Configurator {version()}",
        "who": clean(person.who.strip()),
        "module": None if person.module is None else clean(person.module),
        "aircraft": clean(person.aircraft.strip()),
        "adapter": clean(adapter),
        "is_simulated": is_simulated(evidence.port),
        "activated_by": case.profile.activated_by.value,
        "profile": clean(case.profile.name) or None,
        "settings_code": case.settings_code,
        "softer_limits": list(assessment.softened),
        "checks": [
            {
                "id": judged.check.id,
                "title": judged.check.title,
                "result": judged.finding.result.value,
                "measured": judged.finding.measured,
                "shown": judged.finding.shown.to_json(),
                "limit": judged.finding.limit.to_json(),
                "why": judged.check.why,
                "do": judged.do.to_json(),
            }
            for judged in assessment.checks
        ],
        "manual": [
            {"text": clean(item.text), "is_done": item.is_done, "is_required": item.is_required}
            for item in case.profile.manual
        ],
        "tests": [msgspec.to_builtins(case.past.tests[kind].stored) for kind in GuidedKind if kind in case.past.tests],
        "read": msgspec.to_builtins(readings_of(evidence)),
        "trigger_records": [kept.raw.hex(" ").upper() for kept in evidence.history.records] if evidence.history else [],
        "notes": list(NOTES),
    }
    # msgspec does not check what is constructed, so that it is converted: what could not be read again is our fault.
    return msgspec.convert(json.loads(canonical(plain)), Record)


def sign(record: Record, station: Station) -> SignedRecord:
    content = msgspec.to_builtins(record)
    signature = station.private.sign(_SIGNED_FOR + canonical(content)).hex()
    document = {"format": FORMAT, "record": content, "station": station.key, "signature": signature}
    return SignedRecord(record, station.key, canonical(document).decode())


def canonical(value: object) -> bytes:
    """Equal content has equal bytes. Raises `ValueError` for what is no JSON, such as NaN."""
    text = json.dumps(value, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.encode()


# What may be a stranger's


def read_document(data: bytes) -> Document:
    """Read a document. Raises `UserError` for what is no record."""

    def only_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        # Of a doubled field one program would read the first, and another the last.
        fields = dict(pairs)
        if len(fields) != len(pairs):
            raise ValueError("a field stands twice")
        return fields

    def refuse(name: str) -> NoReturn:
        raise ValueError(name)

    if len(data) > MAX_DOCUMENT_BYTES:
        raise UserError(marked("too large"))
    try:
        plain = json.loads(data, object_pairs_hook=only_once, parse_constant=refuse)
        document = msgspec.convert(plain, Document)
        canonical(document.record)
    except msgspec.ValidationError:
        raise UserError(marked("unknown kind of file")) from None
    except (ValueError, RecursionError):
        raise UserError(marked("damaged")) from None
    return document


def record_of(document: Document) -> Record:
    """Return the record of a document. Raises `UserError` for what this version cannot read."""
    try:
        return msgspec.convert(document.record, Record)
    except (msgspec.ValidationError, RecursionError):
        raise UserError(marked("written by another version")) from None
