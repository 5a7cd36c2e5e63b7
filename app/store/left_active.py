"""Modules that the audit log leaves ACTIVE: activated or not confirmed as locked, and not reported LOCKED since."""

from dataclasses import dataclass

from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.store import Store
from app.store.store_journal import RUN, StoreJournal

_SIMULATED = "sim:"
_LEAVES_ACTIVE = {
    Act.ACTIVATE: (Outcome.CONFIRMED, Outcome.UNKNOWN),
    Act.LOCK: (Outcome.REFUSED, Outcome.UNKNOWN),
}


@dataclass(frozen=True, slots=True)
class LeftActive:
    """`module`: its name, "" where it has none; it is then known only within the `run` of the program that wrote the
    entry. `at`: when, ISO 8601 in UTC. `is_lock_unconfirmed`: LOCK was sent, and the module did not report LOCKED."""

    module: str
    port: str
    adapter: str
    run: str
    at: str
    is_lock_unconfirmed: bool

    @property
    def key(self) -> tuple[str, ...]:
        """What two entries about one module have in common."""
        return (self.module,) if self.module else ("", self.run, self.adapter or self.port)


def left_active(store: Store) -> tuple[LeftActive, ...]:
    """The last first. A name follows a module, a port or an adapter does not."""
    left: dict[tuple[str, ...], LeftActive] = {}
    for entry in reversed(store.audit(Act.ACTIVATE, Act.LOCK, Act.SHUTDOWN)):
        if entry.port.startswith(_SIMULATED):
            continue
        name, adapter, run = (str(entry.detail.get(key, "")) for key in ("module", "adapter", "run"))
        seen = LeftActive(name, entry.port, adapter, run, entry.at, is_lock_unconfirmed=entry.act is Act.LOCK)
        if entry.outcome in _LEAVES_ACTIVE.get(entry.act, ()):
            left[seen.key] = seen
        elif entry.act in (Act.LOCK, Act.SHUTDOWN) and entry.outcome is Outcome.CONFIRMED:
            left.pop(seen.key, None)
            left.pop(("", run, adapter or entry.port), None)  # activated before it got its name
    return tuple(sorted(left.values(), key=lambda one: one.at, reverse=True))


def note_report(store: Store, *, port: str, adapter: str, module: str, origin: str, is_active: bool) -> None:
    """Logs what a known module reports where it differs from what the log says; to be run in the store's thread."""
    here = LeftActive(module, port, adapter, RUN, "", is_lock_unconfirmed=False)
    keys = {one.key for one in left_active(store)}
    is_left = here.key in keys or ("", RUN, adapter or port) in keys
    if is_left is not is_active:
        _log(StoreJournal(store, port=port, origin=origin, adapter=adapter, module=module), RUN, "module", is_active)


def note_locked(store: Store, left: LeftActive, origin: str) -> None:
    """Logs that a person says that it is locked, or switched off."""
    journal = StoreJournal(store, port=left.port, origin=origin, adapter=left.adapter, module=left.module)
    _log(journal, left.run, "person", False)


def _log(journal: StoreJournal, run: str, said_by: str, is_active: bool) -> None:
    """An entry without a frame: nothing was sent."""
    act = Act.ACTIVATE if is_active else Act.LOCK
    entry = journal.begin(act, b"", {"run": run, "reported_by": said_by})
    journal.settle(entry, Outcome.CONFIRMED, {"sent": 0})
