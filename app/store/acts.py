"""Acts in the store: the audit log, what fired, and the streams that this program switched on.

Whether it fired is for nobody here to say. A deploy may be unconfirmed, and a module whose voltage breaks down while it
fires restarts and reports nothing of it. So what left the computer counts, and what was seen once stays seen.

A deploy is in the facts as an act: its intent was durable before the frame left. A report is a fact of its own. For a
module without a name either is remembered with the port, and becomes a fact of the next name that is said there.

An intent whose end nobody saw reads as unknown. What an act leaves behind is in `state`: see `app.safety.left_active`
and what fired, here.

The intent is on the disk before the module is told, and stands until the module has confirmed "off". A stream that was
left on is not "as found": the next conversation switches it off.

An adapter does not tell which module is behind it. So only a module on the same start, by its boot count, is the one
that was switched on; of any other one that streams it is "as found". Where the boot count was not known, the adapter
has to do.
"""

import logging
import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from typing import Any, Final, NamedTuple

from msgspec.structs import replace

from app.engine.target import is_simulated
from app.safety.journal import NOTE, Act, Entry, Outcome
from app.safety.left_active import KnownAs, LeftActive, drop_intent, keep_left, note_locked, note_safe
from app.store.fact_store import Facts, Store
from app.store.opening import StoreTrouble
from app.store.rows import ActEnded, ActIntended, DeployIntended, MayHaveFired, time_text
from app.text.messages import UserMessage, clean

# Key of a state: a module without a name may have fired at this adapter or port.
_UNNAMED: Final = "fired:{place}"


class Fired(NamedTuple):
    """`at`: ISO 8601 in UTC. What a simulated module does says nothing of a real one."""

    at: str
    is_simulated: bool


def has_fired_since(at: str, fired: Iterable[Fired], *, simulated: bool) -> bool:
    """`at`: of a check, in UTC; `simulated`: whether that was of a simulated module."""
    return any(one.at > at and one.is_simulated is simulated for one in fired)


def all_fired(facts: Facts, module: str) -> list[Fired]:
    """Of the module of this name, the oldest first."""
    seen = facts.of_module(MayHaveFired, module)
    fired = [Fired(kept.content.seen_at or kept.at, is_simulated(kept.content.port)) for kept in seen]
    deploys = facts.of_module(DeployIntended, module)
    if deploys:
        ends = {kept.content.of: kept.content.outcome for kept in facts.of_module(ActEnded, module)}
        # Without an outcome nobody knows what came of it, so that it counts.
        left = [kept for kept in deploys if ends.get(kept.row.id) != Outcome.NOT_SENT.value]
        fired += [Fired(kept.at, is_simulated(kept.content.port)) for kept in left]
    return sorted(fired)


def note_triggered(facts: Facts, module: str, *, port: str, adapter: str = "") -> None:
    """The module reports TRIGGERED."""
    if module:
        facts.add(MayHaveFired(port=clean(port)), module)
    else:
        note_unnamed(facts, port=port, adapter=adapter)


def note_unnamed(facts: Facts, *, port: str, adapter: str = "", intent: str = "") -> None:
    """A module without a name may have fired here. The first time counts. `intent`: of the act that may make it so."""
    key = _UNNAMED.format(place=adapter or port)
    if facts.state(key) is None:
        facts.set_state(key, {"port": port, "at": time_text(facts.now()), "intent": intent})


def forget_unnamed(facts: Facts, *, port: str, adapter: str, intent: str) -> None:
    """This act was not sent after all. What another one or a report left behind stays."""
    key = _UNNAMED.format(place=adapter or port)
    if (facts.state(key) or {}).get("intent") == intent:
        facts.set_state(key, None)


def unnamed_fired(facts: Facts, *, port: str, adapter: str = "") -> list[Fired]:
    """What may have fired at this port without a name: of the next one that is named there."""
    noted = filter(None, map(facts.state, _keys(port, adapter)))
    return [Fired(one["at"], is_simulated(one["port"])) for one in noted]


def claim_fired(facts: Facts, module: str, *, port: str, adapter: str = "") -> None:
    """A person says this name at a port: what fired there without a name was this module."""
    for key in _keys(port, adapter):
        noted = facts.state(key)
        if noted is not None:
            facts.add(MayHaveFired(port=clean(noted["port"]), seen_at=noted["at"]), module)
            facts.set_state(key, None)


def _keys(port: str, adapter: str) -> list[str]:
    return [_UNNAMED.format(place=place) for place in dict.fromkeys((adapter, port)) if place]


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
        known_as = self.known_as
        return LeftActive(run=known_as.run, module=known_as.name, port=self.port, adapter=self.adapter, at=at)


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
        keep_left(facts, replace(left, is_lock_unconfirmed=act is Act.LOCK, intent=row.id))
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
    where = Where(left.port, origin, left.adapter, KnownAs(left.module, left.run))
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


class StreamMemory:
    """Of one port, by adapter, or by port where there is none; it outlives conversations. Without a store it forgets
    with the program."""

    def __init__(self, store: Store | None = None, adapter: str = "") -> None:
        self._store = store
        self._key = f"stream:{adapter}"
        # What was left on, as it was kept, until something is noted. It may come late, as no port waits for the store.
        self._left_on: Future[Any] = _done(None) if store is None else store.write(lambda facts: facts.state(self._key))
        self.is_taken_over = False

    @property
    def was_left_on(self) -> bool:
        """An earlier conversation did not switch it off."""
        return self._state is not None

    @property
    def boot_count(self) -> int | None:
        """On which start of the module; None: not known."""
        return None if self._state is None else self._state["boot_count"]

    @property
    def _state(self) -> Mapping[str, Any] | None:
        kept = self._left_on
        is_known = kept.done() and not kept.cancelled() and kept.exception() is None
        found: Mapping[str, Any] | None = kept.result() if is_known else None
        return found

    def take_over(self) -> None:
        """It streams, and this conversation switches it off; else the next one does."""
        self.is_taken_over = True

    def note_on(self, boot_count: int | None) -> "Future[None]":
        """Done when it is on the disk, or cannot be."""
        return self._keep({"boot_count": boot_count})

    def clear(self) -> None:
        """The module has confirmed that it is off, or does not stream."""
        self._keep(None)

    def _keep(self, state: Mapping[str, Any] | None) -> "Future[None]":
        self._left_on = _done(state)
        if self._store is None:
            return _done(None)
        kept: Future[None] = Future()

        def end(written: "Future[None]") -> None:
            error = None if written.cancelled() else written.exception()
            if error is not None:
                _log.warning("That a stream is switched on or off cannot be kept: %s", error)
            kept.set_result(None)

        self._store.set_state(self._key, state).add_done_callback(end)
        return kept


def _done(result: Any) -> "Future[Any]":
    future: Future[Any] = Future()
    future.set_result(result)
    return future
