"""Trigger records and pre-flight checks in the store. Every method raises `StoreTrouble`."""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from app.limits.expectations import LastAnswer, Past
from app.preflight.verdict import Verdict
from app.records.record import Record, canonical
from app.store.database import Database
from app.text.messages import clean
from app.trigger_records.history import Judgement, merge
from protocol.catalogue import MAX_RECORDS

MAX_NOTE_LENGTH = 2000
_LARGEST = 2**62
"""Largest number that is looked up; SQLite integers have 64 bits."""
_RECENT = 1000
"""Number of checks that the list of aircraft is made from."""
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

_HOLDS = (Verdict.GO.value, Verdict.READY.value)


MakeRecord = Callable[[int, str | None], Record]
"""Makes a record from its number and the hash of the previous record."""


@dataclass(frozen=True, slots=True)
class SeenRecord:
    """A stored trigger record of a module. `place` counts from 0, the oldest."""

    id: int
    place: int
    raw: bytes
    first_seen_at: str
    judgement: Judgement | None
    note: str


@dataclass(frozen=True, slots=True)
class Visit:
    """One reading of a module's records. `new`: ids of the records added by it; None for the first visit."""

    id: int
    records: tuple[SeenRecord, ...]
    new: frozenset[int] | None
    is_continuation: bool


@dataclass(frozen=True, slots=True)
class StoredCheck:
    """One line of the list of checks."""

    id: int
    module: str | None
    number: int
    at: str
    aircraft: str
    who: str
    verdict: str
    is_void: bool
    fingerprint: str | None
    hash: str


@dataclass(frozen=True, slots=True)
class Point:
    """One value of one check."""

    at: str
    value: float


class _LastVisit(NamedTuple):
    """`number` is 0 where there was no visit. `known`: number of stored records of the module at its end."""

    number: int = 0
    slots: tuple[bytes, ...] = ()
    known: int = 0


class CheckStore:
    """Repository of visits, trigger records and checks in the store's database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    # Triggers

    def store_visit(self, module_id: int | None, slots: Sequence[bytes], *, port: str, boot_count: int | None,
              is_confirmed: bool) -> Visit:  # fmt: skip
        """Stores what a module holds now. Without a name (`module_id` None) the slots are stored as they came."""
        database = self._database
        with database.transaction():
            last = self._last_visit(module_id)
            # Records beyond the last visit are from one that was interrupted; they are written again.
            known = self.records(module_id)[: last.known]
            raws = [one.raw for one in known]
            merged = merge(raws, last.slots, slots, boot_count=boot_count, is_confirmed=is_confirmed)
            now = database.now()
            # Records first, so that a stored visit never refers to a missing one.
            if module_id is not None:
                for place, raw in enumerate(merged.new, len(known)):
                    database.write(
                        "INSERT INTO trigger_records (module_id, place, raw, first_seen_at) VALUES (?, ?, ?, ?) "
                        "ON CONFLICT (module_id, place) DO UPDATE SET raw = excluded.raw",
                        (module_id, place, raw.hex(), now),
                    )
            # An incomplete reading adds to what was kept before.
            kept = slots if is_confirmed else [*last.slots, *merged.new][-MAX_RECORDS:]
            number = database.write(
                "INSERT INTO visits (module_id, at, port, boot_count, slots, is_confirmed, known) "
                "VALUES (?, ?, ?, ?, ?, ?, ?)",
                (
                    module_id, now, clean(port), boot_count, json.dumps([raw.hex() for raw in kept]), is_confirmed,
                    len(merged.all) if module_id is not None else 0,
                ),
            )  # fmt: skip
            records = self.records(module_id)
            new = None if not last.number else frozenset(one.id for one in records[len(known) :])
            return Visit(number, records, new, merged.is_continuation)

    def records(self, module_id: int | None) -> tuple[SeenRecord, ...]:
        """Every stored record of this module, the oldest first."""
        rows = self._database.read(
            "SELECT id, place, raw, first_seen_at, judgement, note FROM trigger_records WHERE module_id IS ? "
            "ORDER BY place",
            (module_id,),
        )
        return tuple(
            SeenRecord(row[0], row[1], bytes.fromhex(row[2]), row[3], _judgement(row[4]), row[5]) for row in rows
        )

    def judge(self, record_id: int, judgement: Judgement | None, note: str) -> None:
        """Stores a person's judgement of a record; None removes it."""
        value = None if judgement is None else judgement.value
        self._database.write(
            "UPDATE trigger_records SET judgement = ?, note = ?, judged_at = ? WHERE id = ?",
            (value, clean(note, longest=MAX_NOTE_LENGTH), self._database.now(), record_id),
        )

    def _last_visit(self, module_id: int | None) -> _LastVisit:
        if module_id is None:
            return _LastVisit()
        rows = self._database.read(
            "SELECT id, slots, known FROM visits WHERE module_id = ? ORDER BY id DESC LIMIT 1", (module_id,)
        )
        if not rows:
            return _LastVisit()
        number, slots, known = rows[0]
        return _LastVisit(number, tuple(bytes.fromhex(one) for one in json.loads(slots)), known)

    # A module that does not answer the query for its records (E7)

    def last_answer(self, module_id: int) -> LastAnswer | None:
        """Of its last complete reading, else of the records that were ever seen."""
        rows = self._database.read(
            "SELECT at, json_array_length(slots) FROM visits WHERE module_id = ? AND is_confirmed ORDER BY id DESC "
            "LIMIT 1",
            (module_id,),
        ) or self._database.read(
            "SELECT max(first_seen_at), count(*) FROM trigger_records WHERE module_id = ? HAVING count(*)", (module_id,)
        )
        return LastAnswer(*rows[0]) if rows else None

    def is_said_new(self, module_id: int) -> bool:
        return bool(self._database.read("SELECT 1 FROM modules WHERE id = ? AND said_new_at NOT NULL", (module_id,)))

    def say_new(self, module_id: int, *, is_new: bool = True) -> None:
        """Stores a person's word that the module is new and has no records; False ends it."""
        self._database.write(
            "UPDATE modules SET said_new_at = ? WHERE id = ?", (self._database.now() if is_new else None, module_id)
        )

    # Checks

    def past(self, module_id: int | None, module: str | None, slots: Sequence[bytes] | None = None,
             *, is_confirmed: bool = True) -> Past:  # fmt: skip
        """What a check needs from the module's history; to be called before this check's own visit is stored.

        `slots`: the records on the module now, to see whether they continue those of the last visit.
        """
        if module_id is None:
            return Past(module=module)
        rows = self._database.read(
            "SELECT boot_count FROM visits WHERE module_id = ? AND boot_count IS NOT NULL ORDER BY id DESC LIMIT 1",
            (module_id,),
        )
        checks = [one for one in self.checks(module_id) if not one.is_void]
        go = next((one for one in checks if one.verdict in _HOLDS), None)
        known, last = self.records(module_id), self._last_visit(module_id)
        reviewed = Counter(one.raw for one in known if one.judgement is not None)
        record = self.record(go.hash) if go is not None else None
        if record is not None:
            reviewed |= Counter(_records_in(record))
        merged = None
        if slots is not None and last.number:
            raws = [one.raw for one in known[: last.known]]
            merged = merge(raws, last.slots, slots, is_confirmed=is_confirmed)
        return Past(
            module=module,
            boot_count=rows[0][0] if rows else None,
            reviewed=reviewed,
            has_check=go is not None,
            do_records_follow=merged is None or merged.is_continuation,
            last_answer=self.last_answer(module_id),
            is_said_new=self.is_said_new(module_id),
            fingerprint=go.fingerprint if go is not None else None,
        )

    def append_check(self, make: MakeRecord, module_id: int | None, *, adapter: str = "") -> Record:
        """Makes the next record of a chain and stores it. A module without a name has a chain for each adapter.

        Number and previous hash are read in the transaction that stores the record, so that two programs never use the
        same ones.
        """
        with self._database.transaction():
            rows = self._database.read(
                "SELECT number, hash FROM preflight_checks WHERE module_id IS ? AND (module_id IS NOT NULL OR "
                "adapter IS ?) ORDER BY id DESC LIMIT 1",
                (module_id, adapter),
            )
            number, previous = rows[0] if rows else (0, None)
            record = make(number + 1, previous)
            self._store_check(record, module_id, adapter)
            return record

    def _store_check(self, record: Record, module_id: int | None, adapter: str) -> None:
        database = self._database
        number = database.write(
            "INSERT INTO preflight_checks (module_id, adapter, number, at, aircraft, who, verdict, is_void, "
            "fingerprint, hash, previous, record) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (
                module_id, adapter, record["number"], record["at"], record["aircraft"], record["who"],
                record["verdict"], record["void"] is not None, record["fingerprint"], record["hash"],
                record["previous"], canonical(record).decode(),
            ),
        )  # fmt: skip
        for name, value in measured_in(record).items():
            database.write("INSERT INTO measured_values (check_id, name, value) VALUES (?, ?, ?)",
                           (number, name, value))  # fmt: skip

    def checks(self, module_id: int | None = None, *, aircraft: str | None = None,
               limit: int = 500) -> tuple[StoredCheck, ...]:  # fmt: skip
        """Newest first, of one module (None: modules without a name) or of one aircraft."""
        where, values = ("c.aircraft = ?", [aircraft]) if aircraft is not None else ("c.module_id IS ?", [module_id])
        rows = self._database.read(
            "SELECT c.id, m.name, c.number, c.at, c.aircraft, c.who, c.verdict, c.is_void, c.fingerprint, c.hash "  # noqa: S608
            f"FROM preflight_checks c LEFT JOIN modules m ON m.id = c.module_id WHERE {where} "
            "ORDER BY c.id DESC LIMIT ?",
            (*values, limit),
        )
        return tuple(
            StoredCheck(id_, module, number, at, aircraft, who, verdict, bool(is_void), fingerprint, hash_)
            for id_, module, number, at, aircraft, who, verdict, is_void, fingerprint, hash_ in rows
        )

    def aircraft(self) -> tuple[str, ...]:
        """Those of the last checks of all modules, the last checked first."""
        rows = self._database.read(
            "SELECT aircraft FROM (SELECT id, aircraft FROM preflight_checks ORDER BY id DESC LIMIT ?) "
            "WHERE aircraft <> '' GROUP BY aircraft ORDER BY max(id) DESC",
            (_RECENT,),
        )
        return tuple(name for (name,) in rows)

    def record(self, hash_: str) -> Record | None:
        """The record with this hash; None where there is none."""
        rows = self._database.read("SELECT record FROM preflight_checks WHERE hash = ?", (clean(hash_),))
        try:
            value = json.loads(rows[0][0]) if rows else None
        except ValueError:
            return None
        return value if isinstance(value, dict) else None

    def same_number(self, record: Mapping[str, object]) -> str | None:
        """Hash of another record with the same number in the same chain. Each station has its own chains."""
        module, adapter, station = record.get("module"), record.get("adapter"), record.get("station")
        number, hash_ = record.get("number"), record.get("hash")
        if not isinstance(number, int) or not -_LARGEST <= number <= _LARGEST or not isinstance(hash_, str):
            return None
        values = (
            clean(str(adapter)), number, clean(hash_), None if module is None else clean(str(module)),
            None if station is None else clean(str(station)),
        )  # fmt: skip
        rows = self._database.read(
            "SELECT c.hash FROM preflight_checks c LEFT JOIN modules m ON m.id = c.module_id WHERE m.name IS ?4 AND "
            "(c.module_id IS NOT NULL OR c.adapter IS ?1) AND c.number = ?2 AND c.hash <> ?3 AND "
            "(?5 IS NULL OR coalesce(json_extract(c.record, '$.station'), ?5) = ?5) LIMIT 1",
            values,
        )
        return rows[0][0] if rows else None

    def measured(self, module_id: int | None, name: str, *, limit: int = 1000) -> tuple[Point, ...]:
        """A measured value over time, the oldest first."""
        rows = self._database.read(
            "SELECT c.at, v.value FROM measured_values v JOIN preflight_checks c ON c.id = v.check_id "
            "WHERE c.module_id IS ? AND v.name = ? ORDER BY c.id DESC LIMIT ?",
            (module_id, name, limit),
        )
        return tuple(Point(*row) for row in reversed(rows))


def measured_in(record: Mapping[str, object]) -> dict[str, float]:
    """The values of `MEASURED` in a record."""
    checks = record.get("checks")
    found: dict[str, float] = {}
    for one in checks if isinstance(checks, list) else []:
        name, value = MEASURED.get(str(one.get("id"))), one.get("measured")
        if name is not None and isinstance(value, int | float) and not isinstance(value, bool):
            found[name] = float(value)
    return found


def _records_in(record: Mapping[str, object]) -> list[bytes]:
    """The trigger records that were on the module at a check."""
    values = record.get("trigger_records")
    return [bytes.fromhex(value) for value in values] if isinstance(values, list) else []


def _judgement(value: str | None) -> Judgement | None:
    return next((one for one in Judgement if one.value == value), None)
