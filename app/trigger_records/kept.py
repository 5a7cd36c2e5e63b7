"""Trigger records in the store: visits of a module, its records over time, and what a person said of them."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from app.engine.target import is_simulated
from app.limits.past import LastAnswer
from app.store.fact_store import Facts
from app.store.kinds import ModuleVisited, SaidNew, TriggerRecordJudged, TriggerRecordSeen
from app.text.messages import clean
from app.trigger_records.history import Judgement, merge
from protocol.catalogue import MAX_RECORDS

MAX_NOTE_LENGTH = 2000


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


class KeptTriggers:
    """Visits and trigger records in the facts of this station. `module`: its name."""

    def __init__(self, facts: Facts) -> None:
        self._facts = facts

    def store_visit(
        self, module: str, slots: Sequence[bytes], *, port: str, boot_count: int | None, is_confirmed: bool
    ) -> Visit:
        """Stores what a module holds now. Within `Store.write`."""
        last, last_slots, known = self._last(module)
        known_raws = [record.raw for record in known]
        merged = merge(known_raws, last_slots, slots, boot_count=boot_count, is_confirmed=is_confirmed)
        for place, raw in enumerate(merged.new, len(known)):
            self._facts.add(TriggerRecordSeen(place=place, raw=raw.hex()), module)
        # An incomplete reading adds to what was kept before.
        kept = slots if is_confirmed else [*last_slots, *merged.new][-MAX_RECORDS:]
        visit = ModuleVisited(
            port=clean(port),
            boot_count=boot_count,
            slots=[raw.hex() for raw in kept],
            is_confirmed=is_confirmed,
            known=len(known) + len(merged.new),
        )
        self._facts.add(visit, module)
        records = self.records(module)
        new = None if last is None else frozenset(record.id for record in records[len(known) :])
        return Visit(records, new)

    def is_kept_apart(self, module: str, port: str) -> bool:
        """Whether what was kept of this name is of a simulated module, and `port` leads to a real one, or reversely."""
        last = self._facts.newest(ModuleVisited, module)
        return last is not None and is_simulated(last.content.port) is not is_simulated(port)

    def records(self, module: str) -> tuple[SeenRecord, ...]:
        """Every stored record of this module, the oldest first."""
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

    def _last(self, module: str) -> tuple[ModuleVisited | None, list[bytes], tuple[SeenRecord, ...]]:
        """The last visit, what the module held then, and the records that were known at its end: those beyond are of
        a visit that was broken off."""
        visit = self._facts.newest(ModuleVisited, module)
        if visit is None:
            return None, [], ()
        slots = [bytes.fromhex(slot) for slot in visit.content.slots]
        return visit.content, slots, self.records(module)[: visit.content.known]

    def do_follow(self, module: str, slots: Sequence[bytes], *, is_confirmed: bool) -> bool:
        """False where these records do not continue those of the last visit: it may be another module."""
        last, last_slots, known = self._last(module)
        if last is None:
            return True
        raws = [record.raw for record in known]
        return merge(raws, last_slots, slots, is_confirmed=is_confirmed).is_continuation

    # A module that does not answer the query for its records (E7)

    def last_answer(self, module: str) -> LastAnswer | None:
        """None if it never answered."""
        for visit in self._facts.back_from_newest(ModuleVisited, module):
            if visit.content.is_confirmed or visit.content.slots:
                return LastAnswer(visit.at, len(visit.content.slots))
        return None

    def is_said_new(self, module: str) -> bool:
        said = self._facts.newest(SaidNew, module)
        return said is not None and said.content.is_new

    def say_new(self, module: str, *, is_new: bool = True) -> None:
        """Stores a person's word that the module is new and has no records; False ends it. Within `Store.write`."""
        if self.is_said_new(module) is not is_new:
            self._facts.add(SaidNew(is_new=is_new), module)
