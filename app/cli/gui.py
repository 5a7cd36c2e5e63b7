"""`dps-s gui`, `dps-s FILE` and `dps-s` alone: arguments of the window. `app.__main__` opens it."""

import argparse
import re
from collections.abc import Container
from pathlib import Path

from app.terminal import console
from app.text.i18n import LANGUAGES, PSEUDO, tr

_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,8}")


def is_file_name(word: str, commands: Container[str]) -> bool:
    """Whether `word` names a file, as in `dps-s FILE`, and not a command."""
    return word not in commands and (bool(_SUFFIX.fullmatch(Path(word).suffix)) or Path(word).is_file())


class _Offered(tuple[str, ...]):
    """The languages that help and errors list; the pseudo-language of the tests is taken too."""

    __slots__ = ()

    def __contains__(self, word: object) -> bool:
        return word == PSEUDO or super().__contains__(word)


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("gui")
    parser.add_argument("file", type=Path, nargs="?", metavar="FILE", help=tr("profile, capture, recording or check"))
    parser.add_argument("--demo", action="store_true", help=tr("Simulated module"))
    parser.add_argument("-p", "--port", metavar="P", help=tr("Port"))
    rates = "|".join(map(str, console.RATES)) + f" [{console.USUAL_RATE}]"
    parser.add_argument("-b", "--baud", type=int, choices=console.RATES, default=console.USUAL_RATE, metavar="N",
                        help=tr("baud rate: {rates}", rates=rates))  # fmt: skip
    parser.add_argument("--lang", choices=_Offered(LANGUAGES), metavar="L", help="|".join(LANGUAGES))
    parser.add_argument("--offscreen-seconds", type=console.seconds, metavar="S", help=tr("end after S seconds"))
    parser.add_argument("--evidence", type=Path, metavar="DIR", help=tr("save a screenshot and the values there"))
