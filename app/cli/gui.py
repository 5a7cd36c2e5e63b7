"""`dps-s [gui]`: the window, connected to a port or to a built-in simulated module, or on a file."""

import argparse
import errno
import os
from pathlib import Path

from app.terminal import console
from app.text.i18n import LANGUAGES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "profile, recording, flight log or record"
    console.add_file(parser, "file", type=Path, nargs="?", metavar="FILE", help=text)
    parser.add_argument("--demo", action="store_true", help="connect to a built-in simulated module")
    parser.add_argument("-p", "--port", metavar="P", help="port to connect to")
    rates, usual = console.RATES, console.USUAL_RATE
    text = f"baud rate: {', '.join(map(str, rates))} (default: {usual})"
    parser.add_argument("-b", "--baud", type=int, choices=rates, default=usual, metavar="N", help=text)
    parser.add_argument("--lang", choices=LANGUAGES, metavar="L", help=f"language: {', '.join(LANGUAGES)}")
    # Of the tests of packages, which look at the window that they start.
    parser.add_argument("--offscreen-seconds", type=console.seconds, metavar="S", help="end after S seconds")
    console.add_file(parser, "--evidence", type=Path, metavar="DIR", help="save a picture there")


def run(args: argparse.Namespace) -> int:
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
