"""The audit log: the intent of each act, durable before its frame leaves, and what came of it.

An intent whose end nobody saw reads as unknown. What an act leaves behind is in `state`: see `app.safety.left_active`
and `app.store.fired`.
"""

import logging
import os
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Final, NamedTuple

from app.engine.target import is_simulated
from app.safety.acts import Act
from app.safety.journal import NOTE, Entry, Outcome
from app.safety.left_active import KnownAs, LeftActive, drop_intent, keep_left, note_locked, note_safe
from app.store.fact_store import Facts, Store
from app.store.fired import forget_unnamed, note_unnamed
from app.store.kinds import ActEnded, ActIntended, DeployIntended
from app.store.rows import time_text
from app.store.trouble import StoreTrouble
from app.text.messages import UserMessage, clean

_log = logging.getLogger(__name__)

UNNAMED: Final = KnownAs()
_LEAVES_ACTIVE = (Act.ACTIVATE, Act.LOCK)
# After these, confirmed, the module is locked.
_LOCKS = (Act.LOCK, Act.SHUTDOWN)


class Where(NamedTuple):
    """On which connection, and by what its module is known. `adapter`: its USB identity."""

    port: str
    origin: str
    adapter: str = ""
    known_as: KnownAs = UNNAMED

    def left_active(self, at: str) -> LeftActive:
        """What this connection leaves ACTIVE. `at`: ISO 8601 in UTC."""
        return LeftActive(self.known_as, self.port, self.adapter, at)


def new_run() -> str:
    """Names one conversation: a module without a name is not known beyond it."""
    return os.urandom(4).hex()


def begin(facts: Facts, act: Act, frame: bytes, detail: Mapping[str, object], where: Where) -> str:
    """The intent; its id. A note in the detail is a field of its own.

    From now on the module counts as left ACTIVE, or as one that may have fired, if the act may leave that behind."""
    plain = _plain(detail)
    intent = (DeployIntended if act is Act.DEPLOY else ActIntended)(
        act=act.value,
        port=clean(where.port),
        frame=frame.hex(" "),
        origin=where.origin,
        adapter=clean(where.adapter),
        run=where.known_as.run,
        note=plain.pop(NOTE, ""),
        detail=plain,
    )
    row = facts.add(intent, where.known_as.name or None)
    if act is Act.DEPLOY and not where.known_as.name:
        note_unnamed(facts, port=where.port, adapter=where.adapter, intent=row.id)
    if act in _LEAVES_ACTIVE and not is_simulated(where.port):
        left = where.left_active(row.made_at)
        keep_left(facts, left._replace(is_lock_unconfirmed=act is Act.LOCK), intent=row.id)
    return row.id


def settle(facts: Facts, intent: str, act: Act, where: Where, outcome: Outcome, result: Mapping[str, object]) -> None:
    """What came of an intent; to be called once."""
    facts.add(ActEnded(of=intent, outcome=outcome.value, result=_plain(result)), where.known_as.name or None)
    has_done_nothing = outcome is Outcome.NOT_SENT or (act is Act.ACTIVATE and outcome is Outcome.REFUSED)
    if act in _LOCKS and outcome is Outcome.CONFIRMED:
        note_locked(facts, where.known_as.run)
    elif act in _LEAVES_ACTIVE and has_done_nothing:
        drop_intent(facts, where.known_as.run, intent)
    elif act is Act.DEPLOY and outcome is Outcome.NOT_SENT:
        forget_unnamed(facts, port=where.port, adapter=where.adapter, intent=intent)


def note_report(facts: Facts, where: Where, *, is_active: bool) -> None:
    """What the module reports, when that changes, when it gets a name, and at the end of its conversation."""
    if is_simulated(where.port):
        return
    if is_active:
        keep_left(facts, where.left_active(time_text(facts.now())))
    else:
        note_locked(facts, where.known_as.run)


def note_said_safe(facts: Facts, left: LeftActive, origin: str) -> None:
    """A person says that it is locked, or switched off. Nothing was sent: that stands in the log without a frame."""
    where = Where(left.port, origin, left.adapter, left.known_as)
    intent = begin(facts, Act.LOCK, b"", {"reported_by": "person"}, where)
    settle(facts, intent, Act.LOCK, where, Outcome.CONFIRMED, {"sent": 0})
    note_safe(facts, left)


class StoreJournal:
    """The journal of one conversation, or of one command, written by the store's own thread."""

    def __init__(
        self, store: Store, find_where: Callable[[], Where], *, on_trouble: Callable[[UserMessage], object] = bool
    ) -> None:
        """Both are called in the store's thread: `find_where`, as an adapter may take seconds to be found, and
        `on_trouble` with the reason why an entry could not be written."""
        self._store = store
        self._find_where = find_where
        self._on_trouble = on_trouble
        # The acts without an outcome.
        self._acts: dict[Entry, Act] = {}

    @property
    def is_ready(self) -> bool:
        return True

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        given = dict(detail)
        entry = self._store.write(lambda facts: begin(facts, act, frame, given, self._find_where()))
        self._acts[entry] = act
        entry.add_done_callback(self._tell)
        return entry

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        """Behind its entry: the queue keeps the order. An intent that was not written has no outcome to write."""
        kept = dict(result)
        act = self._acts.pop(entry, None)
        if act is None:
            return

        def write(facts: Facts) -> None:
            if not entry.cancelled() and entry.exception() is None:
                settle(facts, entry.result(), act, self._find_where(), outcome, kept)

        self._store.write(write).add_done_callback(self._tell)

    def _tell(self, written: "Future[str] | Future[None]") -> None:
        error = None if written.cancelled() else written.exception()
        if isinstance(error, StoreTrouble):
            _log.warning("The audit log cannot be written: %s", error)
            self._on_trouble(error.message)


def _plain(values: Mapping[str, object]) -> dict[str, Any]:
    """As it may stand in a fact: texts are bounded."""
    return {name: clean(value) if isinstance(value, str) else value for name, value in values.items()}
