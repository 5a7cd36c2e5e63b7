"""An independent module in a process of its own.

    python -m tests.support.module_apart LINK [OPTION=VALUE …]

prints its port, LINK, and does what the lines of standard input say, until that ends: `restart`, `silent SECONDS`,
`OPTION=VALUE`, `honest`, `unplug`, `plug` (behind LINK is another pseudo-terminal then), and what its log has:
`streamed` (how many frames, since it was asked), `last HEX` (when it got this code last, in monotonic seconds). Each is
answered by a line.
"""

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options
from tests.support.processes import Running, running


class ModuleApart(NamedTuple):
    """`port` leads to it, also after it was unplugged and plugged in again."""

    process: Running
    port: str

    def tell(self, order: str) -> str:
        """Return the answer to an order."""
        self.process.told.write(f"{order}\n")
        self.process.told.flush()
        return self.process.out.readline().strip()


@contextmanager
def module_apart(link: Path, *options: str) -> Iterator[ModuleApart]:
    with running(sys.executable, "-m", "tests.support.module_apart", link, *options) as process:
        yield ModuleApart(process, process.out.readline().strip())
        process.end()


class _Plug:
    """Each time it is put in there is another pseudo-terminal."""

    def __init__(self, module: Module, link: str) -> None:
        self._module, self._link = module, link
        self.put_in()

    def put_in(self) -> None:
        self._line = Line(self._module, link=self._link)
        self._line.__enter__()

    def pull(self) -> None:
        self._line.__exit__()


def _obey(order: str, plug: _Plug, module: Module) -> object:
    match order.split():
        case ["restart"]:
            module.restart(now())
        case ["silent", seconds]:
            module.be_silent(now(), float(seconds))
        case ["honest"]:
            module.options = Options()
        case ["unplug"]:
            plug.pull()
        case ["plug"]:
            plug.put_in()
        case ["streamed"]:
            count = sum(entry.note == "stream" for entry in module.log)
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
    plug = _Plug(module, link)
    for option in options:
        _obey(option, plug, module)
    print(link, flush=True)
    for line in sys.stdin:
        print(_obey(line.strip(), plug, module), flush=True)
    plug.pull()


if __name__ == "__main__":
    main(*sys.argv[1:])
