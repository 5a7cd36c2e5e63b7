"""Makes stations of an archive, each with its store, key and facts in its own folder."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, date, datetime
from functools import cache
from pathlib import Path
from typing import Any

import msgspec

from app import version
from app.archive.archive import Archive
from app.engine.snapshots import Snapshot
from app.guided.guided_store import keep_test
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue
from app.limits.service import Service, ServiceKind
from app.preflight.findings import CheckResult
from app.preflight.verdict import Verdict
from app.records.check_store import CheckStore
from app.records.record import Record, SignedRecord, sign
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.stations.station import Station
from app.store.facts import FactKind
from app.store.store import Store, open_store
from app.store.store_journal import KnownAs, StoreJournal
from app.text.messages import UserMessage
from app.trigger_records.history import Judgement
from tests.support.records.preflight_rig import check

FRAME = bytes.fromhex("42 61 25 01 00 26")
NOON = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)
_SLOT = bytes.fromhex("41 75 35 01 00 6C 3C 05 10 00 0C 2F 00 00 00 00")


def slot(number: int) -> bytes:
    """Return a trigger record that differs for each number."""
    return _SLOT[:4] + number.to_bytes(2, "big") + _SLOT[6:]


@dataclass
class ArchiveStation:
    folder: Path
    store: Store
    archive: Archive

    @property
    def station(self) -> Station:
        return self.archive.station

    def ids(self) -> set[str]:
        return {row[0] for row in self.content()}

    def content(self) -> list[tuple[str, ...]]:
        """Return all facts, ordered by id."""
        return sorted(fact.row for fact in self.archive.of_kind(None))

    # Events at a station

    def meet(self, module: str, adapter: str = "usb 1") -> str:
        self.store.register_module(module, adapter)
        return module

    def visit(self, module: str, *numbers: int) -> None:
        checks = CheckStore(self.store.database)
        slots = [slot(number) for number in numbers]
        checks.store_visit(self.meet(module), slots, port="p", boot_count=7, is_confirmed=True)

    def judge(self, module: str, judgement: Judgement) -> None:
        checks = CheckStore(self.store.database)
        for record in checks.records(self.meet(module)):
            checks.judge(record.id, judgement, "seen")

    def snapshot(self, module: str, threshold: int = 60) -> None:
        found = Snapshot(settings={"attitude_threshold_deg": threshold}, boot_count=7)
        self.meet(module)
        self.store.store_snapshot(found, port="p", module=module)

    def test(self, module: str, verdict: GuidedVerdict = GuidedVerdict.PASSED, *, is_simulated: bool = False) -> None:
        text = UserMessage("x")
        result = GuidedResult(GuidedKind.TILT, (MeasuredValue(text, text, text, verdict, 61.0),))
        keep_test(
            self.store.facts,
            result,
            module=self.meet(module),
            adapter="usb 1",
            who="Li",
            is_simulated=is_simulated,
            program=version(),
        )

    def serve(self, module: str, on: date, due: date | None = None) -> None:
        service = Service(kind=ServiceKind.REPACK, on=on, due=due)
        self.store.facts.add(FactKind.SERVICE, service.content(), module=module)

    def act(self, module: str = "", *, is_settled: bool = True) -> None:
        journal = StoreJournal(self.store, port="p", origin="window", known_as=KnownAs(module))
        entry = journal.begin(Act.LOCK, FRAME, {"tilt_deg": 1})
        if is_settled:
            journal.settle(entry, Outcome.CONFIRMED, {"active": False})
        self.store.queue.submit(int).result()

    def check(self, module: str, verdict: str = "GO", /, cell_v: float = 4.0, **changes: Any) -> SignedRecord:
        """Store the record of a check, with the content of a real one. `changes`: what it says otherwise."""
        base = _base_record()
        checks = []
        for one in base.checks:
            if one.id == "cell_voltage":
                result = CheckResult.FAIL if verdict == "NO-GO" else one.result
                checks.append(msgspec.structs.replace(one, measured=cell_v, result=result))
            elif one.id == "activation":
                checks.append(msgspec.structs.replace(one, measured=verdict == "GO"))
            else:
                checks.append(one)
        status = base.read["status"] | {"active": verdict == "GO"}
        record = msgspec.structs.replace(
            base,
            module=module,
            at=datetime.fromisoformat(self.store.database.now()),
            verdict=Verdict(verdict),
            checks=checks,
            read=base.read | {"status": status},
        )
        signed = sign(msgspec.structs.replace(record, **changes), self.station)
        self.meet(module)
        CheckStore(self.store.database).add_check(signed)
        return signed


@cache
def _base_record() -> Record:
    return check().record({"at": NOON}, who="Li", module="M", aircraft="A")


@contextmanager
def archive_station(folder: Path, *, clock: Callable[[], datetime] = lambda: NOON) -> Iterator[ArchiveStation]:
    with closing(open_store(folder, clock=clock)) as store, closing(Archive(store, clock=clock)) as archive:
        yield ArchiveStation(folder, store, archive)
