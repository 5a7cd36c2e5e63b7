"""`python -m tests.module [OPTION=JSON …]`: a module on a pseudo-terminal, for another process.

The first line of its output is the port. It takes orders on standard input, a line each, and runs until that ends:
`restart`, `silent SECONDS`, `reading NAME VALUE` (`tilt_deg 70`), `set HEX VALUE`, `OPTION=JSON`, `unplug`.
"""

import argparse
import contextlib
import sys
from pathlib import Path

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import from_words, use


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.module")
    parser.add_argument("--link", help="a name for the port")
    parser.add_argument("--log", type=Path, help="a file for all frames, a JSON object a line")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--second", nargs="*", metavar="OPTION=JSON", help="a second module on the same line")
    parser.add_argument("options", nargs="*", metavar="OPTION=JSON")
    words = parser.parse_args()
    with contextlib.ExitStack() as stack:
        copy = None if words.log is None else stack.enter_context(words.log.open("w"))
        first = Module(from_words(words.options), name="first", seed=words.seed, now=now(), copy=copy)
        modules = [first]
        if words.second is not None:
            modules.append(Module(from_words(words.second), name="second", seed=words.seed + 1, now=now(), copy=copy))
        line = stack.enter_context(Line(*modules, link=words.link))
        print(line.port, flush=True)
        for order in sys.stdin:
            obey(order.split(), line, first)


def obey(order: list[str], line: Line, module: Module) -> None:
    match order:
        case ["restart"]:
            module.restart(now())
        case ["silent", seconds]:
            module.be_silent(now(), float(seconds))
        case ["reading", name, value] if hasattr(module.readings, name):
            setattr(module.readings, name, int(value))
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
