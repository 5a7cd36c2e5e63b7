"""What an earlier run left ACTIVE: every command that opens a port says it, and a `lock` that is confirmed ends it."""

import argparse
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from app.engine.target import is_simulated
from app.system.folders import data_folder
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, join_sentences
from app.text.user_error import UserError

if TYPE_CHECKING:
    from app.store.left_active import LeftActive
    from app.store.store import Store
    from app.terminal.command_journal import Records
    from app.terminal.connection import Conversation

READ_LIMIT_S = 1.0
Result = TypeVar("Result")


def say_left_active(ports: Sequence[str], module: str) -> None:
    """Before anything is sent."""
    real = [port for port in ports if not is_simulated(port)]
    if not real or not data_folder().exists():  # nothing of the store is loaded where there is none
        return
    from app.store.database import StoreTrouble
    from app.terminal.command_journal import existing_store

    store = existing_store()
    if store is None:
        return
    try:
        with closing(store):
            entries = dict.fromkeys(left for port in real for left in left_here(store, port, module))
    except StoreTrouble as error:
        notify(error.sentence)
        return
    for left in entries:
        notify(left.sentence)


def left_here(store: "Store", port: str, module: str) -> tuple["LeftActive", ...]:
    """What was left ACTIVE under this name or, where it or the module has none, on this adapter. Raises
    `StoreTrouble`."""
    from app.store.left_active import left_active
    from app.terminal.command_journal import adapter_of

    entries, name = left_active(store), clean(module.strip())
    adapter = adapter_of(port) if any(left.adapter for left in entries) else ""

    def is_here(left: "LeftActive") -> bool:
        if name and left.known_as.name:
            return left.known_as.name == name
        return left.adapter == adapter if left.adapter and adapter else left.port == port

    return tuple(filter(is_here, entries))


def say_left_by_others(records: "Records", args: argparse.Namespace) -> None:
    """After LOCK; waits for the store for a limited time."""
    left = () if is_simulated(args.port) else _left_by_others(records, args)
    for one in left:
        notify(one.sentence)
    if left and not args.same_module:
        note(tr("If it is this module, add {option}.", option="--same-module"))


def end_left_active(conversation: "Conversation", records: "Records", args: argparse.Namespace) -> None:
    """The module reports LOCKED, and a person says by --module or --same-module which one it is. A name does not say
    that it is also the one without a name that was left here."""
    from app.store.left_active import note_locked
    from app.terminal.command_journal import ORIGIN

    store, name = records.store, clean((args.module or "").strip())
    if store is None or not (args.same_module or name):
        return
    left = _left_by_others(records, args)
    if left and (args.same_module or _is_it(conversation, records, name)):
        for one in left:
            if args.same_module or one.known_as.name == name:
                store.queue.submit(partial(note_locked, store, one, ORIGIN))


def _left_by_others(records: "Records", args: argparse.Namespace) -> tuple["LeftActive", ...]:
    """What this run left is said by itself."""

    def read(store: "Store") -> tuple["LeftActive", ...]:
        left = left_here(store, args.port, clean((args.module or "").strip()))
        return tuple(one for one in left if one.known_as.run != records.run)

    return _in_time(records, read) or ()


def _is_it(conversation: "Conversation", records: "Records", name: str) -> bool:
    """Whether nothing speaks against the name; what does is said."""
    from app.terminal.connection import LinkTrouble
    from app.terminal.stored_history import evidence_of, refuted

    known = _in_time(records, lambda store: evidence_of(store, name))
    against: list[str] | None = None
    with LinkTrouble():
        against = refuted(conversation, known)
    if against:
        other = tr("This may be another module: {differences}.", differences=join_names(against))
        notify(join_sentences((other, tr("If it is this module, add {option}.", option="--same-module"))))
    return against == []


def _in_time(records: "Records", read: Callable[["Store"], Result]) -> Result | None:
    """None where the store is in trouble, which is said at the end, or too slow."""
    store = records.store
    if store is None:
        return None
    try:
        return store.queue.submit(partial(read, store)).result(READ_LIMIT_S)
    except TimeoutError:
        return None
    except UserError as error:
        records.troubles.append(error.message)
        return None
