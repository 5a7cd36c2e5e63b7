"""Verifies a pre-flight record: who signed it, whether it was altered, its chain, and that its verdict follows from it.

Accepts the record (JSON) and the report (PDF), which carries it and is only a view: of a report the record in it is
verified, and what that says is part of the answer. So also of the HTML pages that older versions wrote.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Final

from app.preflight.findings import CheckResult
from app.preflight.verdict import Verdict, verdict_of
from app.records.check_store import KeptRecords, noted
from app.records.record import FORMAT, NOT_STORED, READABLE_VERSIONS, hash_of, list_in, signed_bytes
from app.records.report_files import LARGEST_FILE, is_report, record_in
from app.stations.known import KnownStation
from app.stations.station import KEY_BYTES, SIGNATURE_BYTES, decoded, fingerprint_of, is_signature
from app.text.messages import UserMessage, clean, joined, message
from app.text.user_error import UserError
from protocol.translatable import marked

FindStation = Callable[[bytes], KnownStation | None]
"""Finds a station by public key; None where it is not known here."""


class RecordState(Enum):
    """The most severe finding."""

    INTACT = "intact"
    """Unaltered, consistent, and signed by a known station."""
    NOT_SIGNED = "not signed"
    UNKNOWN_STATION = "unknown station"
    REVOKED_STATION = "revoked station"
    CHAIN_BROKEN = "chain broken"
    CONTRADICTORY = "contradictory"
    ALTERED = "altered"
    UNREADABLE = "unreadable"

    @property
    def is_false(self) -> bool:
        """It does not say what was found, whoever signed it."""
        return self in (
            RecordState.CHAIN_BROKEN, RecordState.CONTRADICTORY, RecordState.ALTERED, RecordState.UNREADABLE,
        )  # fmt: skip


class Chain(Enum):
    """Position in the chain of records; the value is English, marked."""

    FIRST = marked("first record of this module")
    LINKED = marked("previous record intact")
    NOT_AT_HAND = marked("previous record not on this computer")
    ALONE = marked("none")
    BROKEN = marked("previous record altered or replaced")
    DOUBLED = marked("another record here has the same number")


_HEADLINES: Final[Mapping[RecordState, str]] = {
    RecordState.INTACT: marked("INTACT: {verdict}, signed by {station}."),
    RecordState.NOT_SIGNED: marked("NOT SIGNED: anyone can make such a record."),
    RecordState.UNKNOWN_STATION: marked("UNKNOWN STATION: signed, but not by a known station."),
    RecordState.REVOKED_STATION: marked("REVOKED STATION: signed by {station}, whose key is no longer trusted."),
    RecordState.CHAIN_BROKEN: marked("CHAIN BROKEN: {chain}."),
    RecordState.CONTRADICTORY: marked("CONTRADICTS ITSELF: {parts}."),
    RecordState.ALTERED: marked("ALTERED: {parts}."),
    RecordState.UNREADABLE: marked("No pre-flight record: {why}."),
}
CONTENT: Final = marked("the content is not what was recorded")
SIGNATURE: Final = marked("the signature is not that of its station")


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Result. `altered`: `CONTENT`, `SIGNATURE`, both, or neither."""

    state: RecordState
    record: Mapping[str, object] | None = None
    altered: tuple[str, ...] = ()
    contradictions: tuple[UserMessage, ...] = ()
    chain: Chain | None = None
    is_known_here: bool = False
    """The same record is in this computer's store."""
    is_report: bool = False
    """The record is part of a report, which may show something else."""
    signer: bytes | None = None
    """The public key whose signature of the record is valid."""
    station: KnownStation | None = None
    """The station of that key, where it is known here."""
    why: UserMessage | None = None

    def sentences(self) -> tuple[UserMessage, ...]:
        """For people: the state, then which record it is, who signed it, its chain, and whether it is stored here."""
        chain = UserMessage("" if self.chain is None else self.chain.value)
        parts = self.contradictions if self.state is RecordState.CONTRADICTORY else tuple(map(message, self.altered))
        first = message(
            _HEADLINES[self.state], station=self._station(), chain=chain, parts=joined(parts, "; "),
            why=self.why or UserMessage(""), verdict=UserMessage(_shown((self.record or {}).get("verdict"))),
        )  # fmt: skip
        if self.record is None:
            return (first,)
        rest = [_introduced(self.record)]
        if self.record.get("is_simulated") is True:
            rest.append(message(marked("SIMULATED MODULE: no evidence.")))
        if self.is_report:
            rest.append(message(marked("Only the record in the report is signed.")))
        if self.signer is None:
            if self.state is not RecordState.NOT_SIGNED and SIGNATURE not in self.altered:
                rest.append(message(_HEADLINES[RecordState.NOT_SIGNED]))
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


def _introduced(record: Mapping[str, object]) -> UserMessage:
    """Which record it is. Values of the file are untrusted: cleaned and cut."""
    module, who, verdict = record.get("module"), record.get("who"), UserMessage(_shown(record.get("verdict")))
    return message(
        marked("Record {number} of {module}: {verdict}, {at}, checked by: {who}. Its checks give {follows}."),
        number=_shown(record.get("number")),
        module=_shown(module) if module else message(marked("Unnamed")),
        verdict=verdict if record.get("void") is None else noted(verdict, marked("void")),
        at=_shown(record.get("at")),
        who=_shown(who) if who else message(marked("not named")),
        follows=UserMessage(verdict_from(record).value),
    )


def _shown(value: object) -> str:
    return clean(str(value), longest=60)


def verify_file(
    path: Path, kept: KeptRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    """Raises `OSError` where the file cannot be read."""
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    return verify_bytes(data, kept, find_station)


def verify_bytes(
    data: bytes, kept: KeptRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    try:
        record = record_in(data)
    except UserError as error:
        return Verification(state=RecordState.UNREADABLE, why=error.message)
    return replace(verify(record, kept, find_station), is_report=is_report(data))


def verify(
    record: Mapping[str, object], kept: KeptRecords | None = None, find_station: FindStation = lambda _public: None
) -> Verification:
    """`kept`: what is on this computer. `find_station`: the stations that are known."""
    try:
        if record.get("format") == FORMAT:
            if record.get("version") not in READABLE_VERSIONS:
                return _unreadable(marked("written by a newer version"))
            return _verified(record, kept, find_station)
    except (ValueError, TypeError, RecursionError):
        pass
    return _unreadable(marked("unknown kind of file"))


def _unreadable(why: str) -> Verification:
    return Verification(state=RecordState.UNREADABLE, why=message(why))


def _verified(record: Mapping[str, object], kept: KeptRecords | None, find_station: FindStation) -> Verification:
    signer = _signer(record)
    is_claimed = record.get("station") is not None or "signature" in record
    altered = [CONTENT] if record.get("hash") != hash_of(record) else []
    if signer is None and is_claimed:
        altered.append(SIGNATURE)
    chain, against = _chain(record, kept), tuple(contradictions(record))
    station = find_station(signer) if signer is not None else None
    if altered:
        state = RecordState.ALTERED
    elif against:
        state = RecordState.CONTRADICTORY
    elif chain in (Chain.BROKEN, Chain.DOUBLED):
        state = RecordState.CHAIN_BROKEN
    elif signer is None:
        state = RecordState.NOT_SIGNED
    elif station is None:
        state = RecordState.UNKNOWN_STATION
    else:
        state = RecordState.REVOKED_STATION if station.is_revoked else RecordState.INTACT
    is_known_here = not altered and kept is not None and kept.record(str(record.get("hash"))) is not None
    return Verification(
        state=state, record=record, altered=tuple(altered), contradictions=against, chain=chain,
        is_known_here=is_known_here, signer=signer, station=station,
    )  # fmt: skip


def _signer(record: Mapping[str, object]) -> bytes | None:
    """The key that signed it; None without a valid signature."""
    public = decoded(record.get("station"), KEY_BYTES)
    signature = decoded(record.get("signature"), SIGNATURE_BYTES)
    if public is None or signature is None or not is_signature(public, signature, signed_bytes(record.get("hash"))):
        return None
    return public


def _chain(record: Mapping[str, object], kept: KeptRecords | None) -> Chain:
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
    return Chain.LINKED if follows and is_same_chain and hash_of(before) == previous else Chain.BROKEN


def chain_name(record: Mapping[str, object]) -> tuple[object, object]:
    """Identifies a chain: by module, or by adapter for modules without a name."""
    module = record.get("module")
    return module, record.get("adapter") if module is None else None


REQUIRED = frozenset({
    "undisturbed", "link_loss", "round_trip", "status", "triggered", "activation", "tilt", "tilt_spread",
    "acceleration", "acceleration_spread", "cell_voltage", "charging", "light", "attitude_threshold",
    "freefall_acceleration", "freefall_time", "light_threshold", "attitude_trigger", "freefall_trigger",
    "trigger_records", "boot_count", "fingerprint",
})  # fmt: skip
"""Checks that every version of a record contains."""
_READ_AS = {
    "activation": ("status", "active"),
    "boot_count": ("boot_count",),
    "attitude_threshold": ("settings", "attitude_threshold_deg"),
    "freefall_acceleration": ("settings", "freefall_acceleration_g"),
    "freefall_time": ("settings", "freefall_time_s"),
    "light_threshold": ("settings", "light_threshold_v"),
}
"""Checks whose measured value is also among the readings, and where."""


def contradictions(record: Mapping[str, object]) -> Iterator[UserMessage]:
    """The parts of a record that contradict each other; never raises, whatever the record contains."""
    checks = [check for check in list_in(record, "checks") if isinstance(check, Mapping)]
    counts = Counter(str(check.get("id")) for check in checks)
    missing = sorted(REQUIRED - counts.keys())
    if missing:
        yield message(marked("missing checks: {checks}"), checks=", ".join(missing))
    doubled = [clean(name, longest=40) for name, count in counts.items() if count > 1]
    if doubled:
        yield message(marked("duplicate checks: {checks}"), checks=", ".join(doubled[:5]))
    stated, follows = record.get("verdict"), verdict_from(record)
    if stated != follows.value:
        words = UserMessage(clean(str(stated), longest=20)), UserMessage(follows.value)
        yield message(marked("stated {stated}, but the checks give {follows}"), stated=words[0], follows=words[1])
    for check in checks:
        where = _READ_AS.get(str(check.get("id")))
        read = _at(record.get("read"), where) if where is not None else None
        measured = check.get("measured")
        if (
            read is not None
            and measured is not None
            and read != measured
            and check.get("result") == CheckResult.PASS.value
        ):
            title = UserMessage(clean(str(check.get("title"))))
            yield message(marked("{check}: judged {measured}, read {read}"), check=title,
                       measured=clean(str(measured), longest=20), read=clean(str(read), longest=20))  # fmt: skip


def verdict_from(record: Mapping[str, object]) -> Verdict:
    """The verdict that follows from the checks, the manual items and the state that the module reported."""
    checks = list_in(record, "checks")
    is_fine = record.get("void") is None and bool(checks) and all(_is_fine(check) for check in checks)
    is_fine = is_fine and all(_is_manual_fine(item) for item in list_in(record, "manual"))
    if record.get("version") == 1:  # a locked module could be GO
        return Verdict.GO if is_fine else Verdict.NO_GO
    active = _at(record.get("read"), ("status", "active"))
    return verdict_of(is_fine=is_fine, is_active=active if isinstance(active, bool) else None)


def _is_fine(check: object) -> bool:
    return isinstance(check, Mapping) and check.get("result") in (CheckResult.PASS.value, CheckResult.WARN.value)


def _is_manual_fine(item: object) -> bool:
    if not isinstance(item, Mapping):
        return False
    return item.get("is_done") is True or (item.get("is_done") is None and item.get("is_required") is False)


def _at(value: object, path: tuple[str, ...]) -> object:
    for name in path:
        value = value.get(name) if isinstance(value, Mapping) else None
    return value
