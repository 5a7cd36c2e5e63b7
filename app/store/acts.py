"""The audit log: the intent of each act, durable before its frame leaves, and what came of it.

An intent whose end nobody saw reads as unknown. So that nobody reads the whole log for them, intents without an end are
in `state`, too, and so is what they leave behind: see `app.store.left_active`.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from app.engine.target import is_simulated
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.fact_store import Facts, Kept
from app.store.kinds import ActEnded, ActIntended, DeployIntended
from app.store.left_active import KnownAs, LeftActive, end_left, keep_left
from app.text.messages import clean

OPEN = "open:"
"""Beginning of the keys of intents without an end."""
_LEAVES_ACTIVE = {
    Act.ACTIVATE: (Outcome.CONFIRMED, Outcome.UNKNOWN),
    Act.LOCK: (Outcome.REFUSED, Outcome.UNKNOWN),
}
_SAYS_LOCKED = (Act.LOCK, Act.SHUTDOWN)


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
    """The intent; its id."""
    known_as = where.known_as
    intent = (DeployIntended if act is Act.DEPLOY else ActIntended)(
        act=act.value,
        port=clean(where.port),
        frame=frame.hex(" "),
        origin=where.origin,
        adapter=clean(where.adapter),
        run=known_as.run,
        is_in_doubt=known_as.is_in_doubt,
        detail=plain(detail),
    )
    row = facts.add(intent, known_as.name or None)
    state = {
        "act": act.value,
        "at": row.made_at,
        "port": where.port,
        "adapter": where.adapter,
        "module": known_as.name,
        "run": known_as.run,
        "is_in_doubt": known_as.is_in_doubt,
        "detail": intent.detail,
    }
    facts.set_state(OPEN + row.id, state)
    return row.id


def settle(facts: Facts, intent: str, outcome: Outcome, result: Mapping[str, object]) -> None:
    """What came of an intent, once."""
    state = facts.state(OPEN + intent)
    if state is None:
        return
    facts.add(ActEnded(of=intent, outcome=outcome.value, result=plain(result)), state["module"] or None)
    facts.set_state(OPEN + intent, None)
    act, left = Act(state["act"]), _left(state)
    if is_simulated(left.port):
        return
    if outcome in _LEAVES_ACTIVE.get(act, ()):
        keep_left(facts, intent, left)
    elif act in _SAYS_LOCKED and outcome is Outcome.CONFIRMED and not left.known_as.is_in_doubt:
        end_left(facts, left)
        for id_, other in open_intents(facts, *_LEAVES_ACTIVE).items():
            if other.at < left.at and set(other.keys) & set(left.keys):
                facts.set_state(OPEN + id_, None)  # the end of it was never seen, and it no longer matters


def open_intents(facts: Facts, *acts: Act) -> dict[str, LeftActive]:
    """By id, those that leave a module ACTIVE as far as anybody knows."""
    states = facts.states(OPEN)
    found = {id_: _left(state) for id_, state in states.items() if Act(state["act"]) in acts}
    return {id_: left for id_, left in found.items() if not is_simulated(left.port)}


def audit(facts: Facts, *acts: Act) -> tuple[AuditEntry, ...]:
    """The newest first; of these acts, or of all."""
    ends = {kept.content.of: kept.content for kept in facts.of_kind(ActEnded)}
    entries = []
    intents: list[Kept[ActIntended]] = [*facts.of_kind(ActIntended)]
    intents += [Kept(kept.row, kept.content) for kept in facts.of_kind(DeployIntended)]
    for row, intent in sorted(intents, key=lambda kept: kept.row.made_at, reverse=True):
        if acts and Act(intent.act) not in acts:
            continue
        end = ends.get(row.id)
        outcome = Outcome.UNKNOWN if end is None else Outcome(end.outcome)
        entries.append(
            AuditEntry(
                row.id,
                intent.port,
                row.made_at,
                Act(intent.act),
                bytes.fromhex(intent.frame),
                intent.detail,
                outcome,
                {} if end is None else end.result,
                row.module or "",
                intent.adapter,
                intent.origin,
            )
        )
    return tuple(entries)


def plain(values: Mapping[str, object]) -> dict[str, Any]:
    """As it may stand in a fact: texts are bounded."""
    return {name: clean(value) if isinstance(value, str) else value for name, value in values.items()}


def _left(state: Mapping[str, Any]) -> LeftActive:
    known_as = KnownAs(state["module"], state["run"], is_in_doubt=state["is_in_doubt"])
    is_lock = state["act"] == Act.LOCK.value
    return LeftActive(known_as, state["port"], state["adapter"], state["at"], is_lock_unconfirmed=is_lock)
