"""What an earlier run left ACTIVE: every command that opens a port says it, and a `lock` that is confirmed ends it."""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from app.engine.target import is_simulated
from app.system.folders import data_folder
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, join_sentences
from app.text.user_error import UserError

if TYPE_CHECKING:
    from app.store.fact_store import Facts
    from app.store.left_active import LeftActive
    from app.terminal.command_journal import Records
    from app.terminal.connection import Conversation

READ_LIMIT_S = 1.0
LEFT_LIMIT_S = 0.5
Result = TypeVar("Result")


def say_left_active(ports: Sequence[str], module: str) -> None:
    """Before anything is sent, where the disk answers within half a second; else nothing waits for it any longer."""
    real = [port for port in ports if not is_simulated(port)]
    if not real or not is_there(data_folder()):  # nothing of the store is loaded where there is none
        return
    from app.terminal.command_journal import existing_store

    store = existing_store()
    if store is None:
        return
    try:
        left = store.write(lambda facts: [one for port in real for one in left_here(facts, port, module)])
        entries = left.result(LEFT_LIMIT_S)
        notice = store.opened.result()  # said by whoever opens it first
        if notice is not None:
            notify(notice.translated())
        for one in dict.fromkeys(entries):
            notify(one.sentence)
    except TimeoutError:
        notify(tr("What was left ACTIVE is not known: the disk is too slow."))
    except UserError as error:
        notify(error.sentence)
    finally:
        store.close(0.0)


def is_there(folder: Path) -> bool:
    """A folder that may not be entered is there, and said where it is used."""
    try:
        return folder.exists()
    except OSError:
        return True


def left_here(facts: "Facts", port: str, module: str) -> tuple["LeftActive", ...]:
    """What was left ACTIVE under this name or, where it or the module has none, on this adapter."""
    from app.store.store_journal import left_active
    from app.terminal.command_journal import adapter_of

    entries, name = left_active(facts), clean(module.strip())
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
    from app.store.store_journal import note_locked
    from app.terminal.command_journal import ORIGIN

    name = clean((args.module or "").strip())
    if not (args.same_module or name):
        return
    left = _left_by_others(records, args)
    if left and (args.same_module or _is_it(conversation, records, name)):
        for one in left:
            if args.same_module or one.known_as.name == name:
                records.store.write(partial(note_locked, left=one, origin=ORIGIN))


def _left_by_others(records: "Records", args: argparse.Namespace) -> tuple["LeftActive", ...]:
    """What this run left is said by itself."""

    def read(facts: "Facts") -> tuple["LeftActive", ...]:
        left = left_here(facts, args.port, clean((args.module or "").strip()))
        return tuple(one for one in left if one.known_as.run != records.run)

    return _in_time(records, read) or ()


def _is_it(conversation: "Conversation", records: "Records", name: str) -> bool:
    """Whether nothing speaks against the name; what does is said."""
    from app.terminal.connection import LinkTrouble
    from app.terminal.stored_history import known_evidence, refuted

    known = _in_time(records, partial(known_evidence, name=name))
    against: list[str] | None = None
    with LinkTrouble():
        against = refuted(conversation, known)
    if against:
        other = tr("This may be another module: {differences}.", differences=join_names(against))
        notify(join_sentences((other, tr("If it is this module, add {option}.", option="--same-module"))))
    return against == []


def _in_time(records: "Records", read: Callable[["Facts"], Result]) -> Result | None:
    """None where the store is in trouble, which is said at the end, or too slow."""
    try:
        return records.store.write(read).result(READ_LIMIT_S)
    except (UserError, TimeoutError):
        return None
