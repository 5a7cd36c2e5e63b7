"""The module in a process of its own.

    python -m tests.module LINK [OPTION=VALUE …]

prints LINK, which leads to its pseudo-terminal, and does what the lines of standard input say, until that ends:
`restart`, `silent SECONDS`, `OPTION=VALUE`, `honest`, `unplug`, `plug` (behind LINK is another pseudo-terminal then).
It tells what its log has: `sent` (how many frames, since it was asked), `last HEX` (when it got this code last, in
monotonic seconds). Each is answered by a line.
"""

import math
import sys

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options


def obey(order: str, module: Module) -> object:
    match order.split():
        case ["restart"]:
            module.restart(now())
        case ["silent", seconds]:
            module.be_silent(now(), float(seconds))
        case ["honest"]:
            module.options = Options()
        case ["sent"]:
            count = len(module.log.sent())
            module.log.clear()
            return count
        case ["last", code]:
            return module.began_at + max((entry.at_s for entry in module.log.got(int(code, 16))), default=-math.inf)
        case _:
            name, _, value = order.partition("=")
            setattr(module.options, name, float(value))
    return "done"


def main(link: str, *options: str) -> None:
    module = Module(now=now())
    for option in options:
        obey(option, module)
    line = Line(module, link=link).__enter__()
    print(link, flush=True)
    for order in map(str.strip, sys.stdin):
        answer: object = "done"
        if order == "unplug":
            line.__exit__()
        elif order == "plug":
            line = Line(module, link=link).__enter__()
        else:
            answer = obey(order, module)
        print(answer, flush=True)
    line.__exit__()


if __name__ == "__main__":
    main(*sys.argv[1:])
