"""Modules left ACTIVE: activated or not confirmed as locked, and not reported LOCKED since. Kept in `state`."""

from typing import Any, NamedTuple

from app.safety.last_known import keep_away
from app.store.fact_store import Facts
from app.store.former_active import LEFT
from app.system.wall_clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.sentences import join_sentences


class KnownAs(NamedTuple):
    """By what a module is known in the audit log: `name`, "" where it has none, and the `run`, its connection."""

    name: str = ""
    run: str = ""
    is_in_doubt: bool = False
    """It may be another module than the one of this connection."""


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


def keep_left(facts: Facts, id_: str, left: LeftActive) -> None:
    """In place of what was kept of this module, also from before it got its name."""
    _forget(facts, left.keys)
    state = {
        "module": left.known_as.name,
        "run": left.known_as.run,
        "port": left.port,
        "adapter": left.adapter,
        "at": left.at,
        "is_lock_unconfirmed": left.is_lock_unconfirmed,
    }
    facts.set_state(LEFT + id_, state)


def end_left(facts: Facts, locked: LeftActive) -> None:
    """The module reports LOCKED, or a person says so."""
    _forget(facts, locked.keys)


def kept_left(facts: Facts) -> list[LeftActive]:
    return [_left(state) for state in facts.states(LEFT).values()]


def _forget(facts: Facts, keys: tuple[tuple[str, ...], ...]) -> None:
    for id_, state in facts.states(LEFT).items():
        if _left(state).keys[0] in keys:
            facts.set_state(LEFT + id_, None)


def _left(state: dict[str, Any]) -> LeftActive:
    known_as = KnownAs(state["module"], state["run"])
    return LeftActive(known_as, state["port"], state["adapter"], state["at"], state["is_lock_unconfirmed"])
