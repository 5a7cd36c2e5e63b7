"""The simulated module in its own process, which also counts the streamed status frames.

    python -m tests.benchmarks.module PATH OPTION=VALUE …

Prints its port, then does what the lines of standard input say, one answer per line: "unplug [SECONDS]", "plug",
"restart", "fault NAME VALUE", "fault none". "count"
returns the number of streamed frames, "locked" when LOCK last arrived (monotonic seconds). Ends with its input.
"""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import Loop, PtyEndpoint
from app.simulator.setup import Setup, parse_options
from protocol.catalogue import LOCK
from tests.support.line.frames import at_each_frame
from tests.support.processes import ROOT, environment

COUNT = "count"
LOCKED = "locked"


class StreamingModule:
    """Controls such a process. `port` is the same after unplugging and plugging in."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self._process = process
        self._answers = threading.Lock()
        self.port = self._read()

    def _read(self) -> str:
        if self._process.stdout is None:
            raise RuntimeError("no output to read")
        line = self._process.stdout.readline().strip()
        if not line:
            raise RuntimeError("the simulated module ended")
        return line

    def tell(self, line: str) -> str:
        """Send a control line; return the answer."""
        if self._process.stdin is None:
            raise RuntimeError("no input to write")
        with self._answers:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
            return self._read()

    @property
    def locked_at(self) -> float:
        """When LOCK last arrived, in monotonic seconds, which on Linux all processes share."""
        return float(self.tell(LOCKED))

    @property
    def frames_sent(self) -> int:
        """Streamed status frames since it was switched on."""
        return int(self.tell(COUNT))


@contextmanager
def streaming_module(link: Path, *options: str) -> Iterator[StreamingModule]:
    """Run a module at the symbolic link `link`. `options`: "rate=1440"."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.benchmarks.module", str(link), *options],
        cwd=ROOT, env=environment(), text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        try:
            yield StreamingModule(process)
        finally:
            process.communicate(timeout=10)


class _PluggedModule:
    """A module whose adapter is plugged in and out: each time it is another pseudo-terminal behind the same link."""

    def __init__(self, bench: SimulatedBench, link: Path) -> None:
        self.bench, self._link = bench, link
        self._changing = threading.RLock()
        self._loop: Loop | None = None
        self._thread: threading.Thread | None = None
        self._replugging: threading.Timer | None = None
        self.plug()

    def wake(self) -> None:
        with self._changing:
            if self._loop is not None:
                self._loop.wake()

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
    if line == LOCKED:
        return f"{locks[-1]:.6f}"
    if line == COUNT:
        with bench.changed:
            return str(bench.module.stream_frames_sent)
    match line.split():
        case ["unplug", *for_s]:
            module.unplug(float(for_s[0]) if for_s else None)
        case ["plug"]:
            module.plug()
        case ["restart"]:
            bench.restart()
        case ["fault", "none"]:
            bench.end_faults()
        case ["fault", name, value]:
            bench.change(**parse_options({name: value}))
        case _:
            return "refused"
    return "done"


def main(words: list[str]) -> int:
    """Serve until the input ends."""
    link, *options = words
    bench = SimulatedBench(Setup(**parse_options(text.split("=", 1) for text in options)))  # type: ignore[misc]
    locks = [0.0]
    at_each_frame(bench, lambda request: locks.append(time.monotonic()) if request == LOCK else None)
    module = _PluggedModule(bench, Path(link))
    print(link, flush=True)
    for line in sys.stdin:
        print(_answer(module, locks, line.strip()), flush=True)
        module.wake()
    module.unplug()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
