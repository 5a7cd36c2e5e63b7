"""`dps-s [gui]`: the window, connected to a port or to a built-in simulated module, or on a file."""

import argparse
from typing import Any

from app.terminal import console
from app.text.i18n import LANGUAGES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    rate: dict[str, Any] = {"dest": "baud_rate", "type": int, "choices": console.RATES, "default": console.USUAL_RATE}
    languages = f"language: {', '.join(LANGUAGES)}"
    console.add_file(parser, "file", metavar="FILE", help="profile, recording, flight log or record", nargs="?")
    parser.add_argument("--demo", action="store_true", help="connect to a built-in simulated module")
    parser.add_argument("-p", "--port", metavar="P", help="port to connect to")
    parser.add_argument("-b", "--baud", help="baud rate", **rate)
    parser.add_argument("--lang", dest="language", choices=LANGUAGES, metavar="L", help=languages)
    # Of the tests of packages, which look at the window that they start.
    parser.add_argument("--offscreen-seconds", type=console.seconds, metavar="S", help="end after S seconds")
    console.add_file(parser, "--evidence", metavar="DIR", help="save a picture there")


def run(args: argparse.Namespace) -> int:
    # Said in the terminal, where it was typed: the window would begin without a word about it.
    if args.file is not None:
        try:
            args.file.open("rb").close()
        except OSError as error:
            raise console.unreadable(args.file, error) from error
    from app.system.libraries import window_obstacle

    obstacle = window_obstacle()
    if obstacle is not None:
        console.notify(obstacle)
        return console.NO_LINK
    return int(args.open_window(args))
