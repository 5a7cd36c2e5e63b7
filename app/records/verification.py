"""Verifies a pre-flight record: alteration, signature, chain, consistency.

Accepts the JSON file, the HTML page (which contains the record) and the PDF (which has it attached). A page is trusted
only where it equals what this program prints of the record, or where a known station signed it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final, Protocol

from app import version
from app.records.consistency import contradictions
from app.records.page_seal import SIGNATURE_BYTES, is_page, page_seal_in
from app.records.record import (
    NOT_STORED,
    READABLE_VERSIONS,
    Record,
    canonical,
    digest,
    digests_of,
    signed_bytes,
)
from app.records.record_files import LARGEST_FILE, NoRecord, record_in
from app.records.report_html import is_page_of
from app.stations.known import KnownStation
from app.stations.station import KEY_BYTES, decoded, fingerprint_of, is_signature
from app.text.messages import UserMessage, clean, joined, message
from protocol.translatable import marked

FindStation = Callable[[bytes], KnownStation | None]
"""Finds a station by public key; None where it is not known here."""


class StoredRecords(Protocol):
    """Finds records that are stored on this computer."""

    def record(self, hash_: str) -> Record | None: ...

    def same_number(self, record: Mapping[str, object]) -> str | None:
        """Hash of another record with the same number in the same chain."""


class RecordState(Enum):
    """The most severe finding."""

    INTACT = "intact"
    """Unaltered, consistent, and signed by a known station."""
    NOT_SIGNED = "not signed"
    UNKNOWN_STATION = "unknown station"
    PAGE_NOT_SIGNED = "page not signed"
    PAGE_OF_UNKNOWN_STATION = "page of unknown station"
    CHAIN_BROKEN = "chain broken"
    CONTRADICTORY = "contradictory"
    ALTERED = "altered"
    UNREADABLE = "unreadable"


class Chain(Enum):
    """Position in the chain of records; the value is English, marked."""

    FIRST = marked("first record of this module")
    LINKED = marked("previous record intact")
    NOT_AT_HAND = marked("previous record not on this computer")
    ALONE = marked("none")
    BROKEN = marked("previous record altered or replaced")
    DOUBLED = marked("another record here has the same number")


_HEADLINES: Final[Mapping[RecordState, str]] = {
    RecordState.INTACT: marked("INTACT: signed by {station}."),
    RecordState.NOT_SIGNED: marked("NOT SIGNED: anyone can make such a record."),
    RecordState.UNKNOWN_STATION: marked("UNKNOWN STATION: signed, but not by a known station."),
    RecordState.PAGE_NOT_SIGNED: marked("PAGE NOT SIGNED: only the record in it is intact."),
    RecordState.PAGE_OF_UNKNOWN_STATION: marked(
        "PAGE OF UNKNOWN STATION: signed by {fingerprint}; only the record in it is intact."
    ),
    RecordState.CHAIN_BROKEN: marked("CHAIN BROKEN: {chain}."),
    RecordState.CONTRADICTORY: marked("CONTRADICTS ITSELF: {parts}."),
    RecordState.ALTERED: marked("ALTERED: {parts}."),
    RecordState.UNREADABLE: marked("No pre-flight record: {why}."),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Result. `altered`: parts that differ from what was recorded ("checks.cell_voltage", "signature", "page" …)."""

    state: RecordState
    record: Mapping[str, object] | None = None
    altered: tuple[str, ...] = ()
    contradictions: tuple[UserMessage, ...] = ()
    chain: Chain | None = None
    is_known_here: bool = False
    """The same record is in this computer's store."""
    signer: bytes | None = None
    """The public key whose signature of the record is valid."""
    station: KnownStation | None = None
    """The station of that key, where it is known here."""
    page_signer: bytes = b""
    """The public key of an unknown station whose signature of a page of other wording is valid."""
    why: UserMessage | None = None

    @property
    def signer_to_trust(self) -> bytes | None:
        """The public key that a person may trust so that the file counts as signed by a known station."""
        return self.page_signer if self.state is RecordState.PAGE_OF_UNKNOWN_STATION else self.signer

    def sentences(self) -> tuple[UserMessage, ...]:
        """For people: the state, then which record it is, who signed it, its chain, and whether it is stored here."""
        chain = UserMessage("" if self.chain is None else self.chain.value)
        parts, why = self._parts(), self.why or UserMessage("")
        first = message(
            _HEADLINES[self.state], station=self._station(), chain=chain, parts=parts, why=why,
            fingerprint=fingerprint_of(self.page_signer),
        )  # fmt: skip
        if self.record is None:
            return (first,)
        rest = [_introduced(self.record)]
        if self.record.get("is_simulated") is True:
            rest.append(message(marked("SIMULATED MODULE: no evidence.")))
        if "signature" in self.altered:
            rest.append(message(marked("Station: invalid signature.")))
        elif self.signer is None:
            rest.append(message(marked("Station: none, not signed.")))
        else:
            station = self._station() if self.station is not None else message(marked("unknown"))
            text = marked("Station: {fingerprint}, {station}.")
            rest.append(message(text, fingerprint=fingerprint_of(self.signer), station=station))
        if self.state is not RecordState.CHAIN_BROKEN:
            rest.append(message(marked("Chain: {what}."), what=chain))
        kept = marked("Kept on this computer.")
        rest.append(message(kept if self.is_known_here else marked("Not kept.")))
        return (first, *rest)

    def _station(self) -> UserMessage:
        if self.station is None:
            return UserMessage("")
        return message(marked("this computer")) if self.station.is_own else UserMessage(self.station.name)

    def _parts(self) -> UserMessage:
        if self.state is RecordState.CONTRADICTORY:
            return joined(self.contradictions, "; ")
        return UserMessage(", ".join(self.altered))


def _introduced(record: Mapping[str, object]) -> UserMessage:
    """Which record it is. Values of the file are untrusted: cleaned and cut."""
    module, who, verdict = record.get("module"), record.get("who"), _shown(record.get("verdict"))
    return message(
        marked("Record {number} of {module}: {verdict}, {at}, checked by {who}."),
        number=_shown(record.get("number")),
        module=_shown(module) if module else message(marked("a module without a name")),
        verdict=verdict if record.get("void") is None else message(marked("{verdict} (void)"), verdict=verdict),
        at=_shown(record.get("at")),
        who=_shown(who) if who else message(marked("not named")),
    )


def _shown(value: object) -> str:
    return clean(str(value), longest=60)


def verify_file(
    path: Path, kept: StoredRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    """Raises `OSError` where the file cannot be read."""
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    return verify_bytes(data, kept, find_station)


def verify_bytes(
    data: bytes, kept: StoredRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    """`kept`: the store of this computer. `find_station`: the stations that are trusted."""
    try:
        record = record_in(data)
        if record.get("version") not in READABLE_VERSIONS:
            return _unreadable(marked("written by a newer version"))
        return _verified(data, record, kept, find_station)
    except NoRecord as error:
        return Verification(state=RecordState.UNREADABLE, why=error.why)
    except (ValueError, RecursionError):
        return _unreadable(marked("unknown kind of file"))


def verify(
    record: Mapping[str, object], kept: StoredRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    """Verifies a bare record."""
    try:
        data = canonical(record)
    except (ValueError, TypeError, RecursionError):
        return _unreadable(marked("unknown kind of file"))
    return verify_bytes(data, kept, find_station)


def _unreadable(why: str) -> Verification:
    return Verification(state=RecordState.UNREADABLE, why=message(why))


def _verified(data: bytes, record: Record, kept: StoredRecords | None, find_station: FindStation) -> Verification:
    same = kept.record(str(record.get("hash"))) if kept is not None else None
    altered = list(_altered(record, same))
    signer = _signer(record)
    is_known_here = same is not None and not altered
    if signer is None and (record.get("station") is not None or "signature" in record):
        altered.append("signature")
    page_state, page_signer = RecordState.INTACT, b""
    if is_page(data):
        seal = page_seal_in(data, record)
        if seal is None or not seal.is_whole:
            altered.append("page" if seal is not None else "page seal")
        elif (seal.signer is None or find_station(seal.signer) is None) and not is_page_of(record, seal.page):
            page_signer = seal.signer or b""
            page_state = RecordState.PAGE_OF_UNKNOWN_STATION if seal.signer else RecordState.PAGE_NOT_SIGNED
            if _is_of_this_version(record) and not data.startswith(b"%PDF-"):
                altered.append("page")
    chain, against = _chain(record, kept), contradictions(record)
    station = find_station(signer) if signer is not None else None
    return Verification(
        state=_state(altered, against, chain, signer, station=station, page_state=page_state),
        record=record, altered=tuple(altered), contradictions=against, chain=chain,
        is_known_here=is_known_here, signer=signer, station=station, page_signer=page_signer,
    )  # fmt: skip


def _state(
    altered: list[str], against: tuple[UserMessage, ...], chain: Chain, signer: bytes | None, *,
    station: KnownStation | None, page_state: RecordState,
) -> RecordState:  # fmt: skip
    if altered:
        return RecordState.ALTERED
    if against:
        return RecordState.CONTRADICTORY
    if chain in (Chain.BROKEN, Chain.DOUBLED):
        return RecordState.CHAIN_BROKEN
    if signer is None:
        return RecordState.NOT_SIGNED
    if station is None:
        return RecordState.UNKNOWN_STATION
    return page_state


def _is_of_this_version(record: Mapping[str, object]) -> bool:
    """Whether this version of the program made the record; its page must then be what this version prints."""
    program = record.get("program")
    return isinstance(program, Mapping) and program.get("version") == version()


def _signer(record: Mapping[str, object]) -> bytes | None:
    """The key that signed it; None without a valid signature."""
    public = decoded(record.get("station"), KEY_BYTES)
    signature = decoded(record.get("signature"), SIGNATURE_BYTES)
    if public is None or signature is None or not is_signature(public, signature, signed_bytes(record.get("hash"))):
        return None
    return public


def _altered(record: Mapping[str, object], same: Mapping[str, object] | None) -> tuple[str, ...]:
    """Names of the altered parts. `same`: the stored record of the same hash."""
    now, then = digests_of(record), record.get("digests")
    if not isinstance(then, Mapping):
        return ("digests",)
    names = [*now, *(name for name in then if name not in now)]
    altered = [clean(str(name), longest=80) for name in names if now.get(name) != then.get(name)]
    if record.get("hash") != digest(then):
        altered.append("hash")
    if not altered and same is not None and canonical(same) != canonical(record):
        altered.append("digests")
    return tuple(altered)


def _chain(record: Mapping[str, object], kept: StoredRecords | None) -> Chain:
    previous, number = record.get("previous"), record.get("number")
    if type(number) is not int or number < 0:
        return Chain.BROKEN
    if previous is None and number == NOT_STORED:
        return Chain.ALONE
    if kept is not None and kept.same_number(record) is not None:
        return Chain.DOUBLED
    if previous is None:
        return Chain.FIRST if number == 1 else Chain.BROKEN
    before = kept.record(str(previous)) if kept is not None else None
    if before is None:
        return Chain.NOT_AT_HAND
    last = before.get("number")
    follows = isinstance(last, int) and number == last + 1
    is_same_chain = chain_name(before) == chain_name(record)
    return Chain.LINKED if follows and is_same_chain and not _altered(before, None) else Chain.BROKEN


def chain_name(record: Mapping[str, object]) -> tuple[object, object]:
    """Identifies a chain: by module, or by adapter for modules without a name."""
    module = record.get("module")
    return module, record.get("adapter") if module is None else None
