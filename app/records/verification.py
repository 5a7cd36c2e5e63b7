"""Verifies a pre-flight record: was it altered, does its verdict follow from it, and who signed it.

Accepts the record (JSON) and the report (PDF), which carries it and is only a view: of a report the record in it is
verified, and the answer says so. Names of stations are what stations say of themselves: to know one is no trust.
"""

from collections.abc import Iterator
from datetime import datetime, timedelta
from enum import Enum
from pathlib import Path
from typing import Final, NamedTuple

from app.preflight.verdict import Verdict
from app.records.record import Document, Record, read_document, record_of
from app.records.report import LARGEST_FILE, document_in, is_report
from app.store.rows import PreflightCheck, Row
from app.store.station import fingerprint_of, is_signature
from app.text.messages import UserError, UserMessage, clean, joined, message
from protocol.translatable import marked

# A check is judged first, and kept at once.
_KEPT_WITHIN: Final = timedelta(hours=1)


class RecordState(Enum):
    """The value is the word in JSON."""

    INTACT = "intact"
    CONTRADICTORY = "contradictory"
    ALTERED = "altered"


class StationNames(NamedTuple):
    """What stations call themselves. `own`: the key of this computer. `introductions`: keys and names, each once. Keys
    are hexadecimal."""

    own: str | None = None
    introductions: tuple[tuple[str, str], ...] = ()

    def of_key(self, key: str) -> list[str]:
        return [name for one, name in self.introductions if one == key]

    def other_keys(self, key: str) -> dict[str, list[str]]:
        """By name of this key, the other keys that call themselves so, too."""
        others: dict[str, list[str]] = {}
        for other, name in self.introductions:
            if other != key and name in self.of_key(key):
                others.setdefault(name, []).append(other)
        return others


class Verification(NamedTuple):
    """`record` is None where an altered document cannot be read as one. `signer`: the key that it names, in
    hexadecimal; it signed only where it is not altered."""

    state: RecordState
    signer: str
    names: StationNames
    record: Record | None = None
    is_report: bool = False

    @property
    def contradictions(self) -> list[UserMessage]:
        record = self.record
        if record is None or self.state is not RecordState.CONTRADICTORY:
            return []
        stated, follows = message(record.verdict.value), message(record.follows.value)
        return [message(marked("stated {stated}, but the checks give {follows}"), stated=stated, follows=follows)]

    @property
    def is_own(self) -> bool:
        return self.signer == self.names.own

    def sentences(self) -> list[UserMessage]:
        """For people: the state, which record it is, and who signed it."""
        record = self.record
        if self.state is RecordState.ALTERED or record is None:
            told = [message(marked("ALTERED: this is not what was signed."))]
        elif self.contradictions:
            told = [message(marked("CONTRADICTS ITSELF: {parts}."), parts=joined(self.contradictions, "; "))]
        else:
            told = [message(marked("INTACT: {verdict}."), verdict=_verdict(record))]
        if record is not None:
            told.append(_introduced(record))
            if record.is_simulated:
                told.append(message(marked("SIMULATED MODULE: no evidence.")))
        if self.is_report:
            told.append(message(marked("Only the record in the report is signed.")))
        if self.state is not RecordState.ALTERED:
            told += self._signer_sentences()
        return told

    def _signer_sentences(self) -> Iterator[UserMessage]:
        fingerprint = shown_key(self.signer)
        names = joined([UserMessage(clean(name, longest=60)) for name in self.names.of_key(self.signer)])
        if self.is_own:
            yield message(marked("Signed by this station ({fingerprint})."), fingerprint=fingerprint)
        elif names.text:
            text = marked("Signed by a station known in the archive as {names} ({fingerprint}).")
            yield message(text, names=names, fingerprint=fingerprint)
        else:
            yield message(marked("Signed by an unknown key ({fingerprint})."), fingerprint=fingerprint)
        for name, keys in self.names.other_keys(self.signer).items():
            text = marked("{name} is also the name of other keys: {fingerprints}.")
            listed = joined([UserMessage(shown_key(key)) for key in keys[:10]])
            yield message(text, name=clean(name, longest=60), fingerprints=listed)


def shown_key(key: str) -> str:
    """80 bits for people to compare: "3F9A-11C0-…"."""
    return fingerprint_of(bytes.fromhex(key))


def _verdict(record: Record) -> UserMessage:
    word = message(record.verdict.value)
    return word if record.void is None else message(marked("{verdict}, void"), verdict=word)


def _introduced(record: Record) -> UserMessage:
    return message(
        marked("{module}: {verdict}, {at}, checked by: {who}. Its checks give {follows}."),
        module=clean(record.module, longest=60) if record.module else message(marked("Unnamed")),
        verdict=_verdict(record),
        at=record.at.isoformat(),
        who=clean(record.who, longest=60) if record.who else message(marked("not named")),
        follows=message(record.follows.value),
    )


def verify_file(path: Path, names: StationNames) -> Verification:
    """Raises `OSError` where the file cannot be read, and `UserError` where it is no record."""
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    return verify_bytes(data, names)


def verify_bytes(data: bytes, names: StationNames) -> Verification:
    """Raises `UserError` where it is no record."""
    verification = verify(read_document(document_in(data)), names)
    return verification._replace(is_report=is_report(data))


def verify(document: Document, names: StationNames) -> Verification:
    """Raises `UserError` where it is intact and of a version that cannot be read here."""
    public, signature = bytes.fromhex(document.station), bytes.fromhex(document.signature)
    if not is_signature(public, signature, document.signed_bytes):
        try:
            record = record_of(document)
        except UserError:
            record = None
        return Verification(RecordState.ALTERED, document.station, names, record)
    record = record_of(document)
    state = RecordState.INTACT if record.verdict is record.follows else RecordState.CONTRADICTORY
    return Verification(state, document.station, names, record)


def is_of_row(check: PreflightCheck, row: Row) -> bool:
    """Whether a fact of a check carries the record that it speaks of: intact, signed by the station of the row, and of
    its module, verdict and time. To be asked once, where a row comes in."""
    try:
        verification = verify(read_document(check.document.encode()), StationNames())
    except (UserError, UnicodeEncodeError):
        return False
    record = verification.record
    if record is None or verification.state is not RecordState.INTACT or verification.signer != row.station:
        return False
    said = (row.module, check.verdict, check.is_void, check.is_simulated)
    found = (record.module, record.verdict.value, record.void is not None, record.is_simulated)
    return said == found and abs(datetime.fromisoformat(row.made_at) - record.at) <= _KEPT_WITHIN


def is_green(verification: Verification) -> bool:
    """Only an intact GO of a real module is shown in green."""
    record = verification.record
    if record is None or verification.state is not RecordState.INTACT:
        return False
    return record.verdict is Verdict.GO and not record.is_simulated
