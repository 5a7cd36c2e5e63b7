"""A deploy that left, and a TRIGGERED that was seen: after either no earlier verdict of the module holds.

Whether it fired is for nobody here to say. A deploy may be unconfirmed, and a module whose voltage breaks down while it
fires restarts and reports nothing of it. So what left the computer counts, and what was seen once stays seen.

A deploy is in the facts as an act: its intent was durable before the frame left. A report is a fact of its own. For a
module without a name either is remembered with the port, and becomes a fact of the next name that is said there.
"""

from collections.abc import Iterable
from typing import Final, NamedTuple

from app.engine.target import is_simulated
from app.safety.journal import Outcome
from app.store.fact_store import Facts
from app.store.kinds import ActEnded, DeployIntended, MayHaveFired
from app.store.rows import time_text
from app.text.messages import clean

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
