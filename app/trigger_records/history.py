"""Trigger records: the merged history of a module, records as sentences, what is kept of them, and the CSV file."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC
from pathlib import Path
from typing import NamedTuple

from app.engine.procedure import EngineView, Inspect, Procedure
from app.engine.target import is_simulated
from app.limits.limits import record_outside
from app.modules.names import remember
from app.procedures.history import History, read_history
from app.store.acts import claim_fired
from app.store.fact_store import Facts, Kept
from app.store.rows import Judgement, ModuleVisited, SaidNew, TriggerRecordJudged, TriggerRecordSeen
from app.system.clock import local_time
from app.system.files import write_whole
from app.text.csv_cells import BYTE_ORDER_MARK, csv_text
from app.text.messages import UserMessage, clean, joined, message
from protocol.catalogue import BOOTS, MAX_RECORDS, RECORD_PART
from protocol.fields import Value
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from protocol.translatable import marked

# Largest value of the counter ("最高记录65535秒").
MAX_UPTIME_S = 65535
MAX_NOTE_LENGTH = 2000
JsonValue = bool | int | float | str | list[str] | None
# Names in JSON and in the head of the CSV; they include the unit.
FIELDS = (*RECORD_PART, "implausible", "raw")
CSV_HEAD = ("module", "place", "first_seen_at", "confirmed", *FIELDS, "told", "judgement", "note")
# English, marked. Bits without a name of the vendor are missing.
SOURCE_WORDS = {
    "serial": marked("serial"),
    "attitude": marked("attitude"),
    "pwm": "PWM",
    "freefall": marked("free fall"),
}


# Merging

# A module keeps nine records, in no certain order (E6). They have no number, and two triggers may have equal bytes, so
# records are counted: new is what occurs more often than before.


def new_records(last_slots: Sequence[bytes], slots: Sequence[bytes]) -> list[bytes]:
    """What the module holds now (`slots`) and did not hold at the last visit."""
    return list((Counter(slots) - Counter(last_slots)).elements())


def do_continue(last_slots: Sequence[bytes], slots: Sequence[bytes]) -> bool:
    """False where records are gone that were there at the last visit, as if it were another module."""
    new = len(new_records(last_slots, slots))
    # Once all nine slots are full, each new record replaces one.
    pushed_out = max(0, len(last_slots) + new - MAX_RECORDS)
    return len(slots) - new >= len(last_slots) - pushed_out


def in_order(raws: Sequence[bytes], boot_count: int | None) -> tuple[bytes, ...]:
    """Oldest first: by boot count, relative to `boot_count` because it wraps at 256, then by uptime. Stable."""

    def age(raw: bytes) -> tuple[int, int]:
        boots = RECORD_PART["boot_count"].raw(raw)
        return boots if boot_count is None else -((boot_count - boots) % BOOTS), RECORD_PART["uptime_s"].raw(raw)

    return tuple(sorted(raws, key=age))


def record_of(raw: bytes) -> TriggerRecord:
    """Decodes a stored record. Raises `ValueError`."""
    record = decode_record(raw) if len(raw) == 16 else None
    if record is None or isinstance(record, EmptySlot):
        raise ValueError(raw.hex())
    return record


# Records as fields and as sentences


def record_values(record: TriggerRecord) -> dict[str, JsonValue]:
    return {name: getattr(record, name) for name in RECORD_PART} | {"sources": list(record.sources)}


def fields_of(record: TriggerRecord) -> dict[str, JsonValue]:
    """`FIELDS` of a record: its values, the names of implausible ones, and its bytes."""
    raw = record.raw.hex(" ").upper()
    return {**record_values(record), "implausible": list(record.implausible), "raw": raw}


def source_message(source: str) -> UserMessage:
    """Text of one source; a bit without a name of the vendor is shown as such."""
    return UserMessage(SOURCE_WORDS.get(source, source))


def sentence(record: TriggerRecord) -> UserMessage:
    """ "tipped past 60° 1 min 48 s after power-on of boot 1, serial link connected, 4.70 V (implausible)" """
    causes = []
    for source in record.sources:
        if source == "attitude":
            cause = message(marked("tipped past {threshold}"), threshold=f"{record.attitude_threshold_deg}°")
        elif source == "freefall":
            cause = message(
                marked("fell (below {acceleration} for {seconds})"),
                acceleration=f"{record.freefall_acceleration_g:.1f} g",
                seconds=f"{record.freefall_time_s:.2f} s",
            )
        else:
            cause = message(marked("fired by {source}"), source=source_message(source))
        causes.append(cause)
    volts, outside = f"{record.cell_voltage_v:.2f} V", record_outside(record)
    voltage = UserMessage(volts)
    if record.charging:
        voltage = message(marked("on external power, {voltage}"), voltage=volts)
    elif "cell_voltage_v" in record.implausible:
        voltage = message(marked("{text} (implausible)"), text=volts)
    elif outside is not None:
        voltage = message(marked("{value}, {fault}"), value=volts, fault=message(outside.fault.value))
    linked, not_linked = marked("serial link connected"), marked("serial link not connected")
    return message(
        marked("{what} {uptime} after power-on of boot {boot}, {link}, {voltage}"),
        what=joined(causes, " + ") if causes else message(marked("no cause stated")),
        uptime=uptime_message(record),
        boot=record.boot_count,
        link=message(linked if record.serial_connected else not_linked),
        voltage=voltage,
    )


def uptime_message(record: TriggerRecord) -> UserMessage:
    """ "1 min 48 s"; the counter stops at its largest value, which is shown as "at least"."""
    minutes, seconds = divmod(record.uptime_s, 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        text = message(marked("{hours} h {minutes} min {seconds} s"), hours=hours, minutes=minutes, seconds=seconds)
    elif minutes:
        text = message(marked("{minutes} min {seconds} s"), minutes=minutes, seconds=seconds)
    else:
        text = message(marked("{value} s"), value=seconds)
    return message("≥ {time}", time=text) if record.uptime_s >= MAX_UPTIME_S else text


# The store


class SeenRecord(NamedTuple):
    """A trigger record of a module. `place` counts from 0, the oldest, and stays the same."""

    place: int
    raw: bytes
    first_seen_at: str
    judgement: Judgement | None
    note: str


class Visit(NamedTuple):
    """One reading of a module's records. `records` are all that are known since; `new` counts how many of them it
    added."""

    records: tuple[SeenRecord, ...]
    new: int


class KeptTriggers:
    """Visits and trigger records in the facts of this station. `module`: its name."""

    def __init__(self, facts: Facts) -> None:
        self._facts = facts

    def store_visit(
        self, module: str, slots: Sequence[bytes], *, port: str, boot_count: int | None, is_confirmed: bool
    ) -> Visit:
        """Stores what a module holds now. Within `Store.write`."""
        known, last_slots = self.records(module), self._last_slots(module)
        new = in_order(new_records(last_slots, slots), boot_count)
        for place, raw in enumerate(new, known[-1].place + 1 if known else 0):
            self._facts.add(TriggerRecordSeen(place=place, raw=raw.hex()), module)
        # An incomplete reading adds to what was kept before.
        kept = slots if is_confirmed else [*last_slots, *new][-MAX_RECORDS:]
        visit = ModuleVisited(
            port=clean(port),
            boot_count=boot_count,
            slots=[raw.hex() for raw in kept],
            is_confirmed=is_confirmed,
        )
        self._facts.add(visit, module)
        return Visit(self.records(module), len(new))

    def records(self, module: str) -> tuple[SeenRecord, ...]:
        """Every stored record of this module, the oldest first."""
        judged = {kept.content.place: kept.content for kept in self._facts.of_module(TriggerRecordJudged, module)}
        # The later fact about a place counts: a copy that was restored gets the former one again from the archive.
        seen = {kept.content.place: kept for kept in self._facts.of_module(TriggerRecordSeen, module)}
        records = []
        for place, kept in sorted(seen.items()):
            word = judged.get(place)
            judgement, note = (None, "") if word is None else (word.judgement, word.note)
            records.append(SeenRecord(place, bytes.fromhex(kept.content.raw), kept.at, judgement, note))
        return tuple(records)

    def judge(self, module: str, seen: SeenRecord, judgement: Judgement | None, note: str) -> None:
        """Stores a person's judgement of a record; None removes it. Within `Store.write`."""
        note = clean(note, longest=MAX_NOTE_LENGTH)
        judged = TriggerRecordJudged(place=seen.place, raw=seen.raw.hex(), judgement=judgement, note=note)
        self._facts.add(judged, module)

    def mark_reviewed(self, module: str, raws: Iterable[bytes]) -> None:
        """Stores a person's word that these records are known, for those without a judgement. Within `Store.write`."""
        known = frozenset(raws)
        for record in self.records(module):
            if record.judgement is None and record.raw in known:
                self.judge(module, record, Judgement.REVIEWED, record.note)

    def _last_slots(self, module: str) -> list[bytes]:
        """What the module held at the last visit."""
        visit = self._facts.newest(ModuleVisited, module)
        return [] if visit is None else [bytes.fromhex(slot) for slot in visit.content.slots]

    def do_follow(self, module: str, slots: Sequence[bytes], *, is_confirmed: bool) -> bool:
        """False where these records do not continue those of the last visit: it may be another module."""
        # Of an incomplete reading nothing is concluded from what is absent.
        return not is_confirmed or do_continue(self._last_slots(module), slots)

    # A module that does not answer the query for its records (E7)

    def last_answer(self, module: str) -> Kept[ModuleVisited] | None:
        """The last visit at which it answered the query; None if it never did."""
        visits = self._facts.back_from_newest(ModuleVisited, module)
        return next((visit for visit in visits if visit.content.is_confirmed or visit.content.slots), None)

    def is_said_new(self, module: str) -> bool:
        said = self._facts.newest(SaidNew, module)
        return said is not None and said.content.is_new

    def say_new(self, module: str, *, is_new: bool = True) -> None:
        """Stores a person's word that the module is new and has no records; False ends it. Within `Store.write`."""
        if self.is_said_new(module) is not is_new:
            self._facts.add(SaidNew(is_new=is_new), module)


class TriggersReading(NamedTuple):
    """The records on the module, and what else was known of it in that conversation."""

    history: History
    boot_count: int | None
    # By key, in the field's unit.
    settings: Mapping[str, Value]


def read_triggers() -> Procedure[TriggersReading]:
    """Sends queries only."""
    history = yield from read_history()
    view: EngineView = yield Inspect()
    known = view.conversation
    return TriggersReading(history, known.boot_count, known.settings(view.now))


def file_triggers(
    facts: Facts, reading: TriggersReading, name: str, *, port: str, adapter: str = "", is_same_module: bool = False
) -> Visit | UserMessage:
    """File what was read under the name that a person said in that conversation; or say why nothing was kept, as it may
    be another module. `is_same_module`: a person said that it is not, although the records do not follow. Within
    `Store.write`."""
    history, kept = reading.history, KeptTriggers(facts)
    slots = [record.raw for record in history.records]
    last = facts.newest(ModuleVisited, name)
    if last is not None and is_simulated(last.content.port) is not is_simulated(port):
        return message(marked("simulated"))
    if not is_same_module and not kept.do_follow(name, slots, is_confirmed=history.is_confirmed):
        return message(marked("the records do not follow those of its last visit"))
    remember(facts, name, boot_count=reading.boot_count, settings=reading.settings)
    claim_fired(facts, name, port=port, adapter=adapter)
    return kept.store_visit(name, slots, port=port, boot_count=reading.boot_count, is_confirmed=history.is_confirmed)


def write_archive(path: Path, module: str, records: Iterable[SeenRecord], *, seen_once: frozenset[int]) -> None:
    """Write all records as CSV, safe for spreadsheets: UTF-8 with a byte-order mark, written atomically. `seen_once`:
    places of the records that came in one reading only. Raises `OSError`."""
    rows = []
    for seen in records:
        record = record_of(seen.raw)
        values: dict[str, object] = {
            **fields_of(record),
            "module": clean(module),
            "place": seen.place + 1,
            "first_seen_at": local_time(seen.first_seen_at, zone=UTC),
            "confirmed": seen.place not in seen_once,
            "told": sentence(record).translated(),
            "judgement": None if seen.judgement is None else seen.judgement.value,
            "note": clean(seen.note, longest=MAX_NOTE_LENGTH),
        }
        rows.append([values[name] for name in CSV_HEAD])
    write_whole(path, BYTE_ORDER_MARK + csv_text(CSV_HEAD, rows).encode())
