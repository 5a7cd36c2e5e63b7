"""What an earlier run left ACTIVE: every command that opens a port says it, and `lock` ends it.

What was left under a name ends when a module that a person names so reports LOCKED, by `lock --module`; what was left
without a name when a person says that it is this module, by `lock --same-module`.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from app.engine.target import is_simulated
from app.system.folders import data_folder
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import join_names, join_sentences
from app.text.user_error import UserError

if TYPE_CHECKING:
    from app.engine.conversation import ConversationView
    from app.safety.left_active import LeftActive
    from app.store.fact_store import Facts
    from app.terminal.command_journal import Records

LEFT_LIMIT_S = 0.5


def say_left_active(ports: Sequence[str], module: str) -> None:
    """Before anything is sent, where the disk answers within half a second; else nothing waits for it any longer."""
    real = [port for port in ports if not is_simulated(port)]
    if not real or not _is_there(data_folder()):  # nothing of the store is loaded where there is none
        return
    from app.terminal.command_journal import existing_store

    store = existing_store()
    if store is None:
        return
    try:
        left = store.write(lambda facts: [one for port in real for one in _left_here(facts, port, module)])
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


def conclude_lock(records: "Records", args: argparse.Namespace, locked: "ConversationView | None") -> None:
    """After LOCK: end what was left ACTIVE by this module, as far as a person says which one it is, and say the
    rest. Waits for the store for a limited time. `locked`: the conversation in which it reported LOCKED, if one did."""
    from app.modules.names import remembered, what_speaks_against
    from app.safety.left_active import KnownAs, note_named
    from app.store.acts import note_report, note_said_safe
    from app.terminal.command_journal import ORIGIN

    if is_simulated(args.port):
        return
    name = clean((args.module or "").strip())

    def update(facts: "Facts") -> "tuple[tuple[UserMessage, ...], list[LeftActive]]":
        against: tuple[UserMessage, ...] = ()
        if locked is not None and name:
            known = remembered(facts, name)
            against = () if known is None else what_speaks_against(known, locked)
            if args.same_module or not against:
                known_as = KnownAs(name, records.known_as.run)
                note_named(facts, known_as)
                note_report(facts, records.where()._replace(known_as=known_as), is_active=False)
        if locked is not None and args.same_module:
            for one in _left_here(facts, args.port, name):
                if not one.known_as.name:
                    note_said_safe(facts, one, ORIGIN)
        # What this run left is said by itself.
        own = records.known_as.run
        return against, [one for one in _left_here(facts, args.port, name) if one.known_as.run != own]

    found = records.ask(update)
    if found is None:
        return
    against, left = found
    add = tr("If it is this module, add {option}.", option="--same-module")
    if against and not args.same_module:
        other = tr("This may be another module: {differences}.", differences=join_names(_texts(against)))
        notify(join_sentences((other, add)))
    for one in left:
        notify(one.sentence)
    if left and not args.same_module:
        note(add)


def _left_here(facts: "Facts", port: str, module: str) -> tuple["LeftActive", ...]:
    """What was left ACTIVE under this name or, where it or the module has none, on this adapter."""
    from app.safety.left_active import all_left
    from app.terminal.command_journal import adapter_of

    entries, name = all_left(facts), clean(module.strip())
    adapter = adapter_of(port) if any(left.adapter for left in entries) else ""

    def is_here(left: "LeftActive") -> bool:
        if name and left.known_as.name:
            return left.known_as.name == name
        return left.adapter == adapter if left.adapter and adapter else left.port == port

    return tuple(filter(is_here, entries))


def _texts(messages: Sequence[UserMessage]) -> list[str]:
    return [message.translated() for message in messages]


def _is_there(folder: Path) -> bool:
    """A folder that may not be entered is there, and said where it is used."""
    try:
        return folder.exists()
    except OSError:
        return True
