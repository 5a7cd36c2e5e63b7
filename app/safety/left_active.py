"""Modules left ACTIVE, and such as may have fired before they restarted.

Left ACTIVE: ACTIVE at the end of a conversation, or LOCK not confirmed, and not known to be safe since.

One entry a conversation, kept in the store's state from the moment at which the frame may leave, so that a killed
program leaves it behind, too. The program itself does not show the entry of a conversation that goes on.

- It ends when the module reports LOCKED in that conversation.
- One with a name ends when a module reports LOCKED that a person named so afterwards.
- One without a name ends when a person says that the module is safe.
- Another module at the same port never ends it.
"""

import logging
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, Protocol

from msgspec import Struct, ValidationError, convert
from msgspec.structs import replace

from app.engine.conversation import ConversationView
from app.engine.target import is_simulated
from app.safety.last_known import keep_away
from app.system.clock import MINUTE, local_time
from app.text.i18n import tr
from app.text.messages import join_sentences
from protocol.catalogue import BOOTS
from protocol.events import EndReason

_log = logging.getLogger(__name__)

# The beginning of the keys in the store's state; the conversation follows.
LEFT = "left:"


class States(Protocol):
    """The store's state, within one write."""

    def states(self, prefix: str, /) -> Mapping[str, Any]:
        """The states whose keys begin with it, by the rest of the key."""
        ...

    def set_state(self, key: str, value: object, /) -> None: ...


class LeftActive(Struct, frozen=True, kw_only=True):
    """The state of one conversation, as it is kept. `run`: names the conversation. `at`: when, ISO 8601 in UTC."""

    run: str = ""
    module: str = ""
    port: str = ""
    adapter: str = ""
    at: str = ""
    is_lock_unconfirmed: bool = False  # LOCK was sent, and the module did not report LOCKED
    is_after_go: bool = False  # it was GO in that conversation: then to be unplugged ACTIVE is its normal end
    intent: str = ""  # the act of which it is the consequence, until it is known what came of it
    named_again_in: str = ""  # a person said the same name afterwards in this conversation

    @property
    def is_warning(self) -> bool:
        return self.is_lock_unconfirmed or not self.is_after_go

    @property
    def sentence(self) -> str:
        """The sentence in the language in use."""
        when = local_time(self.at, MINUTE)
        module = self.module or tr("The module at {port}", port=self.port)
        if self.is_lock_unconfirmed:
            text = tr("{module}: LOCK not confirmed on {time}.", module=module, time=when)
        else:
            text = tr("{module} was left ACTIVE on {time}.", module=module, time=when)
        return join_sentences((text, keep_away())) if self.is_warning else text


def all_left(states: States) -> tuple[LeftActive, ...]:
    """The last first; of a name only the last."""
    found: dict[str, LeftActive] = {}
    for left in sorted(_kept(states).values(), key=lambda left: left.at, reverse=True):
        found.setdefault(f"name {left.module}" if left.module else left.run, left)
    return tuple(found.values())


def keep_left(states: States, left: LeftActive) -> None:
    """It is ACTIVE, or may be, and nobody saw it locked. `left.intent`: the act that is about to make it so."""
    if is_simulated(left.port):
        return
    _log.debug("left ACTIVE: %s", left)
    before = _kept(states).get(left.run, left)
    left = replace(
        left,
        module=left.module or before.module,
        # A later report of ACTIVE does not say that an earlier LOCK was carried out.
        is_lock_unconfirmed=left.is_lock_unconfirmed or before.is_lock_unconfirmed,
        is_after_go=before.is_after_go,
        intent=before.intent,
    )
    states.set_state(LEFT + left.run, left)


def drop_intent(states: States, run: str, intent: str) -> None:
    """Nothing came of this act. What another act or a report left behind stays."""
    left = _kept(states).get(run)
    if left is not None and left.intent == intent:
        _forget(states, run)


def note_named(states: States, run: str, name: str) -> None:
    """A person says in the conversation `run` which module it is. From now on its report counts for what was left under
    that name before; not for what is left elsewhere later."""
    for other, left in _kept(states).items():
        if other == run:
            states.set_state(LEFT + other, replace(left, module=name))
        elif name and left.module == name:
            states.set_state(LEFT + other, replace(left, named_again_in=run))


def note_go(states: States, run: str) -> None:
    """The verdict is GO in this conversation."""
    left = _kept(states).get(run)
    if left is not None:
        states.set_state(LEFT + run, replace(left, is_after_go=True))


def note_locked(states: States, run: str) -> None:
    """The module of this conversation reports LOCKED, or a person says that it is."""
    for other, left in _kept(states).items():
        if run in (other, left.named_again_in):
            _forget(states, other)


def _kept(states: States) -> dict[str, LeftActive]:
    found = {}
    for run, kept in states.states(LEFT).items():
        with suppress(ValidationError):  # one that was altered hides no other, and keeps no act from its intent
            found[run] = replace(convert(kept, LeftActive), run=run)
    return found


def _forget(states: States, run: str) -> None:
    _log.debug("no longer left ACTIVE: %s", run)
    states.set_state(LEFT + run, None)


class FiringDoubt:
    """Whether the module of one port may have fired before it restarted: its voltage may break down while it fires.

    It reports NOT TRIGGERED after the restart then, and only its trigger records tell. So until they were read, and a
    person has closed the notice about it, "may have fired before the restart" stands in the place of NOT TRIGGERED, and
    no check comes to READY.
    """

    def __init__(self) -> None:
        self.needs_records = False  # they were not read since
        self.is_to_be_told = False  # no person has closed the notice about it
        # Of a module that may have fired in the silence that ended its conversation.
        self._boot_count_before: int | None = None

    @property
    def is_open(self) -> bool:
        return self.needs_records or self.is_to_be_told

    def note_ended(self, conversation: ConversationView, *, was_active: bool = False) -> None:
        """Take the end of a conversation; to be called once with each. `was_active`: it was ACTIVE a moment before, and
        was not locked from here: a module that restarted reports LOCKED before its boot count tells of the restart."""
        self._boot_count_before = None
        active = conversation.values.get("active")
        # An act of which nothing was reported may have made it active.
        may_fire = "tilt_deg" in conversation.values if active is None else active.value is True
        if conversation.ended is None or not (was_active or may_fire):
            return
        if conversation.ended.reason is EndReason.RESTARTED:
            self._raise()
        else:
            self._boot_count_before = conversation.boot_count

    def note_begun(self, conversation: ConversationView) -> None:
        """Take the beginning of a conversation; to be called once with each. One start more is this module again; after
        a silence without a restart it still reports itself that it has fired."""
        before, self._boot_count_before = self._boot_count_before, None
        if before is not None and conversation.boot_count == (before + 1) % BOOTS:
            self._raise()

    def _raise(self) -> None:
        _log.debug("the module may have fired before it restarted")
        self.needs_records = self.is_to_be_told = True
