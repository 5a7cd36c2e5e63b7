"""Stores, stations and reports of tests: as the program makes them, waited for."""

import sqlite3
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import closing
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from app.modules.labels import A4
from app.records.filing import CheckLine, checks_in
from app.safety.journal import Act, Outcome
from app.store import acts
from app.store.fact_store import Clock, Facts, Store, utc_now
from app.store.rows import ActEnded, ActIntended, Content, DeployIntended, Row, SettingsSeen
from app.store.station import Station
from tests.support.patience import PATIENCE_S


def open_store(folder: Path | None = None, *, clock: Clock = utc_now) -> Store:
    """Open. Raises `StoreError`."""
    store = Store(folder, clock=clock)
    store.opened.result(PATIENCE_S)
    return store


def add(store: Store, content: Content, module: str | None = None) -> Future[Row]:
    """Add one fact: it is on the disk when the future is done."""
    return store.write(lambda facts: facts.add(content, module))


class AuditEntry(NamedTuple):
    """`outcome` is unknown where nobody saw the end."""

    id: str
    port: str
    at: str
    act: Act
    frame: bytes
    detail: Mapping[str, object]
    outcome: Outcome
    result: Mapping[str, object]
    module: str
    adapter: str
    origin: str


def audit(store: Store, *which: Act) -> tuple[AuditEntry, ...]:
    """The newest first, with what was still to be written; of these acts, or of all."""

    def read(facts: Facts) -> list[AuditEntry]:
        ends = {kept.content.of: kept.content for kept in facts.of_kind(ActEnded)}
        entries = []
        for row, intent in (*facts.of_kind(ActIntended), *facts.of_kind(DeployIntended)):
            end = ends.get(row.id)
            outcome, result = (Outcome.UNKNOWN, {}) if end is None else (end.outcome, end.result)
            entry = AuditEntry(
                row.id, intent.port, row.made_at, Act(intent.act), bytes.fromhex(intent.frame), intent.detail, outcome,
                result, row.module or "", intent.adapter, intent.origin,
            )  # fmt: skip
            entries.append(entry)
        return entries

    found = store.write(read).result(PATIENCE_S)
    found.sort(key=lambda entry: entry.at, reverse=True)
    return tuple(entry for entry in found if not which or entry.act in which)


def begin(
    store: Store, act: Act, frame: bytes, detail: Mapping[str, object], *, port: str, **where: Any
) -> acts.Intent:
    """`where`: other fields of `acts.Where`."""
    here = acts.Where(port, **({"origin": "window"} | where))
    return store.write(lambda facts: acts.begin(facts, act, frame, detail, here)).result(PATIENCE_S)


def settle(
    store: Store, intent: acts.Intent, outcome: Outcome, result: Mapping[str, object] = MappingProxyType({})
) -> None:
    store.write(lambda facts: acts.settle(facts, intent, outcome, result)).result(PATIENCE_S)


def checks_of(store: Store, name: str | None) -> tuple[CheckLine, ...]:
    return store.write(lambda facts: checks_in(facts, name)).result(PATIENCE_S)


def kept_settings(store: Store) -> list[dict[str, object]]:
    """As they were found, newest first."""
    kept = store.write(lambda facts: facts.of_kind(SettingsSeen)).result(PATIENCE_S)
    return [dict(one.content.settings) for one in reversed(kept)]


def tamper(path: Path, *statements: str) -> None:
    """Execute SQL in the file of a store or an archive without what guards it."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        guards = connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall()
        for statement in (*(f"DROP TRIGGER {name}" for (name,) in guards), *statements):
            connection.execute(statement)


@cache
def station(name: str = "hangar") -> Station:
    """Return the station of this name, which signs records; its key lasts for the test run."""
    private = Ed25519PrivateKey.generate()
    return Station(private.public_key().public_bytes_raw().hex(), private)


def print_report(body: str, attachment: bytes) -> bytes:
    from ui.files.report_printer import print_pages

    return print_pages([body], A4, attachment)
