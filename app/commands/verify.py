"""`dps-s verify FILE`: was this pre-flight record altered, where, and does its chain hold?

Takes the record (JSON), the page (HTML) or the report (PDF). Exit code 0 intact; 1 altered, chain broken, or no record;
2 where there is no such file.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.commands.console import DONE, SAID_NO, USED_WRONGLY, say, write_lines
from app.i18n import tr

if TYPE_CHECKING:
    from app.store.store import Store


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "verify",
        description=tr(
            "Tell whether a pre-flight record was altered, where, and whether the record before it is intact. The hash "
            "has no key: it finds alterations, it does not prove who wrote the record. Exit code 1 when not intact."
        ),
    )
    parser.add_argument("file", type=Path, metavar="FILE",
                        help=tr("the record (.json), its page (.html) or the report (.pdf)"))  # fmt: skip
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    from app.preflight.verification import State, verify_file
    from app.store.checks import CheckStore

    store = _store()
    try:
        verification = verify_file(args.file, CheckStore(store.database).record if store is not None else None)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        why = getattr(error, "strerror", None) or str(error)
        say(tr("{file} cannot be read: {why}.", file=args.file, why=why))
        return USED_WRONGLY
    finally:
        if store is not None:
            store.close()
    write_lines([one.in_words() for one in verification.sentences()])
    return DONE if verification.state is State.INTACT else SAID_NO


def _store() -> "Store | None":
    """The records of this computer, where it has any; none is made for this."""
    from app.store.database import FILE_NAME, StoreTrouble
    from app.store.store import data_folder, open_store

    if not (data_folder() / FILE_NAME).exists():
        return None
    try:
        store = open_store()
    except StoreTrouble as error:
        say(error.sentence)
        return None
    if store.notice is not None:
        say(store.notice)
    return store
