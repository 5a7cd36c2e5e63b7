"""Verifies a pre-flight record: was it altered, does its verdict follow from it, and who signed it.

Accepts the record (JSON) and the report (PDF), which carries it and is only a view: of a report the record in it is
verified, and the answer says so. Names of stations are what stations say of themselves: to know one is no trust. What
is read may be a stranger's: the work on it grows with its length and no faster.
"""

import zlib
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from enum import Enum
from pathlib import Path
from typing import Final, NamedTuple

from app.preflight.verdict import Verdict
from app.records.record import FORMAT, MAX_DOCUMENT_BYTES, Document, Record, read_document, record_of
from app.store.rows import PreflightCheck, Row
from app.store.station import is_signature, shown_key
from app.text.messages import UserError, UserMessage, clean, joined, message
from protocol.translatable import marked

LARGEST_FILE: Final = 16_000_000
# Of a PDF; ours have a dozen.
_MAX_STREAMS: Final = 200


class RecordState(Enum):
    """The value is the word in JSON."""

    INTACT = "intact"
    CONTRADICTORY = "contradictory"
    ALTERED = "altered"


class StationNames(NamedTuple):
    """The names that stations give themselves. `own` is the key of this computer; `introductions` are keys and names,
    each once. Keys are hexadecimal."""

    own: str | None = None
    introductions: tuple[tuple[str, str], ...] = ()

    def of_key(self, key: str) -> list[str]:
        return [name for one, name in self.introductions if one == key]


class Verification(NamedTuple):
    """Of an altered document `record` is None: nothing that it says is told. `signer`: the key that it names, in
    hexadecimal; it signed only where it is not altered."""

    state: RecordState
    signer: str
    names: StationNames
    record: Record | None = None
    is_report: bool = False

    @property
    def contradictions(self) -> list[UserMessage]:
        if self.record is None or self.state is not RecordState.CONTRADICTORY:
            return []
        stated, follows = message(self.record.verdict.value), message(self.record.follows.value)
        return [message(marked("stated {stated}, but the checks give {follows}"), stated=stated, follows=follows)]

    @property
    def is_own(self) -> bool:
        return self.signer == self.names.own

    @property
    def is_green(self) -> bool:
        """Only an intact GO of a real module is shown in green."""
        record, is_intact = self.record, self.state is RecordState.INTACT
        return is_intact and record is not None and record.verdict is Verdict.GO and not record.is_simulated

    def sentences(self) -> list[UserMessage]:
        """The sentences for people: the state, which record it is, and who signed it."""
        record = self.record
        if record is None:
            return [message(marked("ALTERED: this is not what was signed."))]
        told = [message(marked("INTACT: {verdict}."), verdict=message(record.verdict.value))]
        if self.contradictions:
            told = [message(marked("CONTRADICTS ITSELF: {parts}."), parts=joined(self.contradictions, "; "))]
        about = message(
            marked("{module}, {at}, checked by: {who}."),
            module=clean(record.module, longest=60) if record.module else message(marked("Unnamed")),
            at=record.at.isoformat(),
            who=clean(record.who, longest=60) if record.who else message(marked("not named")),
        )
        told.append(about)
        if record.is_simulated:
            told.append(message(marked("SIMULATED MODULE: no evidence.")))
        if self.is_report:
            told.append(message(marked("Only the record in the report is signed.")))
        own_names = self.names.of_key(self.signer)
        names = joined([UserMessage(clean(name, longest=60)) for name in own_names])
        if self.is_own:
            text = marked("Signed by this station ({fingerprint}).")
        elif own_names:
            text = marked("Signed by a station known in the archive as {names} ({fingerprint}).")
        else:
            text = marked("Signed by an unknown key ({fingerprint}).")
        told.append(message(text, names=names, fingerprint=shown_key(self.signer)))
        for name in dict.fromkeys(own_names):
            others = [key for key, other in self.names.introductions if other == name and key != self.signer]
            if others:
                keys = joined([UserMessage(shown_key(key)) for key in others[:10]])
                text = marked("{name} is also the name of other keys: {fingerprints}.")
                told.append(message(text, name=clean(name, longest=60), fingerprints=keys))
        return told


def verify_file(path: Path, names: StationNames) -> Verification:
    """Verify the record in a file. Raises `OSError` where the file cannot be read, and `UserError` where it is no
    record."""
    with path.open("rb") as file:
        return verify_bytes(file.read(LARGEST_FILE + 1), names)


def verify_bytes(data: bytes, names: StationNames) -> Verification:
    """Verify the record in these bytes. Raises `UserError` where there is none, also for a report that carries several:
    a person could be shown one and a program told another."""
    if len(data) > LARGEST_FILE:
        raise UserError(marked("too large"))
    is_report = data.startswith(b"%PDF-")
    carried = list(_carried_in_pdf(data)) if is_report else [data]
    if len(carried) != 1:
        raise UserError(marked("several records") if carried else marked("unknown kind of file"))
    return verify(read_document(carried[0]), names)._replace(is_report=is_report)


def verify(document: Document, names: StationNames) -> Verification:
    """Verify a document. Raises `UserError` where it is intact and of a version that cannot be read here."""
    if not is_signature(document.station, document.signature, document.signed_bytes):
        return Verification(RecordState.ALTERED, document.station, names)
    record = record_of(document)
    state = RecordState.INTACT if record.verdict is record.follows else RecordState.CONTRADICTORY
    return Verification(state, document.station, names, record)


def is_of_row(check: PreflightCheck, row: Row) -> bool:
    """Whether a fact of a check carries the record that it speaks of: intact, signed by the station of the row, and of
    its module, verdict and time. To be asked once, where a row comes in."""
    try:
        verification = verify(read_document(check.document.encode()), StationNames())
    except UserError:
        return False
    record = verification.record
    if record is None or verification.state is not RecordState.INTACT or verification.signer != row.station:
        return False
    said = (row.module, datetime.fromisoformat(row.made_at), check.verdict, check.is_void, check.is_simulated)
    return said == (record.module, record.at, record.verdict.value, record.void is not None, record.is_simulated)


def _carried_in_pdf(data: bytes) -> Iterator[bytes]:
    """The records that are attached to a PDF. Raises `UserError` for one that has more parts than any report, as
    another record could hide in them."""
    end = 0
    for _ in range(_MAX_STREAMS):
        start = data.find(b"stream", end)
        end = data.find(b"endstream", start + 1)
        if start < 0 or end < 0:
            return
        stream = data[start + len(b"stream") : end].lstrip(b"\r\n")
        end += len(b"endstream")
        packed = b""
        with suppress(zlib.error):  # at most one byte more than a document may have
            packed = zlib.decompressobj().decompress(stream, MAX_DOCUMENT_BYTES + 1)
        for content in (stream, packed):
            if content.lstrip()[:1] == b"{" and FORMAT.encode() in content:
                yield content
                break
    raise UserError(marked("too large"))
