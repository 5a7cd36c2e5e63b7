"""`dps-s lock`: locks the module, at once.

LOCK is sent whether or not the module answers and whatever the disk does, and repeated until the module that answers
now reports that it is locked, at most for ten seconds. Exit code 0 it reports LOCKED; 1 not confirmed; 3 no link.
"""

import argparse

from app.cli.act import print_outcome
from app.procedures.lock import lock
from app.safety.journal import Act
from app.terminal import console
from app.terminal.connection import connected
from app.terminal.records import CommandStore, conclude_lock


def add_arguments(parser: argparse.ArgumentParser) -> None:
    # Whoever is in a hurry must not be told to type more.
    parser.add_argument("--yes", action="store_true", default=True, help="accepted, not needed")
    console.add_module(parser, "name of the module that is locked")


def run(args: argparse.Namespace) -> int:
    is_locked = False
    # The first LOCK is sent before the store opens any file, and the exit code does not depend on one.
    with CommandStore(args.port, starts_late=True) as store:
        try:
            with connected(args.port, args.baud, is_greeted=False) as opened:
                done = opened.run(lock(store.journal), outlives=True)
                is_locked = done.is_locked is True
                return print_outcome(args, Act.LOCK, done)
        finally:
            # The conversation may have begun only after LOCK was confirmed: it is that which the port ended with.
            conclude_lock(store, args, opened.conversation if is_locked else None)
