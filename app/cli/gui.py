"""`dps-s gui`, `dps-s FILE` and `dps-s` alone: arguments of the window. `app.__main__` opens it."""

import argparse
import re
from collections.abc import Container
from pathlib import Path

from app.terminal.console import RATES, USUAL_RATE, seconds
from app.text.i18n import LANGUAGES, PSEUDO, tr
from app.text.sentences import listed

_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,8}")


def is_file_name(word: str, commands: Container[str]) -> bool:
    """`dps-s FILE`: it names a file, and no command."""
    return word not in commands and (bool(_SUFFIX.fullmatch(Path(word).suffix)) or Path(word).is_file())


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("gui", description=tr("Open the window."))
    parser.add_argument("file", type=Path, nargs="?", metavar="FILE",
                        help=tr("open this profile, capture, recording or check"))  # fmt: skip
    parser.add_argument("--demo", action="store_true", help=tr("connect to a built-in simulated module"))
    parser.add_argument("--port", metavar="P", help=tr("connect to this port at once"))
    parser.add_argument(
        "--baud", type=int, choices=RATES, default=USUAL_RATE, metavar="N", help=tr("baud rate, default 115200")
    )
    parser.add_argument(
        "--lang",
        choices=(*LANGUAGES, PSEUDO),
        metavar="L",
        help=tr("language of the window: {names}", names=listed(LANGUAGES)),
    )
    unseen = parser.add_argument_group(tr("without a screen"))
    unseen.add_argument(
        "--offscreen-seconds", type=seconds, metavar="S", help=tr("run the window for S seconds, then end it")
    )
    unseen.add_argument(
        "--evidence", type=Path, metavar="DIR", help=tr("then leave a screenshot and the values seen in this folder")
    )
