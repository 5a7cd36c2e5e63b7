"""The simulated module in its own process, which also counts the streamed status frames.

    python -m tests.bench.module PATH OPTION=VALUE …

Prints its port, then does what the lines of standard input say, one answer per line: "unplug [SECONDS]", "plug",
"restart", "fault NAME VALUE", "fault none". "count" returns the number of streamed frames, "locked" when LOCK last
arrived (monotonic seconds). Ends with its input.
"""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import Loop, PtyEndpoint
from app.simulator.setup import parse_options
from protocol.catalogue import LOCK
from tests.support.line import odd_module
from tests.support.line.frames import at_each_frame
from tests.support.line.odd_module import end_faults
from tests.support.processes import Running, running


class StreamingModule(NamedTuple):
    """Controls such a process. `port` is the same after unplugging and plugging in."""

    process: Running
    answers: threading.Lock
    port: str

    def tell(self, line: str) -> str:
        """Send a control line; return the answer."""
        with self.answers:
            self.process.told.write(line + "\n")
            self.process.told.flush()
            answer = self.process.out.readline().strip()
        assert answer, "the simulated module ended"
        return answer

    @property
    def locked_at(self) -> float:
        """When LOCK last arrived, in monotonic seconds, which on Linux all processes share."""
        return float(self.tell("locked"))

    @property
    def frames_sent(self) -> int:
        """Streamed status frames since it was switched on."""
        return int(self.tell("count"))


@contextmanager
def streaming_module(link: Path, *options: str) -> Iterator[StreamingModule]:
    """Run a module at the symbolic link `link`. `options`: "rate=1440"."""
    with running(sys.executable, "-m", "tests.bench.module", link, *options) as process:
        module = StreamingModule(process, threading.Lock(), process.out.readline().strip())
        assert module.port, process.errors.read()
        yield module
        process.end()


class _PluggedModule:
    """A module whose adapter is plugged in and out: each time it is another pseudo-terminal behind the same link."""

    def __init__(self, bench: SimulatedBench, link: Path) -> None:
        self.bench, self._link = bench, link
        self._changing = threading.RLock()
        self._loop: Loop | None = None
        self._thread: threading.Thread | None = None
        self._replugging: threading.Timer | None = None
        self.plug()

    def plug(self) -> None:
        with self._changing:
            if self._loop is None:
                self.bench.plug()
                endpoint = PtyEndpoint(self._link, baud_rate=self.bench.module.baud_rate)
                self._loop = loop = Loop(self.bench, endpoint)
                self._thread = threading.Thread(target=_serve, args=(loop, endpoint), name="simulated module")
                self._thread.start()

    def unplug(self, for_s: float | None = None) -> None:
        with self._changing:
            if self._replugging is not None:
                self._replugging.cancel()
            if self._loop is not None and self._thread is not None:
                self._loop.stop()
                self._thread.join()
                self._loop = None
                self.bench.unplug()
            if for_s is not None:
                self._replugging = threading.Timer(for_s, self.plug)
                self._replugging.daemon = True
                self._replugging.start()


def _serve(loop: Loop, endpoint: PtyEndpoint) -> None:
    with closing(endpoint):
        loop.run()


def _answer(module: _PluggedModule, locks: list[float], line: str) -> str:
    bench = module.bench
    match line.split():
        case ["locked"]:
            return f"{locks[-1]:.6f}"
        case ["count"]:
            with bench.changed:
                assert isinstance(bench.module, odd_module.OddModule)
                return str(bench.module.stream_frames_sent)
        case ["unplug", *for_s]:
            module.unplug(float(for_s[0]) if for_s else None)
        case ["plug"]:
            module.plug()
        case ["restart"]:
            bench.restart()
        case ["fault", "none"]:
            end_faults(bench)
        case ["fault", name, value]:
            bench.change(**parse_options({name: value}))
        case _:
            return "refused"
    return "done"


def main(words: list[str]) -> int:
    """Serve until the input ends."""
    link, *options = words
    odd_module.install()
    bench = SimulatedBench(odd_module.OddSetup(**parse_options(dict(text.split("=", 1) for text in options))))
    locks = [0.0]
    at_each_frame(bench, lambda request: locks.append(time.monotonic()) if request == LOCK else None)
    module = _PluggedModule(bench, Path(link))
    print(link, flush=True)
    for line in sys.stdin:
        print(_answer(module, locks, line.strip()), flush=True)
    module.unplug()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
