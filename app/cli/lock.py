"""`dps-s lock`: locks the module, at once.

LOCK is sent whether or not the module answers and whatever the disk does, and repeated until the module reports that it
is locked. Exit code 0 the module reports LOCKED; 1 not confirmed; 3 no link.
"""

import argparse

from app.cli.act import tell
from app.procedures.lock import lock
from app.safety.acts import Act
from app.terminal import console
from app.terminal.arguments import add_json, add_module, add_port
from app.terminal.command_journal import records_of
from app.terminal.connection import connected
from app.terminal.interruption import Interruption
from app.terminal.left_active import end_left_active, say_left_by_others
from app.text.i18n import tr

STORE_LIMIT_S = 2.5
"""How long the store may take once the module has been locked."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    # Whoever is in a hurry must not be told to type more.
    parser.add_argument("--yes", action="store_true", default=True, help="accepted, not needed")
    add_module(parser, "name of the module that is locked")
    parser.add_argument("--same-module", action="store_true", help="it is the module that was left ACTIVE here")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """LOCK is sent before any file is opened, and its exit code does not depend on one."""
    with Interruption(), records_of(args.port, STORE_LIMIT_S, starts_late=True) as records:
        try:
            with connected(args.port, args.baud, is_greeted=False) as conversation:
                done = conversation.run(lock(records.journal, is_attended=False))
                code = tell(args, Act.LOCK, done)
                if done.is_locked:
                    end_left_active(conversation, records, args)
        except KeyboardInterrupt:
            console.notify(tr("Interrupted; may have been carried out."))
            raise
        finally:
            say_left_by_others(records, args)
    return code
