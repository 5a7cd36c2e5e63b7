"""The audit log: the intent of each act, durable before its frame leaves, and what came of it; and what may have fired.

An intent whose end nobody saw reads as unknown. What an act leaves behind is in `state`: see `app.safety.left_active`.

After a deploy that left, and after a TRIGGERED that was seen, no earlier verdict of the module holds: a deploy may be
unconfirmed, and a module whose voltage breaks down while it fires restarts and reports nothing of it. Where the module
has no name, either is a fact about no module, until the next name that is said at that port claims it.
"""

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from datetime import datetime
from typing import Any, NamedTuple

from app.safety.journal import NOTE, Act, Entry, Journal, Outcome
from app.safety.left_active import LeftActive, drop_intent, keep_left, note_locked, note_named
from app.store.fact_store import Facts, Kept, Store, StoreError
from app.store.rows import ActEnded, ActIntended, DeployIntended, MayHaveFired, time_text
from app.text.messages import UserMessage, clean

_log = logging.getLogger(__name__)

_LEAVES_ACTIVE = (Act.ACTIVATE, Act.LOCK)


class Where(NamedTuple):
    """The connection of an act, and its module. `adapter` is its USB identity; `name`: as a person said it in this
    conversation, "" where nobody did; `run` names the conversation."""

    port: str
    origin: str
    adapter: str = ""
    name: str = ""
    run: str = ""

    def left_active(self, at: str, **more: Any) -> LeftActive:
        """Return what this connection leaves ACTIVE. `at` is ISO 8601 in UTC."""
        return LeftActive(run=self.run, module=self.name, port=self.port, adapter=self.adapter, at=at, **more)


class Intent(NamedTuple):
    """An intent that is kept. `id` is that of its fact."""

    id: str
    act: Act
    where: Where


def begin(facts: Facts, act: Act, frame: bytes, detail: Mapping[str, object], where: Where) -> Intent:
    """Add the intent. A note in the detail is a field of its own.

    From now on the module counts as left ACTIVE, if the act may leave that behind."""
    plain: dict[str, Any] = dict(detail)
    intent = (DeployIntended if act is Act.DEPLOY else ActIntended)(
        act=act.value,
        port=clean(where.port),
        frame=frame.hex(" "),
        origin=where.origin,
        adapter=clean(where.adapter),
        run=where.run,
        note=clean(plain.pop(NOTE, "")),
        detail=plain,
    )
    row = facts.add(intent, where.name or None)
    if act in _LEAVES_ACTIVE:
        keep_left(facts, where.left_active(row.made_at, is_lock_unconfirmed=act is Act.LOCK, intent=row.id))
    return Intent(row.id, act, where)


def settle(facts: Facts, intent: Intent, outcome: Outcome, result: Mapping[str, object]) -> None:
    """Add what came of an intent; to be called once."""
    id_, act, where = intent
    facts.add(ActEnded(of=id_, outcome=outcome, result=dict[str, Any](result)), where.name or None)
    has_done_nothing = outcome is Outcome.NOT_SENT or (act is Act.ACTIVATE and outcome is Outcome.REFUSED)
    if act in (Act.LOCK, Act.SHUTDOWN) and outcome is Outcome.CONFIRMED:
        note_locked(facts, where.run)
    elif act in _LEAVES_ACTIVE and has_done_nothing:
        drop_intent(facts, where.run, id_)


def note_report(facts: Facts, where: Where, *, is_active: bool) -> None:
    """Note what the module reports: when that changes, when it gets a name, and at the end of its conversation."""
    if is_active:
        keep_left(facts, where.left_active(time_text(facts.now())))
    else:
        note_locked(facts, where.run)


def note_said_safe(facts: Facts, left: LeftActive, origin: str) -> None:
    """A person says that it is locked, or switched off. Nothing was sent: that stands in the log without a frame."""
    where = Where(left.port, origin, left.adapter, left.module, left.run)
    note_named(facts, left.run, left.module)  # so that the word counts for all that was left under this name
    settle(facts, begin(facts, Act.LOCK, b"", {"reported_by": "person"}, where), Outcome.CONFIRMED, {"sent": 0})


class StoreJournal(Journal):
    """The journal of one conversation, or of one command, written by the store's own thread."""

    is_ready = True

    def __init__(
        self, store: Store, find_where: Callable[[], Where], *, on_trouble: Callable[[UserMessage], object] = bool
    ) -> None:
        """Both are called in the store's thread: `find_where`, as an adapter may take seconds to be found, and
        `on_trouble` with the reason why an entry could not be written."""
        self._store, self._find_where, self._on_trouble = store, find_where, on_trouble

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object]) -> Entry:
        given = dict(detail)
        return self._write(lambda facts: begin(facts, act, frame, given, self._find_where()))

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object]) -> None:
        """Write the outcome behind its entry: the queue keeps the order. An intent that was not written has none."""
        kept = dict(result)

        def write(facts: Facts) -> None:
            if not entry.cancelled() and entry.exception() is None:
                settle(facts, entry.result(), outcome, kept)

        self._write(write)

    def _write(self, work: Callable[[Facts], Any]) -> "Future[Any]":
        written = self._store.write(work)
        written.add_done_callback(self._tell)
        return written

    def _tell(self, written: "Future[Any]") -> None:
        error = None if written.cancelled() else written.exception()
        if isinstance(error, StoreError):
            _log.warning("The audit log cannot be written: %s", error)
            self._on_trouble(error.message)


# What may have fired


def all_fired(facts: Facts, module: str | None) -> list[Kept[Any]]:
    """Return when the module of this name (None: any without a name) may have fired, the oldest first: a TRIGGERED that
    was seen, and each deploy that left."""
    fired: list[Kept[Any]] = [*facts.of_module(MayHaveFired, module)]
    deploys = facts.of_module(DeployIntended, module)
    if deploys:
        ends = {kept.content.of: kept.content.outcome for kept in facts.of_module(ActEnded, module)}
        # Without an outcome nobody knows what came of it, so that it counts.
        fired += [kept for kept in deploys if ends.get(kept.row.id) is not Outcome.NOT_SENT]
    return sorted(fired, key=lambda kept: kept.at)


def note_triggered(facts: Facts, module: str = "", *, port: str, adapter: str = "") -> None:
    """The module reports TRIGGERED."""
    facts.add(MayHaveFired(port=clean(port), adapter=clean(adapter)), module or None)


def unnamed_fired(facts: Facts, *, port: str, adapter: str = "") -> list[Kept[Any]]:
    """Return what may have fired here without a name, and that no name has claimed: it is that of the next one that is
    said here. An adapter is known by its identity, where it has one, as its port may change."""
    claimed = {kept.at for kept in facts.of_kind(MayHaveFired) if kept.row.module is not None}
    here = []
    for fired in all_fired(facts, None):
        at = fired.content
        is_here = at.adapter == clean(adapter) if at.adapter and adapter else at.port == clean(port)
        if is_here and fired.at not in claimed:
            here.append(fired)
    return here


def claim_fired(facts: Facts, module: str, *, port: str, adapter: str = "") -> None:
    """A person says this name at a port: what fired there without a name was this module, at that time."""
    for fired in unnamed_fired(facts, port=port, adapter=adapter):
        what = MayHaveFired(port=clean(port), adapter=clean(adapter))
        facts.add(what, module, at=datetime.fromisoformat(fired.at))


# What is left streaming


class StreamMemory:
    """It remembers of one adapter, or of one port where there is none, whether the program left a module's serial
    output on.

    That is noted before the module is told, and stands until the module has confirmed "off": one that was left on is
    not "as found", and the next conversation switches it off. An adapter does not tell which module is behind it, so
    that its boot count has to be the same. Without a store it forgets with the program.
    """

    def __init__(self, store: Store | None = None, adapter: str = "") -> None:
        self._store, self._key = store, f"stream:{adapter}"
        # What was left on, until something is noted. It may come late, as no port waits for the store, or never.
        self._left_on: Future[Any] = Future() if store is None else store.write(lambda facts: facts.state(self._key))

    @property
    def left_on(self) -> dict[str, Any] | None:
        """The note of an earlier conversation that did not switch it off: `boot_count`, on which start of the module,
        where known."""
        kept = self._left_on
        is_known = kept.done() and not kept.cancelled() and kept.exception() is None
        return kept.result() if is_known else None

    def note_on(self, boot_count: int | None) -> None:
        """It is switched on now."""
        self._keep({"boot_count": boot_count})

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""
        self._keep(None)

    def _keep(self, state: dict[str, int | None] | None) -> None:
        self._left_on = Future()
        self._left_on.set_result(state)
        if self._store is not None:
            self._store.set_state(self._key, state)
