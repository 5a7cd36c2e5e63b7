"""Reads and writes a store as the program does, and waits for it."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import MappingProxyType

from app.modules.names import Remembered, modules, remember, remembered
from app.records.checks import CheckLine, checks_in
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.left_active import KnownAs, LeftActive, all_left
from app.store import acts
from app.store.fact_store import Clock, Facts, Store, utc_now
from app.store.kinds import SettingsSeen
from app.store.opening import connect
from app.store.store_journal import UNNAMED
from app.trigger_records.kept import KeptTriggers, SeenRecord
from tests.support.patience import PATIENCE_S


def open_store(folder: Path | None = None, *, clock: Clock = utc_now) -> Store:
    """Open. Raises `StoreTrouble`."""
    store = Store(folder, clock=clock)
    store.opened.result(PATIENCE_S)
    return store


def audit(store: Store, *which: Act) -> tuple[acts.AuditEntry, ...]:
    """The newest first, with what was still to be written."""
    return store.write(lambda facts: acts.audit(facts, *which)).result(PATIENCE_S)


def begin(
    store: Store,
    act: Act,
    frame: bytes,
    detail: Mapping[str, object],
    *,
    port: str,
    origin: str = "window",
    adapter: str = "",
    known_as: KnownAs = UNNAMED,
) -> str:
    where = acts.Where(port, origin, adapter, known_as)
    return store.write(lambda facts: acts.begin(facts, act, frame, detail, where)).result(PATIENCE_S)


def settle(
    store: Store,
    intent: str,
    act: Act,
    outcome: Outcome,
    result: Mapping[str, object] = MappingProxyType({}),
    *,
    port: str,
    known_as: KnownAs = UNNAMED,
) -> None:
    where = acts.Where(port, "window", "", known_as)
    store.write(lambda facts: acts.settle(facts, intent, act, where, outcome, result)).result(PATIENCE_S)


def left_in(store: Store) -> tuple[LeftActive, ...]:
    return store.write(all_left).result(PATIENCE_S)


def modules_in(store: Store) -> tuple[Remembered, ...]:
    return store.write(modules).result(PATIENCE_S)


def remembered_in(store: Store, name: str) -> Remembered | None:
    return store.write(lambda facts: remembered(facts, name)).result(PATIENCE_S)


def register(store: Store, name: str, adapter: str = "") -> None:
    store.write(lambda facts: remember(facts, name, adapter=adapter)).result(PATIENCE_S)


def records_of(store: Store, name: str) -> tuple[SeenRecord, ...]:
    return store.write(lambda facts: KeptTriggers(facts).records(name)).result(PATIENCE_S)


def checks_of(store: Store, name: str | None) -> tuple[CheckLine, ...]:
    return store.write(lambda facts: checks_in(facts, name)).result(PATIENCE_S)


def kept_settings(store: Store) -> list[dict[str, object]]:
    """As they were found, newest first."""
    kept = store.write(lambda facts: facts.of_kind(SettingsSeen, is_newest_first=True)).result(PATIENCE_S)
    return [dict(one.content.settings) for one in kept]


@contextmanager
def plain_facts(folder: Path) -> Iterator[Facts]:
    """Facts in a file without a store's thread: each is there at once."""
    folder.mkdir(parents=True, exist_ok=True)
    with closing(connect(folder / "dps-s.sqlite")) as connection:
        last = [datetime(2026, 1, 1, tzinfo=UTC)]

        def tick() -> datetime:
            last[0] = max(utc_now(), last[0] + timedelta(microseconds=1))
            return last[0]

        yield Facts(connection, "a" * 64, tick)
