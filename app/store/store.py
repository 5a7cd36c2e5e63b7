"""Store of modules, snapshots, audit log and pending changes of baud rate."""

import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

from app.engine.identity import IdentityEvidence
from app.engine.snapshots import Snapshot, restorable
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.database import Clock, Database, open_database, utc_now
from app.store.facts import FORMER_ENTRY, FactKind, Facts, object_in
from app.store.former import STORE
from app.store.write_queue import WriteQueue
from app.system.folders import data_folder

CLOSE_LIMIT_S = 5.0
"""Default time limit for queued writes at `close`."""
_log = logging.getLogger(__name__)


class Module(NamedTuple):
    """A module has no serial number of its own: the technician names it. `adapter`: the USB identity it was last at."""

    name: str
    adapter: str


class AuditEntry(NamedTuple):
    """The outcome of one that the program did not see the end of reads as unknown."""

    id: int
    port: str
    at: str
    act: Act
    frame: bytes
    detail: Mapping[str, object]
    outcome: Outcome
    result: Mapping[str, object]


class PendingBaud(NamedTuple):
    """A change of rate whose end nobody saw: look at `new_rate`, then `old_rate`, then all."""

    id: int
    port: str
    adapter: str
    old_rate: int
    new_rate: int
    at: str
    module: str = ""
    """Its name, where it had one."""


class Store:
    """Every method may be called from any thread and raises `StoreTrouble`."""

    def __init__(self, database: Database | Callable[[], Database]) -> None:
        """A function opens it in the store's thread, so that nobody waits for the disk."""
        self.queue = WriteQueue()
        """For callers that must not wait for the disk."""
        if isinstance(database, Database):
            self._opened = Future[Database]()
            self._opened.set_result(database)
        else:
            self._opened = self.queue.submit(database)

    @property
    def database(self) -> Database:
        """Waits for the opening, but in the store's own thread, where it is done."""
        return self._opened.result()

    @property
    def facts(self) -> Facts:
        return Facts(self.database)

    def close(self, limit_s: float = CLOSE_LIMIT_S) -> int:
        """Write what is queued, then close; returns how many pieces were not written within `limit_s`. Never raises."""
        left = self.queue.close(limit_s, self._close_database)
        if left:
            _log.warning("Not written when the store was closed: %s", left)
        return left

    def _close_database(self) -> None:
        if self._opened.done() and not self._opened.cancelled() and self._opened.exception() is None:
            self._opened.result().close()

    # Modules

    def register_module(self, name: str, adapter: str = "") -> None:
        """It is made if it is new, and was seen now. An empty `adapter` keeps the last one."""
        with self.database.transaction():
            known = self.module_named(name)
            module = Module(name, adapter or (known.adapter if known else ""))
            if module != known:
                self.facts.add(FactKind.MODULE, {"adapter": module.adapter}, module=name)
            self.facts.set_state(f"module:{name}", {"adapter": module.adapter})

    def modules(self) -> tuple[Module, ...]:
        """The last seen first."""
        query = "SELECT substr(key, 8), value FROM state WHERE key LIKE 'module:%' ORDER BY rowid DESC"
        rows = self.database.read(query)
        return tuple(_module(name, object_in(value)) for name, value in rows)

    def module_named(self, name: str) -> Module | None:
        """None if there is no module of this name."""
        state = self.facts.state(f"module:{name}")
        return None if state is None else _module(name, state)

    def store_evidence(self, module: str, evidence: IdentityEvidence) -> None:
        """Store what was last read of a module, to recognise it by."""
        state = {"boot_count": evidence.boot_count, "settings": dict(evidence.settings)}
        self.facts.set_state(f"evidence:{module}", state)

    def evidence(self, module: str) -> IdentityEvidence:
        """What was last read of a module, else the boot count of its last visit, else empty."""
        state = self.facts.state(f"evidence:{module}")
        if state is None:
            visit = self.facts.last_visit(module, "boot_count")
            return IdentityEvidence(visit.content["boot_count"]) if visit is not None else IdentityEvidence()
        settings = state.get("settings")
        return IdentityEvidence(state.get("boot_count"), restorable(settings if isinstance(settings, dict) else {}))

    # Snapshots

    def store_snapshot(self, snapshot: Snapshot, *, port: str, module: str = "") -> int:
        """`module`: its name, where it has one; a new one is registered."""
        with self.database.transaction():
            if module:
                self.register_module(module)
            content = {"port": port, "boot_count": snapshot.boot_count, "settings": dict(snapshot.settings)}
            return self.facts.add(FactKind.SNAPSHOT, content, module=module or None)

    # Audit

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], *, port: str, origin: str) -> int:
        content = {"act": act.value, "port": port, "origin": origin, "frame": frame.hex(" ").upper(),
                   "detail": dict(detail)}  # fmt: skip
        module = detail.get("module")
        return self.facts.add(FactKind.ACT, content, module=module if isinstance(module, str) else None, link=act.value)

    def settle(self, entry: int, outcome: Outcome, result: Mapping[str, object]) -> None:
        self.facts.end(entry, {"outcome": outcome.value, "result": dict(result)})

    def audit(self, *acts: Act) -> tuple[AuditEntry, ...]:
        """The newest first; of these acts, or of all."""
        which = f"AND a.link IN ({', '.join('?' * len(acts))})" if acts else ""
        rows = self.database.read(
            "SELECT a.number, a.kind, a.made_at, a.payload, o.payload FROM facts a "  # noqa: S608
            f"LEFT JOIN facts o ON o.link = a.hash AND o.kind = ? WHERE a.kind IN (?, ?) {which} ORDER BY a.number",
            (FactKind.OUTCOME.value, FactKind.ACT.value, FactKind.AUDIT.value, *(act.value for act in acts)),
        )
        entries: dict[object, AuditEntry] = {}
        for number, kind, at, payload, outcome in rows:
            content = object_in(payload)
            if kind == FactKind.AUDIT.value:
                entry = former_entry(content["entry"])
                entries["former", entry.id] = entry
            else:
                entries[number] = audit_entry(number, at, content, object_in(outcome))
        return tuple(reversed(entries.values()))

    def pending_bauds(self) -> tuple[PendingBaud, ...]:
        """Changes of the baud rate without an outcome, the newest first; checked at the next start. `settle` ends
        one."""
        is_open = "AND NOT EXISTS (SELECT 1 FROM facts o WHERE o.link = facts.hash AND o.kind = ?) ORDER BY number DESC"
        ended = FactKind.OUTCOME.value
        acts = self.facts.select(FactKind.ACT, f"AND link = ? {is_open}", (Act.CHANGE_BAUD.value, ended))
        former = self.facts.select(FactKind.BAUD, is_open, (ended,))
        rates = [(fact, fact.content["detail"], ("old", "new")) for fact in acts]
        rates += [(fact, fact.content, ("old_rate", "new_rate")) for fact in former]
        return tuple(
            PendingBaud(
                fact.number,
                fact.content["port"],
                detail.get("adapter", ""),
                detail[old],
                detail[new],
                fact.at,
                detail.get("module", ""),
            )
            for fact, detail, (old, new) in rates
        )


def _module(name: str, state: Mapping[str, Any]) -> Module:
    return Module(name, str(state.get("adapter", "")))


def audit_entry(number: int, at: str, content: Mapping[str, Any], outcome: Mapping[str, Any]) -> AuditEntry:
    return AuditEntry(
        number, content["port"], at, Act(content["act"]), bytes.fromhex(content["frame"]),
        content["detail"], Outcome(outcome.get("outcome", Outcome.UNKNOWN.value)),
        outcome.get("result", {}),
    )  # fmt: skip


def former_entry(entry: Sequence[Any]) -> AuditEntry:
    """An act as the former audit log had it."""
    of = dict(zip(FORMER_ENTRY, entry, strict=True))
    end = {"result": object_in(of["result"])} | ({"outcome": of["outcome"]} if of["outcome"] else {})
    return audit_entry(of["id"], of["at"], {**of, "detail": object_in(of["detail"])}, end)


def open_store(folder: Path | None = None, *, clock: Clock = utc_now) -> Store:
    """Raises `StoreTrouble`."""
    return Store(open_database(folder or data_folder(), STORE, clock=clock))


def opening_store(folder: Path | None = None, *, clock: Clock = utc_now) -> Store:
    """The store at once; it opens in its own thread, and whoever reads from it waits for that or gets its trouble."""
    return Store(lambda: open_database(folder or data_folder(), STORE, clock=clock))
