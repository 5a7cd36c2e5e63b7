"""The audit log: the intent of each act, durable before its frame leaves, and what came of it.

An intent whose end nobody saw reads as unknown. What an act leaves behind is in `state`: see `app.safety.left_active`.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from app.engine.target import is_simulated
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.left_active import KnownAs, LeftActive, drop_intent, keep_left, note_locked, note_safe
from app.store.fact_store import Facts, Kept
from app.store.kinds import ActEnded, ActIntended, DeployIntended
from app.store.rows import time_text
from app.text.messages import clean

_LEAVES_ACTIVE = (Act.ACTIVATE, Act.LOCK)
# After these, confirmed, the module is locked.
_LOCKS = (Act.LOCK, Act.SHUTDOWN)


class Where(NamedTuple):
    """On which connection, and by what its module is known."""

    port: str
    origin: str
    adapter: str = ""
    known_as: KnownAs = KnownAs()


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
    module: str = ""
    adapter: str = ""
    origin: str = ""


def begin(facts: Facts, act: Act, frame: bytes, detail: Mapping[str, object], where: Where) -> str:
    """The intent; its id. From now on the module counts as left ACTIVE, if that is what the act may leave behind."""
    intent = (DeployIntended if act is Act.DEPLOY else ActIntended)(
        act=act.value,
        port=clean(where.port),
        frame=frame.hex(" "),
        origin=where.origin,
        adapter=clean(where.adapter),
        run=where.known_as.run,
        detail=plain(detail),
    )
    row = facts.add(intent, where.known_as.name or None)
    if act in _LEAVES_ACTIVE and not is_simulated(where.port):
        left = left_at(where, row.made_at)
        keep_left(facts, left._replace(is_lock_unconfirmed=act is Act.LOCK), intent=row.id)
    return row.id


def settle(facts: Facts, intent: str, act: Act, where: Where, outcome: Outcome, result: Mapping[str, object]) -> None:
    """What came of an intent; to be called once."""
    facts.add(ActEnded(of=intent, outcome=outcome.value, result=plain(result)), where.known_as.name or None)
    has_done_nothing = outcome is Outcome.NOT_SENT or (act is Act.ACTIVATE and outcome is Outcome.REFUSED)
    if act in _LOCKS and outcome is Outcome.CONFIRMED:
        note_locked(facts, where.known_as.run)
    elif act in _LEAVES_ACTIVE and has_done_nothing:
        drop_intent(facts, where.known_as.run, intent)


def left_at(where: Where, at: str) -> LeftActive:
    """What this connection leaves ACTIVE. `at`: ISO 8601 in UTC."""
    return LeftActive(where.known_as, where.port, where.adapter, at)


def note_report(facts: Facts, where: Where, *, is_active: bool) -> None:
    """What the module reports, when that changes, when it gets a name, and at the end of its conversation."""
    if is_simulated(where.port):
        return
    if is_active:
        keep_left(facts, left_at(where, time_text(facts.now())))
    else:
        note_locked(facts, where.known_as.run)


def note_said_safe(facts: Facts, left: LeftActive, origin: str) -> None:
    """A person says that it is locked, or switched off. Nothing was sent: that stands in the log without a frame."""
    where = Where(left.port, origin, left.adapter, left.known_as)
    intent = begin(facts, Act.LOCK, b"", {"reported_by": "person"}, where)
    settle(facts, intent, Act.LOCK, where, Outcome.CONFIRMED, {"sent": 0})
    note_safe(facts, left)


def audit(facts: Facts, *acts: Act) -> tuple[AuditEntry, ...]:
    """The newest first; of these acts, or of all."""
    ends = {kept.content.of: kept.content for kept in facts.of_kind(ActEnded)}
    intents: list[Kept[ActIntended]] = [*facts.of_kind(ActIntended)]
    intents += [Kept(kept.row, kept.content) for kept in facts.of_kind(DeployIntended)]
    entries: list[AuditEntry] = []
    for row, intent in sorted(intents, key=lambda kept: kept.row.made_at, reverse=True):
        if acts and Act(intent.act) not in acts:
            continue
        end = ends.get(row.id)
        entries.append(
            AuditEntry(
                id=row.id,
                port=intent.port,
                at=row.made_at,
                act=Act(intent.act),
                frame=bytes.fromhex(intent.frame),
                detail=intent.detail,
                outcome=Outcome.UNKNOWN if end is None else Outcome(end.outcome),
                result={} if end is None else end.result,
                module=row.module or "",
                adapter=intent.adapter,
                origin=intent.origin,
            )
        )
    return tuple(entries)


def plain(values: Mapping[str, object]) -> dict[str, Any]:
    """As it may stand in a fact: texts are bounded."""
    return {name: clean(value) if isinstance(value, str) else value for name, value in values.items()}
