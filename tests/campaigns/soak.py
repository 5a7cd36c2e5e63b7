"""The whole window, a stream, and all that can go wrong on a line, in real time.

    python -m tests.campaigns.soak SECONDS

The module runs in another process. Faults, silences, restarts, unplugging and plugging in come at random; the window
comes back each time by itself. In the end the line is honest, and then not one frame may be lost. Nothing may be in the
log as an error, no thread stays, and memory does not grow.
"""

import logging
import random
import statistics
import sys
import tempfile
import threading
import time
from collections import Counter
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import Final

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.engine.worker import Batch, PortState
from protocol.events import Received
from tests.bench.kit import LIMIT_S, LoopWatch, resident_mb, turn_for, turn_until, window_apart
from tests.support.processes import Running, module_apart
from ui.core.port_watcher import PortWatcher
from ui.main import Assembly, WindowOptions, start

ADAPTER: Final = PortInfo("", "CP2102 USB to UART", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1")
"""The module is listed as this, whatever its port is called by then."""
FAULTS: Final = ("lose=0.05", "delay_s=0.1", "jitter_s=0.3", "stream_hz=1440")
STREAM: Final = "stream_hz=200"
HONEST_S: Final = 5.0
MAX_GROWTH_MB: Final = 5.0
"""From the middle of a soak to its end."""


class Soak:
    def __init__(self, assembly: Assembly, module: Running, link: Path, seed: int) -> None:
        self.assembly, self.module, self.link = assembly, module, link
        self.dice = random.Random(seed)
        self.complaints: list[str] = []
        self.done = Counter[str]()
        self.memory_mb: list[float] = []

    def run(self, seconds: float) -> None:
        self._connect()
        watch = LoopWatch()
        watch.start()
        ends_at = time.monotonic() + seconds
        while time.monotonic() < ends_at and not self.complaints:
            turn_for(self.dice.uniform(0.1, 2.0))
            self._trouble()
            if sys.platform.startswith("linux"):
                self.memory_mb.append(resident_mb())
        watch.stop()
        self._end_in_order()
        print(", ".join(f"{count} x {what}" for what, count in sorted(self.done.items())))
        print(f"longest stall of the window: {watch.longest_s * 1000:.0f} ms")
        self._judge_memory()

    def _connect(self) -> None:
        self.assembly.ports.connect_to(Target(str(self.link.readlink()), 115200, ADAPTER.identity))
        self._await_stream()

    def _disconnect(self) -> None:
        port = self.assembly.ports.current
        port.disconnect_port()
        turn_until(lambda: port.connection.state is PortState.CLOSED)

    def _await_stream(self) -> None:
        ports = self.assembly.ports
        is_there = turn_until(lambda: ports.current.is_open and ports.module.view.is_streaming, LIMIT_S)
        if not is_there:
            self.complaints.append(f"no stream {LIMIT_S:.0f} s after {dict(self.done)}")

    def _trouble(self) -> None:
        what = self.dice.choice(("unplug", "restart", "silent", "fault", "fault", "fault", "honest"))
        self.done[what] += 1
        if what == "fault":
            self.module.tell(self.dice.choice(FAULTS))
            return
        self.module.tell(f"silent {self.dice.choice((0.2, 0.6, 2.0))}" if what == "silent" else what)
        if what == "unplug":
            turn_for(self.dice.uniform(0.02, 1.0))
            self.module.tell("plug")
        self._make_honest()
        self.module.tell("sent")  # its log stays short
        self._await_stream()

    def _make_honest(self) -> None:
        self.module.tell("honest")
        self.module.tell(STREAM)

    def _end_in_order(self) -> None:
        """On the honest line every frame arrives."""
        self._disconnect()
        self._make_honest()
        self.module.tell("restart")
        turn_for(1.0)
        self.module.tell("sent")
        received = Counter[bytes]()

        def count(batch: Batch) -> None:
            received.update(event.frame.raw for event in batch.events if isinstance(event, Received))

        self.assembly.ports.current.batch.connect(count)
        self._connect()
        turn_for(HONEST_S)
        self.module.tell("stream_hz=0")  # so that none is on its way when the port is closed
        turn_for(1.0)
        self._disconnect()
        sent = int(self.module.tell("sent"))
        print(f"on the honest line: {sent} frames sent, {received.total()} received")
        if sent < HONEST_S * 100 or sent != received.total():
            self.complaints.append("frames were lost on the honest line")

    def _judge_memory(self) -> None:
        later = self.memory_mb[len(self.memory_mb) // 2 :]
        if len(later) < 4:
            return
        tenth = max(1, len(later) // 10)
        growth_mb = statistics.median(later[-tenth:]) - statistics.median(later[:tenth])
        first_mb, last_mb = self.memory_mb[0], later[-1]
        print(f"memory: {first_mb:.0f} to {last_mb:.0f} MB, {growth_mb:+.1f} MB in the second half")
        if growth_mb > MAX_GROWTH_MB:
            self.complaints.append("memory grows")


def soak(seconds: float, seed: int) -> list[str]:
    before, mistakes = set(threading.enumerate()), BufferingHandler(sys.maxsize)
    mistakes.setLevel(logging.ERROR)  # the program writes there also what nobody caught
    logging.getLogger().addHandler(mistakes)
    with tempfile.TemporaryDirectory() as folder:
        link = Path(folder) / "module"

        def listed(_limit_s: float) -> list[PortInfo]:
            return [ADAPTER._replace(device=str(link.readlink()))] if link.exists() else []

        options = WindowOptions(language="en", offscreen_seconds=seconds)
        with module_apart(link, STREAM) as module, window_apart(options, PortWatcher(listed)) as assembly:
            start(assembly, options)
            turn_for(2.0)  # the pages are made
            soaked = Soak(assembly, module, link, seed)
            soaked.run(seconds)
    left = [thread.name for thread in set(threading.enumerate()) - before]
    texts = [f"{record.name}: {record.getMessage()}" for record in mistakes.buffer]
    return [*soaked.complaints, *texts, *(f"a thread stayed: {name}" for name in left)]


if __name__ == "__main__":
    broken = soak(float(sys.argv[1]), seed=time.time_ns())
    print(*broken or ["all as it should be"], sep="\n")
    sys.exit(bool(broken))
