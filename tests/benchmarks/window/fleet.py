"""The window on 32 simulated modules that stream at 50 Hz, each on a pseudo-terminal of another process, with the Fleet
page in sight; then 200 unplugs across them.

    python -m tests.benchmarks.window.fleet COUNT SECONDS UNPLUGS

measures and prints JSON. CPU, memory and stalls are those of the program's own process.
"""

import json
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from app.engine.target import Target
from app.fleet.card import Card
from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured
from tests.benchmarks.window.fleet_modules import FIRST_TILT, ManyModules, many_modules
from tests.benchmarks.window.window import (
    LIMIT_S,
    LoopWatch,
    Traffic,
    resident_mb,
    turn_for,
    turn_until,
    window_with_pages,
)
from ui.main import Assembly, WindowOptions
from ui.pages.fleet.page import FleetPage

COUNT: Final = 32
RATE_HZ: Final = 50
UNPLUGS: Final = 200
CPU_AIM, MEMORY_AIM_MB, STALL_AIM_S = 0.6, 400.0, 0.1
_WARM_UP_S: Final = 3.0


def figures(seconds: float = 10.0) -> list[Figure]:
    """CPU, frames, memory, stalls and wrong cards."""
    found = measured("tests.benchmarks.window.fleet", str(COUNT), str(seconds), str(UNPLUGS))
    what = f"{COUNT} modules at {RATE_HZ} Hz"
    return [
        Figure(f"{what}: CPU of the program", f"{found['cpu_share']:.0%} of one core", f"<= {CPU_AIM:.0%}",
               found["cpu_share"] <= CPU_AIM),
        Figure(f"{what}: status frames", f"{found['sent']} sent, {found['lost']} lost", "none lost",
               found["lost"] == 0),
        Figure(f"{what}: memory", f"{found['memory_mb']:.0f} MB", f"<= {MEMORY_AIM_MB:.0f} MB",
               found["memory_mb"] <= MEMORY_AIM_MB),
        Figure(f"{what}: longest stall of the window", f"{found['stall_s'] * 1000:.0f} ms, 99 % "
               f"{found['beat_p99_s'] * 1000:.0f} ms", f"<= {STALL_AIM_S * 1000:.0f} ms",
               found["stall_s"] <= STALL_AIM_S),
        Figure(f"{found['unplugs']} unplugs across {COUNT} modules", f"{found['looked_at']} cards looked at, "
               f"{found['wrong']} wrong; {found['online']} online again", "none wrong",
               found["wrong"] == 0 and found["online"] == COUNT),
    ]  # fmt: skip


def is_wrong(card: Card, number: int, port: str, *, is_plugged_in: bool | None) -> bool:
    """It shows another module's tilt or port, or a number of one that is unplugged. `is_plugged_in` None: just now."""
    is_stranger = card.port != port or card.tilt_deg not in (None, FIRST_TILT + number)
    return is_stranger or (is_plugged_in is False and (card.tilt_deg is not None or card.cell_v is not None))


def _connect(assembly: Assembly, modules: ManyModules) -> tuple[FleetPage, list[Traffic]]:
    assembly.window.go_to("fleet")
    page = assembly.window._pages["fleet"]
    if not isinstance(page, FleetPage):
        raise TypeError("no Fleet page")
    counts = []
    for port in modules.ports:
        traffic = Traffic()
        connection = page.members.connect_port(Target(port, 115200))
        connection.batch.connect(traffic.on_batch)
        counts.append(traffic)
    turn_until(lambda: all(one.device.is_streaming for one in page.members.connections), 2 * LIMIT_S)
    turn_for(_WARM_UP_S)
    return page, counts


def _count(assembly: Assembly, modules: ManyModules, traffic: list[Traffic]) -> tuple[int, int]:
    """Frames sent, and frames not delivered by the workers; the modules are stopped first."""
    assembly.storage.sessions.stop(5.0)  # recording keeps the stream on
    before: list[int] = []
    while before != (before := modules.counts):
        turn_for(3.0)

    def sent() -> int:
        return sum(before) + sum(one.asked for one in traffic)

    def lost() -> int:
        return sent() - sum(one.statuses for one in traffic)

    turn_until(lambda: not lost(), LIMIT_S)  # an answer is delivered up to a quarter of a second after its query
    return sent(), lost()


def _unplug(page: FleetPage, modules: ManyModules, unplugs: int) -> tuple[int, int]:
    """Number of examined and of wrong cards."""
    source, looked_at, wrong = random.Random(7), 0, 0
    short = [one.removeprefix("/dev/") for one in modules.ports]
    for _ in range(unplugs):
        number = source.randrange(len(modules.ports))
        modules.tell(f"{number} unplug {source.choice((0.05, 0.2, 0.6))}")
        turn_for(0.03)
        for place, connection in enumerate(page.members.connections):
            looked_at += 1
            is_plugged_in = connection.is_open if place != number else None
            wrong += is_wrong(page.members.card(connection), place, short[place], is_plugged_in=is_plugged_in)
    return looked_at, wrong


def main(words: list[str]) -> int:
    """Entry point."""
    count, seconds, unplugs = int(words[0]), float(words[1]), int(words[2])
    watch, options = LoopWatch(), WindowOptions(language="en", offscreen_seconds=1)
    with tempfile.TemporaryDirectory() as folder, many_modules(Path(folder), count, RATE_HZ) as modules:
        with window_with_pages(options) as (_app, assembly):
            page, traffic = _connect(assembly, modules)
            beats = watch.timer()
            beats.start()
            began, cpu = time.perf_counter(), time.process_time()
            watch.is_measuring = True
            turn_for(seconds)
            watch.is_measuring = False
            cpu_s, wall_s = time.process_time() - cpu, time.perf_counter() - began
            beats.stop()
            memory_mb = resident_mb()
            sent, lost = _count(assembly, modules, traffic)
            looked_at, wrong = _unplug(page, modules, unplugs)
            everybody = page.members.connections
            turn_until(lambda: all(one.is_open and one.device.values for one in everybody), 2 * LIMIT_S)
            online = sum(one.is_open for one in everybody)
        found: dict[str, Any] = {
            "cpu_share": cpu_s / wall_s, "sent": sent, "lost": lost, "memory_mb": memory_mb,
            "stall_s": watch.late.longest_s, "beat_p99_s": watch.late.quantile_s(0.99), "unplugs": unplugs,
            "looked_at": looked_at, "wrong": wrong, "online": online,
        }  # fmt: skip
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
