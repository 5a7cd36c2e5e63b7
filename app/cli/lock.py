"""`dps-s lock`: locks the module, at once.

LOCK is sent whether or not the module answers and whatever the disk does, and repeated until the module that answers
now reports that it is locked, at most for ten seconds. Exit code 0 it reports LOCKED; 1 not confirmed; 3 no link.
"""

import argparse

from app.cli.act import interruption_told, print_outcome
from app.procedures.lock import lock
from app.safety.journal import Act
from app.terminal.arguments import add, add_module, add_port
from app.terminal.connection import connected
from app.terminal.interruption import signals_noted
from app.terminal.records import conclude_lock, records_of

STORE_LIMIT_S = 2.5  # how long the store may take once the module has been locked


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    # Whoever is in a hurry must not be told to type more.
    parser.add_argument("--yes", action="store_true", default=True, help="accepted, not needed")
    add_module(parser, "name of the module that is locked")
    add(parser, "--json")


def run(args: argparse.Namespace) -> int:
    """LOCK is sent before any file is opened, and its exit code does not depend on one."""
    with signals_noted(), records_of(args.port, STORE_LIMIT_S, starts_late=True) as records:
        is_locked = False
        try:
            with interruption_told(), connected(args.port, args.baud, is_greeted=False) as opened:
                done = opened.run(lock(records.journal), outlives=True)
                is_locked = done.is_locked is True
                code = print_outcome(args, Act.LOCK, done)
        finally:
            conclude_lock(records, args, opened.conversation if is_locked else None)
    return code
