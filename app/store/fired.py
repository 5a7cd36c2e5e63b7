"""A deploy that left, and a TRIGGERED that was seen: after either no earlier verdict of the module holds.

Whether it fired is for nobody here to say. A deploy may be unconfirmed, and a module whose voltage breaks down while it
fires restarts and reports nothing of it. So what left the computer counts, and what was seen once stays seen.

A deploy is in the facts as an act: its intent was durable before the frame left. A report is a fact of its own. For a
module without a name either is remembered with the port, and becomes a fact of the next name that is said there.
"""

from collections.abc import Iterable
from typing import Final, NamedTuple

from app.engine.target import is_simulated
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.facts import FactKind, Facts

_UNNAMED: Final = "fired:{place}"
"""Key of a state: a module without a name may have fired at this adapter or port."""


class Fired(NamedTuple):
    """`at`: ISO 8601 in UTC. What a simulated module does says nothing of a real one."""

    at: str
    is_simulated: bool


def has_fired_since(at: str, fired: Iterable[Fired], *, simulated: bool) -> bool:
    """`at`: of a check, in UTC; `simulated`: whether that was of a simulated module."""
    return any(one.at > at and one.is_simulated is simulated for one in fired)


def all_fired(facts: Facts, module: str) -> list[Fired]:
    """Of the module of this name, the oldest first. Raises `StoreTrouble`."""
    seen = facts.select(FactKind.FIRED, "AND module = ? ORDER BY number", (module,))
    fired = [Fired(fact.at, is_simulated(str(fact.content.get("port")))) for fact in seen]
    # Without an outcome nobody knows what came of it, so that it counts.
    left = (
        "AND module = ? AND link = ? AND NOT EXISTS (SELECT 1 FROM facts o WHERE o.link = facts.hash AND o.kind = ? "
        "AND json_extract(o.payload, '$.outcome') = ?) ORDER BY number"
    )
    values = (module, Act.DEPLOY.value, FactKind.OUTCOME.value, Outcome.NOT_SENT.value)
    deploys = facts.select(FactKind.ACT, left, values)
    fired += [Fired(fact.at, is_simulated(str(fact.content.get("port")))) for fact in deploys]
    return sorted(fired)


def note_triggered(facts: Facts, module: str, *, port: str, adapter: str = "") -> None:
    """The module reports TRIGGERED. Raises `StoreTrouble`."""
    if module:
        facts.add(FactKind.FIRED, {"port": port}, module=module)
    else:
        note_unnamed(facts, port=port, adapter=adapter)


def note_unnamed(facts: Facts, *, port: str, adapter: str = "") -> bool:
    """A module without a name may have fired here. Whether that is news. Raises `StoreTrouble`."""
    key = _UNNAMED.format(place=adapter or port)
    if facts.state(key) is not None:
        return False
    facts.set_state(key, {"port": port, "at": facts.database.now()})
    return True


def forget_unnamed(facts: Facts, *, port: str, adapter: str = "") -> None:
    """What was noted was not sent after all. Raises `StoreTrouble`."""
    facts.set_state(_UNNAMED.format(place=adapter or port), None)


def unnamed_fired(facts: Facts, *, port: str, adapter: str = "") -> list[Fired]:
    """What may have fired at this port without a name: of the next one that is named there. Raises `StoreTrouble`."""
    noted = filter(None, map(facts.state, _keys(port, adapter)))
    return [Fired(str(one.get("at")), is_simulated(str(one.get("port")))) for one in noted]


def claim_fired(facts: Facts, module: str, *, port: str, adapter: str = "") -> None:
    """A person says this name at a port: what fired there without a name was this module. Raises `StoreTrouble`."""
    keys = _keys(port, adapter)
    if not any(facts.state(key) for key in keys):
        return  # nobody waits for a file that somebody else writes
    with facts.database.transaction():
        for key in keys:
            noted = facts.state(key)
            if noted is not None:
                facts.add(FactKind.FIRED, {"port": str(noted.get("port")), "seen_at": noted.get("at")}, module=module)
                facts.set_state(key, None)


def _keys(port: str, adapter: str) -> list[str]:
    return [_UNNAMED.format(place=place) for place in dict.fromkeys((adapter, port)) if place]
