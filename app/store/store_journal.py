"""Journal of one connection in the store; and what its module reports, or a person says, of its activation."""

import logging
import os
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Final

from app.safety.acts import Act
from app.safety.journal import Entry, Outcome
from app.store.acts import Where, begin, open_intents, settle
from app.store.fact_store import Facts, Store
from app.store.fired import forget_unnamed, note_unnamed
from app.store.left_active import KnownAs, LeftActive, end_left, kept_left
from app.store.trouble import StoreTrouble
from app.text.messages import UserMessage

_log = logging.getLogger(__name__)

UNNAMED: Final = KnownAs()
Adapter = str | Callable[[], str]
"""The USB identity, or what finds it, which may take seconds."""


def new_run() -> str:
    """Names one connection: a module without a name is not known beyond it."""
    return os.urandom(4).hex()


class StoreJournal:
    """The journal of one connection, written by the store's own thread, which also finds the `adapter`."""

    def __init__(
        self,
        store: Store,
        *,
        port: str,
        origin: str,
        adapter: Adapter = "",
        known_as: KnownAs = UNNAMED,
        on_trouble: Callable[[UserMessage], object] = bool,
    ) -> None:
        """`on_trouble` is called in the store's thread with the reason why an entry could not be written."""
        self._store = store
        self._port = port
        self._origin = origin
        self._adapter = adapter
        self._known_as = known_as
        self._on_trouble = on_trouble
        self._has_noted_deploy = False

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        given = dict(detail)

        def write(facts: Facts) -> str:
            where = self._where()
            if act is Act.DEPLOY and not self._known_as.name:
                self._has_noted_deploy = note_unnamed(facts, port=self._port, adapter=where.adapter)
            return begin(facts, act, frame, given, where)

        entry = self._store.write(write)
        entry.add_done_callback(self._tell)
        return entry

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        """Behind its entry: the queue keeps the order. An intent that was not written has no outcome to write."""
        kept = dict(result)

        def write(facts: Facts) -> None:
            if entry.cancelled() or entry.exception() is not None:
                return
            settle(facts, entry.result(), outcome, kept)
            if self._has_noted_deploy and outcome is Outcome.NOT_SENT:
                forget_unnamed(facts, port=self._port, adapter=self._where().adapter)
            self._has_noted_deploy = False

        self._store.write(write).add_done_callback(self._tell)

    def _where(self) -> Where:
        adapter = self._adapter if isinstance(self._adapter, str) else self._adapter()
        return Where(self._port, self._origin, adapter, self._known_as)

    def _tell(self, written: "Future[str] | Future[None]") -> None:
        error = None if written.cancelled() else written.exception()
        if isinstance(error, StoreTrouble):
            _log.warning("The audit log cannot be written: %s", error)
            self._on_trouble(error.message)


def left_active(facts: Facts) -> tuple[LeftActive, ...]:
    """The last first. A name follows a module, a port or an adapter does not."""
    found = [*kept_left(facts), *open_intents(facts, Act.ACTIVATE, Act.LOCK).values()]
    left: dict[tuple[str, ...], LeftActive] = {}
    for entry in sorted(found, key=lambda one: one.at):
        left.pop(entry.keys[-1], None)  # it has got its name since
        left[entry.keys[0]] = entry
    return tuple(sorted(left.values(), key=lambda one: one.at, reverse=True))


def note_report(facts: Facts, here: LeftActive, origin: str, *, is_active: bool) -> None:
    """Logs what a known module reports, where it differs from what the log says."""
    left = {active.keys[0] for active in left_active(facts)}
    keys = here.keys[:1] if is_active else here.keys
    if any(key in left for key in keys) is not is_active:
        _log_report(facts, here, origin, "module", is_active=is_active)


def note_locked(facts: Facts, left: LeftActive, origin: str) -> None:
    """Logs that a person says that it is locked, or switched off."""
    _log_report(facts, left, origin, "person", is_active=False)


def note_continued(facts: Facts, left: LeftActive, here: LeftActive, origin: str) -> None:
    """Logs that a person says that it is the one connected `here`, whose reports count from now on."""
    _log_report(facts, left, origin, "person", is_active=True, goes_on_as=here.known_as.run)
    end_left(facts, left)


def _log_report(facts: Facts, where: LeftActive, origin: str, reporter: str, *, is_active: bool, **more: str) -> None:
    """An entry without a frame: nothing was sent."""
    known_as = KnownAs(where.known_as.name, where.known_as.run)
    act = Act.ACTIVATE if is_active else Act.LOCK
    detail: dict[str, object] = {"reported_by": reporter, **more}
    entry = begin(facts, act, b"", detail, Where(where.port, origin, where.adapter, known_as))
    settle(facts, entry, Outcome.CONFIRMED, {"sent": 0})
