"""`python -m tests.module [OPTION=JSON …]`: a module on a pseudo-terminal, for another process.

The first line of its output is the port. It takes orders on standard input, a line each, and runs until that ends:
`restart`, `silent SECONDS`, `tilt DEGREES`, `fall`, `stand`, `open`, `close`, `set HEX VALUE`, `unplug`, `OPTION=JSON`.
"""

import argparse
import contextlib
import sys
from pathlib import Path

from tests.module.line import Line
from tests.module.module import Module
from tests.module.options import from_words, use


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.module")
    parser.add_argument("--link", help="a name for the port")
    parser.add_argument("--log", type=Path, help="a file for all frames, a JSON object a line")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--boots", type=int, default=1)
    parser.add_argument("--set", nargs=2, action="append", default=[], metavar=("HEX", "VALUE"))
    parser.add_argument("--second", nargs="*", metavar="OPTION=JSON", help="a second module on the same line")
    parser.add_argument("options", nargs="*", metavar="OPTION=JSON")
    words = parser.parse_args()
    with contextlib.ExitStack() as stack:
        copy = None if words.log is None else stack.enter_context(words.log.open("w"))
        now = Line.now()
        first = Module(from_words(words.options), name="first", seed=words.seed, now=now, copy=copy)
        modules = [first]
        if words.second is not None:
            modules.append(Module(from_words(words.second), name="second", seed=words.seed + 1, now=now, copy=copy))
        first.readings.boots = words.boots
        for code, value in words.set:
            first.settings[int(code, 16)] = int(value)
        line = stack.enter_context(Line(*modules, link=words.link))
        print(line.port, flush=True)
        for order in sys.stdin:
            obey(order.split(), line, first)


def obey(order: list[str], line: Line, module: Module) -> None:
    now = line.now()
    match order:
        case ["restart"]:
            module.restart(now)
        case ["silent", seconds]:
            module.be_silent(now, float(seconds))
        case ["tilt", degrees]:
            module.move(now, tilt_deg=int(degrees))
        case ["fall"]:
            module.move(now, acceleration=0)
        case ["stand"]:
            module.move(now, acceleration=10)
        case ["open"]:
            module.readings.bay_open = True
        case ["close"]:
            module.readings.bay_open = False
        case ["set", code, value]:
            module.settings[int(code, 16)] = int(value)
        case ["unplug"]:
            line.unplug()
        case [word] if "=" in word:
            use(module.options, word)
        case _:
            print(f"not understood: {' '.join(order)}", file=sys.stderr)


if __name__ == "__main__":
    main()
