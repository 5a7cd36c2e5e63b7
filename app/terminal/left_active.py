"""What an earlier run left ACTIVE: every command that opens a port says it, and a `lock` that is confirmed ends it."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from typing import TYPE_CHECKING

from app.engine.target import is_simulated
from app.system.folders import data_folder
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, join_sentences

if TYPE_CHECKING:
    from app.store.left_active import LeftActive
    from app.store.store import Store
    from app.terminal.connection import Conversation


@contextmanager
def notify_left_active(ports: Sequence[str], module: str, *, is_locking: bool) -> Iterator[str]:
    """Says it before anything is sent; LOCK waits for nothing, so that it is said behind what is `is_locking`, whose
    own entries have the run that this yields, "" for others."""
    ports = [port for port in ports if not is_simulated(port)]
    run = ""
    if ports and is_locking:
        from app.store.store_journal import new_run

        run = new_run()
    elif ports:
        _say(ports, module)
    try:
        yield run
    finally:
        if ports and is_locking and _say(ports, module, but_run=run):
            note(tr("If it is this module, add {option}.", option="--same-module"))


def _say(ports: Sequence[str], module: str, *, but_run: str | None = None) -> bool:
    """What was left, but by this run, which says its own. Whether there is any."""
    if not data_folder().exists():  # nothing of the store is loaded where there is none
        return False
    from app.store.database import StoreTrouble
    from app.terminal.command_journal import existing_store

    store = existing_store()
    if store is None:
        return False
    try:
        with closing(store):
            entries = dict.fromkeys(left for port in ports for left in left_here(store, port, module))
    except StoreTrouble as error:
        notify(error.sentence)
        return False
    earlier = [left for left in entries if left.known_as.run != but_run]
    for left in earlier:
        notify(left.sentence)
    return bool(earlier)


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


def end_left_active(conversation: "Conversation", store: "Store", args: argparse.Namespace) -> None:
    """The module reports LOCKED, and a person says by --module or --same-module which one it is. A name does not say
    that it is also the one without a name that was left here."""
    from app.store.database import StoreTrouble
    from app.store.left_active import note_locked
    from app.terminal.command_journal import ORIGIN
    from app.terminal.connection import LinkTrouble
    from app.terminal.stored_history import differences_from

    name, against = clean((args.module or "").strip()), None
    try:
        with LinkTrouble():
            against = [] if args.same_module else differences_from(conversation, store, name)
        if against:
            other = tr("This may be another module: {differences}.", differences=join_names(against))
            notify(join_sentences((other, tr("If it is this module, add {option}.", option="--same-module"))))
        for left in left_here(store, args.port, name) if against == [] else ():
            if args.same_module or left.known_as.name == name:
                store.queue.submit(partial(note_locked, store, left, ORIGIN))
    except StoreTrouble as error:
        notify(error.sentence)
