"""Trigger records and pre-flight checks in the store."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from app.engine.target import is_simulated
from app.limits.past import LastAnswer, Past
from app.preflight.verdict import Verdict, verdict_named
from app.records.record import Record, SignedRecord
from app.store.fact_store import Facts, Kept
from app.store.fired import Fired, all_fired, has_fired_since
from app.store.kinds import ModuleVisited, PreflightCheck, SaidNew, TriggerRecordJudged, TriggerRecordSeen
from app.store.modules import last_booted
from app.text.messages import UserMessage, clean, message
from app.trigger_records.history import Judgement, merge
from protocol.catalogue import MAX_RECORDS
from protocol.translatable import marked

MAX_NOTE_LENGTH = 2000
RECENT = 100
"""Number of checks that the list of aircraft is made from."""
LISTED = 200
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

    id: str
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
    """Visits, trigger records and checks in the facts of this station. `module`: its name; None for modules without
    one."""

    def __init__(self, facts: Facts) -> None:
        self._facts = facts

    # Triggers

    def store_visit(
        self, module: str | None, slots: Sequence[bytes], *, port: str, boot_count: int | None, is_confirmed: bool
    ) -> Visit:
        """Stores what a module holds now. Without a name the slots are stored as they came. Within `Store.write`."""
        last, last_slots, known = self._last(module)
        known_raws = [record.raw for record in known]
        merged = merge(known_raws, last_slots, slots, boot_count=boot_count, is_confirmed=is_confirmed)
        if module is not None:
            for place, raw in enumerate(merged.new, len(known)):
                self._facts.add(TriggerRecordSeen(place=place, raw=raw.hex()), module)
        # An incomplete reading adds to what was kept before.
        kept = slots if is_confirmed else [*last_slots, *merged.new][-MAX_RECORDS:]
        visit = ModuleVisited(
            port=clean(port),
            boot_count=boot_count,
            slots=[raw.hex() for raw in kept],
            is_confirmed=is_confirmed,
            known=len(known) + len(merged.new) if module is not None else 0,
        )
        self._facts.add(visit, module)
        records = self.records(module)
        new = None if last is None else frozenset(record.id for record in records[len(known) :])
        return Visit(records, new)

    def is_kept_apart(self, module: str, port: str) -> bool:
        """Whether what was kept of this name is of a simulated module, and `port` leads to a real one, or reversely."""
        last = self._facts.newest(ModuleVisited, module)
        return last is not None and is_simulated(last.content.port) is not is_simulated(port)

    def records(self, module: str | None) -> tuple[SeenRecord, ...]:
        """Every stored record of this module, the oldest first."""
        if module is None:
            return ()
        judged = {kept.content.place: kept.content for kept in self._facts.of_module(TriggerRecordJudged, module)}
        # A later fact about a place counts: a visit that was broken off was written again.
        seen = {kept.content.place: kept for kept in self._facts.of_module(TriggerRecordSeen, module)}
        records = []
        for place in sorted(seen):
            word = judged.get(place)
            judgement = None if word is None or word.judgement is None else Judgement(word.judgement)
            raw = bytes.fromhex(seen[place].content.raw)
            records.append(SeenRecord(place, place, raw, seen[place].at, judgement, "" if word is None else word.note))
        return tuple(records)

    def judge(self, module: str, place: int, judgement: Judgement | None, note: str) -> None:
        """Stores a person's judgement of a record; None removes it. Within `Store.write`."""
        for record in self.records(module):
            if record.place == place:
                judged = TriggerRecordJudged(
                    place=place,
                    raw=record.raw.hex(),
                    judgement=None if judgement is None else judgement.value,
                    note=clean(note, longest=MAX_NOTE_LENGTH),
                )
                self._facts.add(judged, module)

    def mark_reviewed(self, module: str, raws: Iterable[bytes]) -> None:
        """Stores a person's word that these records are known, for those without a judgement. Within `Store.write`."""
        known = frozenset(raws)
        for record in self.records(module):
            if record.judgement is None and record.raw in known:
                self.judge(module, record.place, Judgement.REVIEWED, record.note)

    def _last(self, module: str | None) -> tuple[ModuleVisited | None, list[bytes], tuple[SeenRecord, ...]]:
        """The last visit, what the module held then, and the records that were known at its end: those beyond are of
        a visit that was broken off."""
        visit = self._facts.newest(ModuleVisited, module) if module is not None else None
        if visit is None:
            return None, [], ()
        slots = [bytes.fromhex(slot) for slot in visit.content.slots]
        return visit.content, slots, self.records(module)[: visit.content.known]

    # A module that does not answer the query for its records (E7)

    def last_answer(self, module: str) -> LastAnswer | None:
        """Of its last complete reading, else of the records that were ever seen."""
        for visit in self._facts.of_module(ModuleVisited, module, is_newest_first=True):
            if visit.content.is_confirmed:
                return LastAnswer(visit.at, len(visit.content.slots))
        records = self.records(module)
        return LastAnswer(max(record.first_seen_at for record in records), len(records)) if records else None

    def is_said_new(self, module: str) -> bool:
        said = self._facts.newest(SaidNew, module)
        return said is not None and said.content.is_new

    def say_new(self, module: str, *, is_new: bool = True) -> None:
        """Stores a person's word that the module is new and has no records; False ends it. Within `Store.write`."""
        if self.is_said_new(module) is not is_new:
            self._facts.add(SaidNew(is_new=is_new), module)

    # Checks

    def past(
        self,
        module: str | None,
        slots: Sequence[bytes] | None = None,
        *,
        is_confirmed: bool = True,
        counts_simulated: bool = False,
    ) -> Past:
        """What a check needs from the module's history; to be called before this check's own visit is stored. `slots`:
        the records on the module now, to see whether they continue those of the last visit. `counts_simulated`: include
        the checks of simulated modules."""
        if module is None:
            return Past(module=module)
        booted = last_booted(self._facts, module)
        checks = (check for check in self.checks(module) if counts_simulated or not check.is_simulated)
        go = next((check for check in checks if check.has_passed), None)
        last, last_slots, known = self._last(module)
        merged = None
        if slots is not None and last is not None:
            merged = merge([record.raw for record in known], last_slots, slots, is_confirmed=is_confirmed)
        return Past(
            module=module,
            boot_count=None if booted is None else booted.boot_count,
            reviewed=Counter(record.raw for record in self.records(module) if record.judgement is not None),
            has_check=go is not None,
            do_records_follow=merged is None or merged.is_continuation,
            last_answer=self.last_answer(module),
            is_said_new=self.is_said_new(module),
            fingerprint=go.code if go is not None else None,
        )

    def add_check(self, signed: SignedRecord) -> None:
        """Keeps a record: the signed document, and beside it what lists show. Within `Store.write`."""
        record = signed.record
        check = PreflightCheck(
            verdict=record.verdict.value,  # type: ignore[arg-type]
            is_void=record.void is not None,
            is_simulated=record.is_simulated,
            who=record.who,
            aircraft=record.aircraft,
            adapter=record.adapter,
            code=record.settings_code,
            measured=measured_in(record),
            document=signed.text,
        )
        self._facts.add(check, record.module, at=record.at)

    def document(self, id_: str) -> str:
        """Of one check that is listed."""
        check = self._facts.by_id(PreflightCheck, id_)
        return "" if check is None else check.content.document

    def checks(self, module: str | None = None, *, aircraft: str | None = None) -> tuple[CheckLine, ...]:
        """Newest first, of one module (None: modules without a name) or of one aircraft. Takes up to a millisecond for
        each: not for the window's thread."""
        if aircraft is None:
            kept = self._facts.of_module(PreflightCheck, module, is_newest_first=True, limit=LISTED)
        else:
            every = self._facts.of_kind(PreflightCheck, is_newest_first=True)
            kept = [check for check in every if check.content.aircraft == aircraft][:LISTED]
        lines = [check_line(check) for check in kept]
        fired = {name: all_fired(self._facts, name) for name in {line.module for line in lines} if name is not None}
        return tuple(line.after(fired.get(line.module or "", ())) for line in lines)

    def aircraft(self) -> tuple[str, ...]:
        """Those of the last checks of all modules, the last checked first. Not for the window's thread."""
        recent = self._facts.of_kind(PreflightCheck, is_newest_first=True, limit=RECENT)
        return tuple(dict.fromkeys(check.content.aircraft for check in recent if check.content.aircraft))

    def aircraft_of(self, module: str) -> str:
        """In the last check of this module that names one; else empty."""
        checks = self._facts.of_module(PreflightCheck, module, is_newest_first=True, limit=RECENT)
        return next((check.content.aircraft for check in checks if check.content.aircraft), "")


def check_line(check: Kept[PreflightCheck]) -> CheckLine:
    content = check.content
    return CheckLine(
        id=check.row.id,
        at=check.at,
        module=check.row.module,
        verdict=content.verdict,
        is_void=content.is_void,
        is_simulated=content.is_simulated,
        who=clean(content.who),
        aircraft=clean(content.aircraft),
        code=content.code,
        measured=content.measured,
        station=check.row.station,
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
