"""Trigger records and pre-flight checks in the store. Every method raises `StoreTrouble`."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec

from app.engine.target import is_simulated
from app.limits.past import LastAnswer, Past
from app.preflight.verdict import Verdict, verdict_named
from app.records.record import Record, SignedRecord
from app.store.database import Database
from app.store.facts import FactKind, Facts, Kept, utc_time
from app.store.fired import Fired, all_fired, has_fired_since
from app.store.kinds import KINDS, PreflightCheck
from app.text.messages import UserMessage, clean, message
from app.trigger_records.history import Judgement, merge
from protocol.catalogue import MAX_RECORDS
from protocol.translatable import marked

MAX_NOTE_LENGTH = 2000
_RECENT = 100
"""Number of checks that the list of aircraft is made from."""
_LISTED = 200
MEASURED = {
    "cell_voltage": "cell_voltage_v",
    "light": "light_v",
    "tilt": "tilt_deg",
    "tilt_spread": "tilt_spread_deg",
    "acceleration": "acceleration_g",
    "acceleration_spread": "acceleration_spread_g",
    "round_trip": "round_trip_ms",
    "link_loss": "heartbeats_lost",
    "boot_count": "boot_count",
}
"""Checks whose measured value is kept over time, with the name of the value."""


def noted(word: UserMessage, note: str) -> UserMessage:
    """A word with what limits it: English, marked."""
    return message(marked("{tip} ({key})"), tip=word, key=message(note))


class SeenRecord(NamedTuple):
    """A stored trigger record of a module. `place` counts from 0, the oldest."""

    id: int
    place: int
    raw: bytes
    first_seen_at: str
    judgement: Judgement | None
    note: str


class Visit(NamedTuple):
    """One reading of a module's records. `new`: ids of the records added by it; None for the first visit."""

    records: tuple[SeenRecord, ...]
    new: frozenset[int] | None


class CheckLine(NamedTuple):
    """One check as it is listed. `id`: of its fact, for `CheckStore.document`; `at`: ISO 8601 in UTC; `code`: of the
    settings; `station`: who made it, "" here."""

    id: int
    at: str
    module: str | None
    verdict: str
    is_void: bool
    is_simulated: bool
    who: str
    aircraft: str
    code: str | None
    measured: Mapping[str, float]
    station: str = ""
    is_fired_since: bool = False
    """A deploy left or a TRIGGERED was seen after it: what it said of the module is no longer so."""

    def after(self, fired: Iterable[Fired]) -> "CheckLine":
        """What is left of it after its module may have fired."""
        return self._replace(is_fired_since=has_fired_since(self.at, fired, simulated=self.is_simulated))

    @property
    def words(self) -> UserMessage:
        """Its verdict and what limits it."""
        word = message(verdict_named(self.verdict).value)
        if self.is_simulated:
            return noted(word, marked("simulated"))
        if self.is_fired_since:
            return noted(word, marked("void: fired since"))
        return noted(word, marked("void")) if self.is_void else word

    @property
    def has_passed(self) -> bool:
        """When it was made; its settings stay approved."""
        return not self.is_void and self.verdict in (Verdict.GO.value, Verdict.READY.value)

    @property
    def holds(self) -> bool:
        return self.has_passed and not self.is_fired_since


class CheckStore:
    """Repository of visits, trigger records and checks. `module`: its name; None for modules without one."""

    def __init__(self, database: Database) -> None:
        self._facts = Facts(database)

    # Triggers

    def store_visit(self, module: str | None, slots: Sequence[bytes], *, port: str, boot_count: int | None,
              is_confirmed: bool) -> Visit:  # fmt: skip
        """Stores what a module holds now. Without a name the slots are stored as they came."""
        with self._facts.database.transaction():
            last, last_slots, known = self._last(module)
            merged = merge([record.raw for record in known], last_slots, slots, boot_count=boot_count,
                           is_confirmed=is_confirmed)  # fmt: skip
            if module is not None:
                for place, raw in enumerate(merged.new, len(known)):
                    self._facts.add(FactKind.TRIGGER_RECORD, {"place": place, "raw": raw.hex()}, module=module)
            # An incomplete reading adds to what was kept before.
            kept = slots if is_confirmed else [*last_slots, *merged.new][-MAX_RECORDS:]
            content = {
                "port": clean(port), "boot_count": boot_count, "slots": [raw.hex() for raw in kept],
                "is_confirmed": is_confirmed, "known": len(known) + len(merged.new) if module is not None else 0,
            }  # fmt: skip
            self._facts.add(FactKind.VISIT, content, module=module)
            records = self.records(module)
            new = None if last is None else frozenset(record.id for record in records[len(known) :])
            return Visit(records, new)

    def is_kept_apart(self, module: str, port: str) -> bool:
        """Whether what was kept of this name is of a simulated module, and `port` leads to a real one, or reversely."""
        last = self._last_visit(module)
        return last is not None and is_simulated(str(last.content.get("port"))) is not is_simulated(port)

    def records(self, module: str | None) -> tuple[SeenRecord, ...]:
        """Every stored record of this module, the oldest first."""
        if module is None:
            return ()
        judged = {fact.content["place"]: fact.content for fact in self._about(FactKind.JUDGEMENT, module)}
        # A later fact about a place counts: a visit that was broken off was written again.
        facts = {fact.content["place"]: fact for fact in self._about(FactKind.TRIGGER_RECORD, module)}
        return tuple(_seen(facts[place], judged.get(place, {})) for place in sorted(facts))

    def judge(self, record_id: int, judgement: Judgement | None, note: str) -> None:
        """Stores a person's judgement of a record; None removes it."""
        value = None if judgement is None else judgement.value
        for record in self._readable(FactKind.TRIGGER_RECORD, "AND number = ?", (record_id,)):
            content = {"place": record.content["place"], "raw": record.content["raw"], "judgement": value,
                       "note": clean(note, longest=MAX_NOTE_LENGTH)}  # fmt: skip
            self._facts.add(FactKind.JUDGEMENT, content, module=record.content["module"])

    def mark_reviewed(self, module: str, raws: Iterable[bytes]) -> None:
        """Stores a person's word that these records are known, for those without a judgement."""
        known = frozenset(raws)
        for record in self.records(module):
            if record.judgement is None and record.raw in known:
                self.judge(record.id, Judgement.REVIEWED, record.note)

    def _about(self, kind: FactKind, module: str) -> list[Kept]:
        return self._readable(kind, "AND module = ? ORDER BY number", (module,))

    def _readable(self, kind: FactKind, which: str, values: Sequence[object]) -> list[Kept]:
        """Without those that this version cannot read, or that were altered."""
        return [fact for fact in self._facts.select(kind, which, values) if is_readable(kind, fact.content)]

    def _last_visit(self, module: str, *, has_boot_count: bool = False) -> Kept | None:
        which = "AND json_extract(payload, '$.boot_count') IS NOT NULL" if has_boot_count else ""
        visits = self._readable(FactKind.VISIT, f"AND module = ? {which} ORDER BY number DESC LIMIT 5", (module,))
        return next(iter(visits), None)

    def _last(self, module: str | None) -> tuple[Kept | None, list[bytes], tuple[SeenRecord, ...]]:
        """The last visit, what the module held then, and the records that were known at its end: those beyond are of
        a visit that was broken off."""
        visit = self._last_visit(module) if module is not None else None
        if visit is None:
            return None, [], ()
        slots = [bytes.fromhex(slot) for slot in visit.content["slots"]]
        return visit, slots, self.records(module)[: visit.content["known"]]

    # A module that does not answer the query for its records (E7)

    def last_answer(self, module: str) -> LastAnswer | None:
        """Of its last complete reading, else of the records that were ever seen."""
        which = "AND module = ? AND json_extract(payload, '$.is_confirmed') ORDER BY number DESC LIMIT 1"
        for visit in self._readable(FactKind.VISIT, which, (module,)):
            return LastAnswer(visit.at, len(visit.content["slots"]))
        records = self.records(module)
        return LastAnswer(max(record.first_seen_at for record in records), len(records)) if records else None

    def is_said_new(self, module: str) -> bool:
        facts = self._about(FactKind.SAID_NEW, module)
        return bool(facts and facts[-1].content["is_new"])

    def say_new(self, module: str, *, is_new: bool = True) -> None:
        """Stores a person's word that the module is new and has no records; False ends it."""
        if self.is_said_new(module) is not is_new:
            self._facts.add(FactKind.SAID_NEW, {"is_new": is_new}, module=module)

    # Checks

    def past(
        self, module: str | None, slots: Sequence[bytes] | None = None, *, is_confirmed: bool = True,
        counts_simulated: bool = False,
    ) -> Past:  # fmt: skip
        """What a check needs from the module's history; to be called before this check's own visit is stored. `slots`:
        the records on the module now, to see whether they continue those of the last visit. `counts_simulated`: include
        the checks of simulated modules."""
        if module is None:
            return Past(module=module)
        booted = self._last_visit(module, has_boot_count=True)
        checks = (check for check in self.checks(module) if counts_simulated or not check.is_simulated)
        go = next((check for check in checks if check.has_passed), None)
        last, last_slots, known = self._last(module)
        merged = None
        if slots is not None and last is not None:
            merged = merge([record.raw for record in known], last_slots, slots, is_confirmed=is_confirmed)
        return Past(
            module=module,
            boot_count=booted.content["boot_count"] if booted is not None else None,
            reviewed=Counter(record.raw for record in self.records(module) if record.judgement is not None),
            has_check=go is not None,
            do_records_follow=merged is None or merged.is_continuation,
            last_answer=self.last_answer(module),
            is_said_new=self.is_said_new(module),
            fingerprint=go.code if go is not None else None,
        )

    def add_check(self, signed: SignedRecord) -> None:
        """Keeps a record: the signed document, and beside it what lists show."""
        record = signed.record
        content = {
            "verdict": record.verdict.value,
            "is_void": record.void is not None,
            "is_simulated": record.is_simulated,
            "who": record.who,
            "aircraft": record.aircraft,
            "adapter": record.adapter,
            "code": record.settings_code,
            "measured": measured_in(record),
            "document": signed.text,
        }
        at = utc_time(record.at.isoformat())
        self._facts.add(FactKind.CHECK, content, module=record.module, at=at)

    def document(self, id_: int) -> str:
        """Of one check that is listed."""
        ((text,),) = self._facts.database.read(
            "SELECT json_extract(payload, '$.document') FROM facts WHERE number = ?", (id_,)
        )
        return str(text)

    def checks(self, module: str | None = None, *, aircraft: str | None = None) -> tuple[CheckLine, ...]:
        """Newest first, of one module (None: modules without a name) or of one aircraft. Takes up to a millisecond for
        each: not for the window's thread."""
        where, value = (f"{_AIRCRAFT} = ?", aircraft) if aircraft is not None else ("module IS ?", module)
        facts = self._facts.select(
            FactKind.CHECK,
            f"AND {where} ORDER BY number DESC LIMIT ?",
            (value, _LISTED),
            payload="json_set(payload, '$.document', '')",
        )
        lines = [
            check_line(check, fact.content.get("module"), fact.at, id_=fact.number)
            for fact in facts
            if (check := check_of(fact.content)) is not None
        ]
        fired = {name: all_fired(self._facts, name) for name in {line.module for line in lines} if name is not None}
        return tuple(line.after(fired.get(line.module or "", ())) for line in lines)

    def aircraft(self) -> tuple[str, ...]:
        """Those of the last checks of all modules, the last checked first. Not for the window's thread."""
        return tuple(dict.fromkeys(filter(None, self._aircraft("ORDER BY number DESC LIMIT ?", _RECENT))))

    def aircraft_of(self, module: str) -> str:
        """In the last check of this module that names one; else empty."""
        which = f"AND module = ? AND {_AIRCRAFT} <> '' ORDER BY number DESC LIMIT 1"
        return next(iter(self._aircraft(which, module)), "")

    def _aircraft(self, which: str, value: object) -> list[str]:
        checks = self._facts.select(FactKind.CHECK, which, (value,), payload=f"json_object('name', {_AIRCRAFT})")
        return [check.content["name"] for check in checks]


_AIRCRAFT = "json_extract(payload, '$.aircraft')"


def _seen(fact: Kept, judged: Mapping[str, Any]) -> SeenRecord:
    judgement = next((judgement for judgement in Judgement if judgement.value == judged.get("judgement")), None)
    return SeenRecord(fact.number, fact.content["place"], bytes.fromhex(fact.content["raw"]), fact.at, judgement,
                      str(judged.get("note", "")))  # fmt: skip


def is_readable(kind: FactKind, content: Mapping[str, Any]) -> bool:
    """The one place where the decoding of a row may fail."""
    try:
        msgspec.convert(content, KINDS[kind.value])
    except msgspec.ValidationError:
        return False
    return True


def check_of(content: Mapping[str, Any]) -> PreflightCheck | None:
    """None for what this version cannot read."""
    try:
        return msgspec.convert(content, PreflightCheck)
    except msgspec.ValidationError:
        return None


def check_line(check: PreflightCheck, module: str | None, at: str, *, id_: int = 0, station: str = "") -> CheckLine:
    """`at`: when it was kept; `station`: by whom, "" here."""
    return CheckLine(
        id=id_,
        at=at,
        module=module,
        verdict=check.verdict,
        is_void=check.is_void,
        is_simulated=check.is_simulated,
        who=clean(check.who),
        aircraft=clean(check.aircraft),
        code=check.code,
        measured=check.measured,
        station=station,
    )


def measuring(checks: Sequence[CheckLine]) -> list[CheckLine]:
    """Those whose measured values are the module's: of a simulated one only where there is no other."""
    sound = [check for check in checks if not check.is_void]
    return [check for check in sound if not check.is_simulated] or sound


def measured_in(record: Record) -> dict[str, float]:
    """The values of `MEASURED` in a record."""
    values: dict[str, float] = {}
    for check in record.checks:
        name, value = MEASURED.get(check.id), check.measured
        if name is not None and isinstance(value, int | float) and not isinstance(value, bool):
            values[name] = float(value)
    return values
