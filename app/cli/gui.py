"""`dps-s [gui]`: the window, connected to a port or to a built-in simulated module, or on a file."""

import argparse
import errno
import os

from app.terminal import console
from app.text.i18n import LANGUAGES

ARGUMENTS = (
    console.file("file", "FILE", "profile, recording, flight log or record", nargs="?"),
    console.switch("--demo", "connect to a built-in simulated module"),
    console.option("-p", "--port", metavar="P", help="port to connect to"),
    console.option(
        "-b", "--baud", dest="baud_rate", type=int, choices=console.RATES, default=console.USUAL_RATE, help="baud rate"
    ),
    console.option("--lang", dest="language", choices=LANGUAGES, metavar="L", help=f"language: {', '.join(LANGUAGES)}"),
    # Of the tests of packages, which look at the window that they start.
    console.option("--offscreen-seconds", type=console.seconds, metavar="S", help="end after S seconds"),
    console.file("--evidence", "DIR", "save a picture there"),
)


def run(args: argparse.Namespace) -> int:
    # Said in the terminal, where it was typed: the window would begin without a word about it.
    if args.file is not None and not args.file.is_file():
        number = errno.EISDIR if args.file.is_dir() else errno.ENOENT
        raise console.unreadable(args.file, OSError(number, os.strerror(number)))
    from app.system.libraries import window_obstacle

    obstacle = window_obstacle()
    if obstacle is not None:
        console.notify(obstacle)
        return console.NO_LINK
    code: int = args.open_window(args)
    return code
