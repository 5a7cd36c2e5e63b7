"""Store of modules, snapshots, audit log and pending changes of baud rate."""

import json
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from app.engine.identity import IdentityEvidence
from app.engine.snapshots import Snapshot, restorable
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.database import Clock, Database, open_database, utc_now
from app.store.write_queue import WriteQueue
from app.text.messages import UserMessage

CLOSE_LIMIT_S = 5.0
"""Default time limit for queued writes at `close`."""
_log = logging.getLogger(__name__)


def data_folder() -> Path:
    """The platform's folder for this program's data."""
    from platformdirs import user_data_path

    return user_data_path("dps-s-configurator", appauthor=False)


@dataclass(frozen=True, slots=True)
class Module:
    """A module has no serial number of its own: the technician names it. `adapter`: the USB identity it was last at."""

    id: int
    name: str
    adapter: str
    first_seen_at: str


@dataclass(frozen=True, slots=True)
class AuditEntry:
    """`settled_at` None: the program ended before the outcome was known; the outcome reads as unknown."""

    id: int
    port: str
    origin: str
    at: str
    act: Act
    frame: bytes
    detail: Mapping[str, object]
    settled_at: str | None
    outcome: Outcome
    result: Mapping[str, object]


class StreamLeftOn(NamedTuple):
    """The program switched a stream on, and the module has not confirmed "off"; `boot_count` where it is known."""

    boot_count: int | None


@dataclass(frozen=True, slots=True)
class PendingBaud:
    """A change of rate whose end nobody saw: look at `new_rate`, then `old_rate`, then all."""

    id: int
    port: str
    adapter: str
    old_rate: int
    new_rate: int
    at: str


_MODULES = "SELECT id, name, adapter, first_seen_at FROM modules"


class Store:
    """Every method may be called from any thread and raises `StoreTrouble`."""

    def __init__(self, database: Database, notice: UserMessage | None = None) -> None:
        self.database = database
        self.notice = notice
        """A sentence if an old file was set aside when the store was opened."""
        self.queue = WriteQueue()
        """For callers that must not wait for the disk."""

    def close(self, limit_s: float = CLOSE_LIMIT_S) -> int:
        """Write what is queued, then close; returns how many pieces were not written within `limit_s`. Never raises."""
        left = self.queue.close(limit_s, self.database.close)
        if left:
            _log.warning("Not written when the store was closed: %s", left)
        return left

    # Modules

    def register_module(self, name: str, adapter: str = "") -> Module:
        """The module of this name, made if it is new; it was seen now. An empty `adapter` keeps the last one."""
        now = self.database.now()
        self.database.write(
            "INSERT INTO modules (name, adapter, first_seen_at, last_seen_at) VALUES (?, ?, ?, ?) "
            "ON CONFLICT (name) DO UPDATE SET adapter = coalesce(nullif(excluded.adapter, ''), adapter), "
            "last_seen_at = excluded.last_seen_at",
            (name, adapter, now, now),
        )
        (module,) = self.database.read(f"{_MODULES} WHERE name = ?", (name,))
        return Module(*module)

    def modules(self) -> tuple[Module, ...]:
        """The last seen first."""
        return tuple(Module(*row) for row in self.database.read(f"{_MODULES} ORDER BY last_seen_at DESC, id DESC"))

    def module_named(self, name: str) -> Module | None:
        """None if there is no module of this name."""
        rows = self.database.read(f"{_MODULES} WHERE name = ?", (name,))
        return Module(*rows[0]) if rows else None

    def store_evidence(self, module_id: int, evidence: IdentityEvidence) -> None:
        """Store what was last read of a module, to recognise it by."""
        self.database.write(
            "INSERT INTO module_states (module_id, at, boot_count, settings) VALUES (?, ?, ?, ?) "
            "ON CONFLICT (module_id) DO UPDATE SET at = excluded.at, boot_count = excluded.boot_count, "
            "settings = excluded.settings",
            (module_id, self.database.now(), evidence.boot_count, json.dumps(dict(evidence.settings), sort_keys=True)),
        )

    def evidence(self, module_id: int) -> IdentityEvidence:
        """What was last read of a module, else the boot count of its last visit, else empty."""
        rows = self.database.read(
            "SELECT boot_count, settings FROM module_states WHERE module_id = ? "
            "UNION ALL SELECT * FROM (SELECT boot_count, '{}' FROM visits WHERE module_id = ? "
            "AND boot_count IS NOT NULL ORDER BY id DESC LIMIT 1) LIMIT 1",
            (module_id, module_id),
        )
        return IdentityEvidence(rows[0][0], restorable(_object(rows[0][1]))) if rows else IdentityEvidence()

    # The serial output

    def note_stream_on(self, adapter: str, boot_count: int | None) -> None:
        """The program is about to switch the serial output on; it stands until `clear_stream_on`. `boot_count`: on
        which start of the module, where that is known."""
        self.database.write(
            "INSERT OR REPLACE INTO streams_left_on (adapter, at, boot_count) VALUES (?, ?, ?)",
            (adapter, self.database.now(), boot_count),
        )

    def clear_stream_on(self, adapter: str) -> None:
        self.database.write("DELETE FROM streams_left_on WHERE adapter = ?", (adapter,))

    def stream_left_on(self, adapter: str) -> StreamLeftOn | None:
        """What `note_stream_on` stored; None once it is cleared."""
        rows = self.database.read("SELECT boot_count FROM streams_left_on WHERE adapter = ?", (adapter,))
        return StreamLeftOn(*rows[0]) if rows else None

    # Snapshots

    def store_snapshot(self, snapshot: Snapshot, *, port: str, module: str = "") -> int:
        """`module`: its name, where it has one; a new one is registered."""
        module_id = self.register_module(module).id if module else None
        return self.database.write(
            "INSERT INTO settings_snapshots (module_id, port, taken_at, reason, boot_count, settings) "
            "VALUES (?, ?, ?, ?, ?, ?)",
            (module_id, port, self.database.now(), snapshot.reason, snapshot.boot_count,
             json.dumps(dict(snapshot.settings), sort_keys=True)),
        )  # fmt: skip

    # Audit

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], *, port: str, origin: str) -> int:
        return self.database.write(
            "INSERT INTO audit (port, origin, at, act, frame, detail) VALUES (?, ?, ?, ?, ?, ?)",
            (port, origin, self.database.now(), act.value, frame.hex(" ").upper(), json.dumps(dict(detail))),
        )

    def settle(self, entry: int, outcome: Outcome, result: Mapping[str, object]) -> None:
        self.database.write(
            "UPDATE audit SET settled_at = ?, outcome = ?, result = ? WHERE id = ? AND settled_at IS NULL",
            (self.database.now(), outcome.value, json.dumps(dict(result)), entry),
        )

    def audit(self, *, limit: int = 200) -> tuple[AuditEntry, ...]:
        """The newest first."""
        return self._entries("ORDER BY id DESC LIMIT ?", (limit,))

    def acts_of_activation(self) -> tuple[AuditEntry, ...]:
        """What decides whether a module was left ACTIVE, the oldest first."""
        acts = (Act.ACTIVATE.value, Act.LOCK.value, Act.SHUTDOWN.value)
        return self._entries("WHERE act IN (?, ?, ?) ORDER BY id", acts)

    def _entries(self, which: str, values: tuple[object, ...]) -> tuple[AuditEntry, ...]:
        rows = self.database.read(
            f"SELECT id, port, origin, at, act, frame, detail, settled_at, outcome, result FROM audit {which}",  # noqa: S608
            values,
        )
        return tuple(
            AuditEntry(id_, port, origin, at, Act(act), bytes.fromhex(frame), _object(detail), settled_at,
                       Outcome(outcome) if outcome else Outcome.UNKNOWN, _object(result))
            for id_, port, origin, at, act, frame, detail, settled_at, outcome, result in rows
        )  # fmt: skip

    # Changes of baud rate

    def begin_baud(self, old_rate: int, new_rate: int, *, port: str, adapter: str) -> int:
        return self.database.write(
            "INSERT INTO pending_baud (port, adapter, old_rate, new_rate, at) VALUES (?, ?, ?, ?, ?)",
            (port, adapter, old_rate, new_rate, self.database.now()),
        )

    def settle_baud(self, entry: int, outcome: str) -> None:
        self.database.write(
            "UPDATE pending_baud SET settled_at = ?, outcome = ? WHERE id = ?", (self.database.now(), outcome, entry)
        )

    def pending_bauds(self) -> tuple[PendingBaud, ...]:
        """Changes without an outcome, the newest first; checked at the next start."""
        rows = self.database.read(
            "SELECT id, port, adapter, old_rate, new_rate, at FROM pending_baud WHERE settled_at IS NULL "
            "ORDER BY id DESC"
        )
        return tuple(PendingBaud(*row) for row in rows)


def _object(text: str | None) -> dict[str, object]:
    """The JSON object in `text`, empty if there is none."""
    try:
        value = json.loads(text or "{}")
    except ValueError:
        return {}
    return value if isinstance(value, dict) else {}


def open_store(folder: Path | None = None, *, clock: Clock = utc_now) -> Store:
    """Raises `StoreTrouble`."""
    opened = open_database(folder or data_folder(), clock=clock)
    return Store(opened.database, opened.set_aside.message if opened.set_aside is not None else None)
