"""`python -m tests.campaigns.soak`: the whole window, a stream at line rate, and all that can go wrong on a line.

    python -m tests.campaigns.soak --seconds 1800

The module runs in another process. Faults, restarts, unplugging and plugging in come at random; the window is
expected to come back each time by itself. In the end the line is healed, and then not one frame may be lost. Exit code
1 for an exception, a frame lost on the healed line, a thread that stays, memory that grows, or a window that does not
come back.
"""

import argparse
import logging
import os
import statistics
import sys
import tempfile
import threading
import time
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from PySide6.QtCore import QTimer
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QWidget

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.engine.worker import PortState
from tests.bench.module import StreamingModule, streaming_module
from tests.bench.window import (
    LIMIT_S,
    LoopWatch,
    Traffic,
    fill_capture,
    live_page,
    reserve,
    resident_mb,
    turn_for,
    turn_until,
    window_apart,
)
from tests.campaigns.soak.chaos import Chaos
from tests.support.confined import confined_home
from tests.support.terminals import RETURN_LIMIT_S
from ui.core.port_watcher import PortWatcher
from ui.main import Assembly, WindowOptions, start
from ui.session.ports import Ports

CLEAN_S: Final = 5.0
"""How long the healed line is watched for lost frames."""
SHORTEST_S: Final = 5.0
MAX_GROWTH_MB: Final = 5.0
"""From the middle of a soak to its end."""
MACHINE_S: Final = 1.0
"""What a busy machine adds to `RETURN_LIMIT_S`."""
_MEASURE_EVERY_MS: Final = 500
_BAUD_RATE: Final = 115200
_ADAPTER: Final = PortInfo("", "CP2102 USB to UART", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1")
"""The module is listed as this, whatever its port is called by then."""


@dataclass
class Outcome:
    """What a soak found. `complaints` make it fail."""

    lines: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def say(self, name: str, text: str, complaint: str = "") -> None:
        """One line of the report; with a complaint the soak has failed."""
        self.lines.append(f"{name:<28}{text}" + (f"  <- {complaint}" if complaint else ""))
        if complaint:
            self.complaints.append(f"{name}: {complaint}")


class Mistakes(logging.Handler):
    """Collects inside a `with` what must never be: exceptions that nobody caught, and errors in the log."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(logging.Formatter("%(name)s: %(message)s").format(record))

    def __enter__(self) -> Self:
        self._hooks = sys.excepthook, threading.excepthook, sys.unraisablehook
        sys.excepthook = self._take
        threading.excepthook = lambda args: self._take(args.exc_type, args.exc_value, args.exc_traceback)
        sys.unraisablehook = lambda args: self._take(args.exc_type, args.exc_value, args.exc_traceback)
        logging.getLogger().addHandler(self)
        return self

    def __exit__(self, *_: object) -> None:
        logging.getLogger().removeHandler(self)
        sys.excepthook, threading.excepthook, sys.unraisablehook = self._hooks

    def _take(self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None, /) -> None:
        self.texts.append("".join(traceback.format_exception(kind, error, trace)))


def _is_back(ports: Ports) -> bool:
    return ports.current.is_open and ports.module.is_going and ports.module.view.is_streaming


class StallWatch(LoopWatch):
    """Knows besides how much of a stall was work of the window's own thread; the rest is the machine's."""

    own_s = 0.0
    """The most work in one turn of the event loop."""
    _worked_s = 0.0

    def beat(self) -> None:
        super().beat()
        worked_s = time.thread_time()
        if self.is_measuring and self._worked_s:
            self.own_s = max(self.own_s, worked_s - self._worked_s)
        self._worked_s = worked_s if self.is_measuring else 0.0


def _listed(link: Path) -> PortWatcher:
    """The ports as a system lists them on which the module hangs at an adapter."""

    def look(_limit_s: float) -> list[PortInfo]:
        try:
            return [_ADAPTER._replace(device=str(link.readlink()))]
        except FileNotFoundError:
            return []  # unplugged

    return PortWatcher(look)


def _target(module: StreamingModule) -> Target:
    return Target(str(Path(module.port).readlink()), _BAUD_RATE, _ADAPTER.identity)


def _fill(assembly: Assembly) -> None:
    """Take the memory that is bounded and fills little by little now, so that growth is a leak."""
    reserve(live_page(assembly))
    fill_capture(assembly.window.findChild(QWidget, "diagnosis_page"))


def _soak(assembly: Assembly, module: StreamingModule, outcome: Outcome, *, seconds: float, seed: int) -> None:
    ports = assembly.ports
    traffic, watch, memory = Traffic(), StallWatch(), list[float]()
    ports.current.batch.connect(traffic.on_batch)
    beats, measures = watch.timer(), QTimer()
    measures.setInterval(_MEASURE_EVERY_MS)
    measures.timeout.connect(lambda: memory.append(resident_mb()))
    ports.connect_to(_target(module))
    if not turn_until(lambda: ports.current.module.view.is_streaming, LIMIT_S):
        outcome.say("stream", "none", "the module did not begin to stream")
    _fill(assembly)  # a module that connects begins with new plots
    turn_for(0.5)
    chaos = Chaos(module, seed, lambda: ports.current.connection.opening)
    beats.start()
    if sys.platform.startswith("linux"):
        measures.start()
    watch.is_measuring = True
    chaos.start()
    turn_for(seconds)
    if not chaos.end(LIMIT_S) or chaos.error is not None:
        outcome.say("troubles", "broke off", str(chaos.error or "did not end"))
    came_back = turn_until(lambda: _is_back(ports), LIMIT_S)
    sent = module.frames_sent
    outcome.say("troubles", ", ".join(f"{count} x {what}" for what, count in sorted(chaos.done.items())) or "none")
    outcome.say("unplugged, reopened", f"{chaos.done['unplug']:,}, {ports.current.connection.opening - 1:,} times")
    is_late = chaos.slowest_own_s > RETURN_LIMIT_S + MACHINE_S
    outcome.say(
        "open again after the return",
        f"within {chaos.slowest_return_s:.2f} s; {chaos.slowest_own_s:.2f} s without what the machine kept it waiting",
        f"more than {RETURN_LIMIT_S:.0f} s" if is_late else "",
    )
    outcome.say("came back and streams", "yes" if came_back else "no", "" if came_back else "it should have")
    outcome.say(
        "while in trouble",
        f"{sent:,} frames streamed, {traffic.asked:,} asked for; {traffic.statuses:,} received, "
        f"{max(0, sent + traffic.asked - traffic.statuses):,} lost to the troubles",
    )
    _watch_healed_line(ports, module, outcome)
    beats.stop()
    measures.stop()
    outcome.say(
        "longest stall of the window",
        f"{watch.longest_s * 1000:.0f} ms; most work of its own in one turn {watch.own_s * 1000:.0f} ms",
    )
    _judge_memory(memory, outcome, unplugs=chaos.done["unplug"])


def _watch_healed_line(ports: Ports, module: StreamingModule, outcome: Outcome) -> None:
    ports.current.disconnect_port()
    turn_until(lambda: ports.current.connection.state is PortState.CLOSED, LIMIT_S)
    for line in ("unplug", "plug", "restart"):  # what a slowed line still held up is gone with its plug
        module.tell(line)
    turn_for(0.3)  # its two heartbeats are over
    traffic, before = Traffic(), module.frames_sent
    ports.current.batch.connect(traffic.on_batch)
    ports.connect_to(_target(module))
    turn_until(lambda: ports.current.module.view.is_streaming, LIMIT_S)
    turn_for(CLEAN_S)
    ports.current.disconnect_port()
    turn_until(lambda: ports.current.connection.state is PortState.CLOSED, LIMIT_S)
    sent = module.frames_sent - before
    lost = sent + traffic.asked - traffic.statuses
    complaint = "frames were lost" if lost else "" if sent > CLEAN_S else "it did not stream"
    outcome.say("on the healed line", f"{sent:,} frames streamed, {lost:,} lost", complaint)


def _judge_memory(memory: list[float], outcome: Outcome, *, unplugs: int) -> None:
    later = memory[len(memory) // 2 :]
    if len(later) < 4:
        outcome.say("memory", "not measured")
        return
    slope = statistics.linear_regression(range(len(later)), later).slope * 1000 / _MEASURE_EVERY_MS * 3600
    tenth = max(1, len(later) // 10)
    growth = statistics.median(later[-tenth:]) - statistics.median(later[:tenth])
    outcome.say(
        "memory",
        f"{memory[0]:.0f} MB at first, {memory[-1]:.0f} in the end; second half {growth:+.1f} MB, {slope:+.1f} MB/h, "
        f"{growth * 1000 / max(1, unplugs / 2):+.1f} kB an unplug",
        "it grows" if growth > MAX_GROWTH_MB else "",
    )


def _run(seconds: float, seed: int) -> Outcome:
    outcome, before = Outcome(), set(threading.enumerate())
    with tempfile.TemporaryDirectory() as folder, Mistakes() as mistakes:
        options = WindowOptions(language="en", offscreen_seconds=seconds)
        link = Path(folder) / "module"
        with window_apart(options, _listed(link)) as (_app, assembly):
            pages = QSignalSpy(assembly.window.pages_made)
            start(assembly, options)
            turn_until(lambda: pages.count() > 0, LIMIT_S)
            turn_for(0.5)
            with streaming_module(link, "rate=1440", "lifelike=yes") as module:
                _soak(assembly, module, outcome, seconds=seconds, seed=seed)
                assembly.window.close_now()
    left = [thread.name for thread in set(threading.enumerate()) - before]
    outcome.say("threads left", ", ".join(left) or "none", "a thread stayed" if left else "")
    outcome.say("exceptions and errors", str(len(mistakes.texts)), "see below" if mistakes.texts else "")
    outcome.lines += mistakes.texts
    return outcome


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.soak", description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="5 at least (default: 60)")
    parser.add_argument("--seed", type=int, default=1, help="the same seed, the same troubles")
    args = parser.parse_args()
    if args.seconds < SHORTEST_S:
        parser.error("5 seconds at least")
    if sys.platform.startswith("linux") and not (os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}):
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    began, outcome = time.monotonic(), _run(args.seconds, args.seed)
    print("\n".join(outcome.lines))
    said = "; ".join(outcome.complaints) or "all as it should be"
    print(f"{said} ({time.monotonic() - began:.0f} s, seed {args.seed})")
    return 1 if outcome.complaints else 0


if __name__ == "__main__":
    with confined_home():
        sys.exit(main())
