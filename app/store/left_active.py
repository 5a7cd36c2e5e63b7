"""Modules that the audit log leaves ACTIVE: activated or not confirmed as locked, and not reported LOCKED since."""

from typing import NamedTuple

from app.engine.target import is_simulated
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.last_known import keep_away
from app.store.store import Store
from app.store.store_journal import KnownAs, detail_of
from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.sentences import join_sentences

_LEAVES_ACTIVE = {
    Act.ACTIVATE: (Outcome.CONFIRMED, Outcome.UNKNOWN),
    Act.LOCK: (Outcome.REFUSED, Outcome.UNKNOWN),
}


class LeftActive(NamedTuple):
    """`at`: when, ISO 8601 in UTC. `is_lock_unconfirmed`: LOCK was sent, and the module did not report LOCKED."""

    known_as: KnownAs
    port: str
    adapter: str
    at: str = ""
    is_lock_unconfirmed: bool = False

    @property
    def keys(self) -> tuple[tuple[str, ...], ...]:
        """What entries about one module have in common: its name, or the connection in which it had none yet."""
        unnamed = ("", self.known_as.run, self.adapter or self.port)
        return ((self.known_as.name,), unnamed) if self.known_as.name else (unnamed,)

    @property
    def sentence(self) -> str:
        """In the language in use."""
        when = local_time(self.at, MINUTE)
        module = self.known_as.name or tr("The module at {port}", port=self.port)
        text = (
            tr("{module}: LOCK not confirmed on {time}.", module=module, time=when)
            if self.is_lock_unconfirmed
            else tr("{module} was left ACTIVE on {time}.", module=module, time=when)
        )
        return join_sentences((text, keep_away()))


def left_active(store: Store) -> tuple[LeftActive, ...]:
    """The last first. A name follows a module, a port or an adapter does not."""
    left: dict[tuple[str, ...], LeftActive] = {}
    for entry in reversed(store.audit(Act.ACTIVATE, Act.LOCK, Act.SHUTDOWN)):
        if is_simulated(entry.port):
            continue
        name, adapter, run = (str(entry.detail.get(key, "")) for key in ("module", "adapter", "run"))
        known_as = KnownAs(name, run, is_in_doubt=bool(entry.detail.get("is_in_doubt")))
        seen = LeftActive(known_as, entry.port, adapter, entry.at, is_lock_unconfirmed=entry.act is Act.LOCK)
        if entry.detail.get("goes_on_as"):
            left.pop(seen.keys[0], None)
        elif entry.outcome in _LEAVES_ACTIVE.get(entry.act, ()):
            left.pop(seen.keys[-1], None)  # it has got its name since
            left[seen.keys[0]] = seen
        elif entry.act is not Act.ACTIVATE and entry.outcome is Outcome.CONFIRMED and not known_as.is_in_doubt:
            for key in seen.keys:
                left.pop(key, None)
    return tuple(sorted(left.values(), key=lambda active: active.at, reverse=True))


def note_report(store: Store, here: LeftActive, origin: str, *, is_active: bool) -> None:
    """Logs what a known module reports where it differs from what the log says; to be run in the store's thread."""
    left, keys = {active.keys[0] for active in left_active(store)}, here.keys[:1] if is_active else here.keys
    if any(key in left for key in keys) is not is_active:
        _log(store, here, origin, "module", is_active)


def note_locked(store: Store, left: LeftActive, origin: str) -> None:
    """Logs that a person says that it is locked, or switched off; to be run in the store's thread."""
    _log(store, left, origin, "person", False)


def note_continued(store: Store, left: LeftActive, here: LeftActive, origin: str) -> None:
    """Logs that a person says that it is the one connected `here`, whose reports count from now on; to be run in the
    store's thread."""
    _log(store, left, origin, "person", True, goes_on_as=here.known_as.run)


def _log(store: Store, where: LeftActive, origin: str, reporter: str, is_active: bool, **more: str) -> None:
    """An entry without a frame: nothing was sent."""
    detail = detail_of(KnownAs(where.known_as.name, where.known_as.run), where.adapter)
    detail |= {"reported_by": reporter, **more}
    act = Act.ACTIVATE if is_active else Act.LOCK
    store.settle(store.begin(act, b"", detail, port=where.port, origin=origin), Outcome.CONFIRMED, {"sent": 0})
