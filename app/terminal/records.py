"""The store of a command: the audit log, what an earlier run left ACTIVE, and a person's word for the module.

The store opens beside the port, and no port waits for it. What was left ACTIVE under a name ends when a module that a
person names so reports LOCKED, by `lock --module`; what was left without a name when a person says that it is this
module, by `lock --same-module`.
"""

import argparse
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import cached_property, partial
from typing import Self, TypeVar

from app.engine.conversation import ConversationView
from app.engine.target import is_simulated
from app.modules.names import remembered, store_as_found, what_speaks_against
from app.safety.left_active import LeftActive, all_left, note_locked, note_named
from app.store.acts import StoreJournal, Where, note_said_safe
from app.store.fact_store import Facts, Store
from app.store.rows import Row
from app.terminal.connection import adapter_of
from app.terminal.console import Refused, note, notify, notify_once
from app.text.i18n import tr
from app.text.messages import ErrorCode, UserError, UserMessage, join_names, join_sentences
from protocol.fields import Value

ORIGIN = "command line"
READ_LIMIT_S = 1.0  # how long a command waits for what it asks of the store
Result = TypeVar("Result")


class CommandStore(Store):
    """The store of one command, with the audit log of its port. At the end it says what a person should know of it, and
    whether anything was not written. `module`: the name of the module; `run` names the conversation."""

    def __init__(self, port: str = "", module: str | None = None, *, starts_late: bool = False) -> None:
        super().__init__(starts_late=starts_late)
        self.port, self.module, self.run = port, module or "", os.urandom(4).hex()
        # Why entries of the audit log are missing.
        self._troubles: list[UserMessage] = []
        self.journal = StoreJournal(self, lambda: self.where, on_trouble=self._troubles.append)

    @cached_property
    def where(self) -> Where:
        # For the adapter's USB identity it may take seconds: the journal asks in the store's thread.
        return Where(self.port, ORIGIN, adapter_of(self.port), self.module, self.run)

    def renew(self) -> None:
        """Another conversation begins at the port, where another adapter may be by now."""
        self.run = os.urandom(4).hex()
        vars(self).pop("where", None)

    def keep_as_found(self, settings: Mapping[str, Value], boot_count: int | None) -> "Future[Row]":
        # The future ends when it is on disk or has failed; a failure does not prevent changing a setting.
        return self.write(partial(store_as_found, settings=settings, boot_count=boot_count, port=self.port))

    def ask(self, work: Callable[[Facts], Result]) -> Result | None:
        # None where the store is in trouble, which is said at the end, or too slow.
        try:
            return self.write(work).result(READ_LIMIT_S)
        except (UserError, TimeoutError):
            return None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.start()
        is_whole = self.close()
        say_notice(self)
        for trouble in self._troubles:
            notify_once(trouble.translated())
        if self._troubles or not is_whole:
            notify(tr("The audit log is incomplete."))


def say_notice(store: Store) -> None:
    """Say what a person should know of the store, or why there is none: once, however often a command opens it."""
    try:
        notice = store.opened.result(0.0)
    except UserError as error:
        notice = error.message
    except TimeoutError:
        return
    if notice is not None:
        notify_once(notice.translated())


def say_not_kept(trouble: UserError) -> None:
    # Why is said once, as it may be that there is no store, which is said of itself.
    notify_once(trouble.sentence)
    notify(tr("Not kept so far."))


# What an earlier run left ACTIVE


def say_left_active(ports: Sequence[str], module: str | None) -> None:
    """Before anything is sent, where the disk answers in time; else nothing waits for it any longer."""
    store = Store()
    try:
        left = store.write(lambda facts: [one for port in ports for one in _left_here(facts, port, module)])
        for one in left.result(READ_LIMIT_S):
            notify_once(one.sentence)  # several ports may have one adapter in common
    except TimeoutError:
        notify(tr("What was left ACTIVE is not known: the disk is too slow."))
    except UserError:
        pass  # it is said of the store
    finally:
        say_notice(store)
        store.close(0.0)


def conclude_lock(store: CommandStore, args: argparse.Namespace, locked: ConversationView | None) -> None:
    """End what was left ACTIVE by the module that was locked, as far as a person says which one it is, and say the
    rest. Waits for the store for a limited time. `locked` is the conversation in which it reported LOCKED, if one
    did."""
    if is_simulated(args.port):
        return

    def update(facts: Facts) -> tuple[str, list[LeftActive]]:
        against = ""
        if locked is not None and args.module:
            against = speaks_against(facts, args.module, locked)
            if args.same_module or not against:
                note_named(facts, store.run, args.module)
                note_locked(facts, store.run)
        if locked is not None and args.same_module:
            for one in _left_here(facts, args.port, args.module):
                if not one.module:
                    note_said_safe(facts, one, ORIGIN)
        # What this run left is said by itself.
        left = _left_here(facts, args.port, args.module)
        return against, [one for one in left if one.run != store.run]

    against, left = store.ask(update) or ("", [])
    add = tr("If it is this module, add {option}.", option="--same-module")
    if against and not args.same_module:
        notify(join_sentences((against, add)))
    for one in left:
        notify(one.sentence)
    if left and not args.same_module:
        note(add)


def _left_here(facts: Facts, port: str, module: str | None) -> list[LeftActive]:
    """Return what was left ACTIVE under this name or, where it or the module has none, on this adapter."""
    entries = all_left(facts)
    adapter = adapter_of(port) if any(left.adapter for left in entries) else ""

    def is_here(left: LeftActive) -> bool:
        if module and left.module:
            return left.module == module
        return left.adapter == adapter if left.adapter and adapter else left.port == port

    return [left for left in entries if is_here(left)]


# --module NAME: a person's word for this conversation


def refuse_another(conversation: ConversationView, store: CommandStore, args: argparse.Namespace) -> None:
    # Raises `Refused` where something speaks against the name, unless a person says --same-module. Of a store that
    # cannot be used nothing is known, so nothing speaks against it; why is said at the end.
    if args.module and not args.same_module:
        against = store.ask(lambda facts: speaks_against(facts, args.module, conversation))
        if against:
            raise unless_same_module(against)


def speaks_against(facts: Facts, name: str, conversation: ConversationView) -> str:
    """The sentence on what speaks against the name; "" where nothing does."""
    known = remembered(facts, name)
    against = () if known is None else what_speaks_against(known, conversation)
    return other_module(*against) if against else ""


def other_module(*against: UserMessage) -> str:
    differences = join_names(one.translated() for one in against)
    return tr("This may be another module: {differences}.", differences=differences)


def unless_same_module(against: str) -> Refused:
    add = tr("Nothing was done. Add {option} to do it.", option="--same-module")
    return Refused(join_sentences((against, add)), ErrorCode.REFUSED)
