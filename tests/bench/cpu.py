"""CPU time of the whole program, window and worker, and stalls of its event loop, while a module in another process
streams to its Live page."""

import json
import statistics
import sys
import time
from collections.abc import Iterator
from typing import Final

from tests.bench.kit import LIMIT_S, WARM_UP_S, Figure, LoopWatch, apart, turn_for, turn_until, window_apart
from tests.support.processes import run_module
from ui.main import WindowOptions, start

RATES: Final = {50: (1, 0.09), 1440: (3, 0.15)}
"""Runs, and the aim as a share of one core."""
STALL_AIM_S: Final = 0.050
SECONDS: Final = 6.0


def figures() -> Iterator[Figure]:
    for rate_hz, (count, aim) in RATES.items():
        runs = []
        for _ in range(count):
            with run_module("--rate", str(rate_hz), "--lifelike") as module:
                runs.append(apart("cpu", module.port))
        share, stall_s = (statistics.median(run[key] for run in runs) for key in ("cpu_share", "stall_s"))
        yield Figure(
            f"CPU of window and worker at {rate_hz} Hz", f"{share:.1%} of one core", f"<= {aim:.0%}", share <= aim
        )
        yield Figure(
            f"longest stall of the event loop at {rate_hz} Hz",
            f"{stall_s * 1000:.1f} ms",
            f"<= {STALL_AIM_S * 1000:.0f} ms",
            stall_s <= STALL_AIM_S,
        )


def measure(port: str) -> dict[str, float]:
    options = WindowOptions(port=port, language="en", offscreen_seconds=SECONDS)
    with window_apart(options) as assembly:
        start(assembly, options)
        assert turn_until(lambda: assembly.ports.current.module.view.is_streaming, LIMIT_S), "the module did not stream"
        turn_for(WARM_UP_S)
        began, cpu = time.perf_counter(), time.process_time()
        turn_for(SECONDS)
        share = (time.process_time() - cpu) / (time.perf_counter() - began)
        watch = LoopWatch()
        watch.start()  # only now, since it takes a tenth of all CPU time
        turn_for(SECONDS)
        watch.stop()
    return {"cpu_share": share, "stall_s": watch.longest_s}


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1])))
