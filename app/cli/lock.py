"""`dps-s lock`: locks the module, at once.

LOCK is sent whether or not the module answers and whatever the disk does, and repeated until the module that answers
now reports that it is locked, at most for ten seconds. Exit code 0 it reports LOCKED; 1 not confirmed; 3 no link.
"""

import argparse
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import cache
from threading import Lock
from typing import TYPE_CHECKING

from app.procedures.lock import lock
from app.safety.journal import Act, Entry, Journal, Outcome
from app.terminal import console
from app.terminal.connection import connected

if TYPE_CHECKING:
    from app.terminal.records import Records

STORE_LIMIT_S = 2.5  # how long the store may take once the module has been locked


ARGUMENTS = (
    *console.PORT,
    # Whoever is in a hurry must not be told to type more.
    console.option("--yes", action="store_true", default=True, help="accepted, not needed"),
    *console.module("name of the module that is locked"),
    console.JSON,
)


class LateJournal(Journal):
    """The journal of LOCK, whose store is loaded behind its first frame. What it is told before that it tells then, in
    order. LOCK waits for no entry: none that this gives out is ever done."""

    is_ready = True

    def __init__(self) -> None:
        self._lock = Lock()
        self._journal: Journal | None = None
        self._waiting: list[Callable[[Journal], None]] = []
        # Those of the journal, by those that were given out.
        self._entries: dict[Entry, Entry] = {}

    def use(self, journal: Journal) -> None:
        with self._lock:
            self._journal = journal
            for tell in self._waiting:
                tell(journal)
            self._waiting.clear()

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        entry = Entry()

        def tell(journal: Journal) -> None:
            self._entries[entry] = journal.begin(act, frame, detail)

        self._tell(tell)
        return entry

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object], /) -> None:
        self._tell(lambda journal: journal.settle(self._entries[entry], outcome, result))

    def _tell(self, tell: Callable[[Journal], None]) -> None:
        with self._lock:
            if self._journal is None:
                self._waiting.append(tell)
            else:
                tell(self._journal)


def run(args: argparse.Namespace) -> int:
    # LOCK is sent before the store is loaded, which takes a third of the way there, and before any file is opened; its
    # exit code does not depend on one.
    journal = LateJournal()
    with ExitStack() as at_the_end:

        @cache
        def records() -> "Records":
            from app.terminal.records import records_of

            loaded = at_the_end.enter_context(records_of(args.port, STORE_LIMIT_S, starts_late=True))
            journal.use(loaded.journal)
            return loaded

        is_locked = False
        try:
            with connected(args.port, args.baud, is_greeted=False) as opened:
                done = opened.run(lock(journal), outlives=True, meanwhile=records)
                is_locked = done.is_locked is True
                from app.cli.act import print_outcome

                return print_outcome(args, Act.LOCK, done)
        finally:
            from app.terminal.records import conclude_lock

            conclude_lock(records(), args, opened.conversation if is_locked else None)
