"""CPU time of the whole program, window and worker, and stalls of its event loop, while a module in another process
streams to its Live page."""

import json
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from app.engine.worker import PortState
from tests.bench.figures import Figure, measured
from tests.bench.module import streaming_module
from tests.bench.window import LIMIT_S, WARM_UP_S, LoopWatch, Traffic, live_page, turn_for, turn_until, window_apart
from ui.main import WindowOptions, start

_RATES: Final = {50: (1, 0.09), 200: (1, None), 1440: (3, 0.15)}
"""Runs, and the aim as a share of one core."""
STALL_AIM_S: Final = 0.050
SECONDS: Final = 6.0


def _run(rate_hz: int) -> dict[str, Any]:
    """One window on one module; `lost`: status frames that were sent but not delivered by the worker."""
    options = f"rate={rate_hz}", "lifelike=yes"
    with tempfile.TemporaryDirectory() as folder, streaming_module(Path(folder) / "module", *options) as module:
        found = measured("cpu", module.port)
        sent = module.frames_sent + found["asked"]
    return {**found, "sent": sent, "lost": sent - found["statuses"], "not_kept": found["samples"] - found["kept"]}


def figures() -> list[Figure]:
    """Three rows per rate: CPU, status frames from the port to the page's series, the longest stall."""
    found = []
    for rate_hz, (count, aim) in _RATES.items():
        runs = [_run(rate_hz) for _ in range(count)]
        shares = [run["cpu_share"] for run in runs]
        share, stall_s, rate = (
            statistics.median(run[key] for run in runs) for key in ("cpu_share", "stall_s", "rate_hz")
        )
        sent, lost, not_kept = (sum(run[key] for run in runs) for key in ("sent", "lost", "not_kept"))
        spread = f" ({min(shares):.1%} to {max(shares):.1%} in {count} runs)" if count > 1 else ""
        found += [
            Figure(
                f"CPU of window and worker at {rate_hz} Hz",
                f"{share:.1%} of one core{spread}",
                *(() if aim is None else (f"<= {aim:.0%}", share <= aim)),
            ),
            Figure(
                f"status frames at {rate_hz} Hz ({rate:.0f} measured)",
                f"{sent} sent, {lost} lost, {not_kept} not in the plots",
                "none lost",
                lost == 0 and not_kept == 0,
            ),
            Figure(
                f"longest stall of the event loop at {rate_hz} Hz",
                f"{stall_s * 1000:.1f} ms",
                f"<= {STALL_AIM_S * 1000:.0f} ms",
                stall_s <= STALL_AIM_S,
            ),
        ]
    return found


def measure(port: str) -> dict[str, float]:
    """Connects, waits for the stream, measures, and disconnects."""
    traffic, watch = Traffic(), LoopWatch()
    options = WindowOptions(port=port, language="en", offscreen_seconds=SECONDS)
    with window_apart(options) as (_app, assembly):
        ports = assembly.ports
        ports.current.batch.connect(traffic.on_batch)
        start(assembly, options)
        assert turn_until(lambda: ports.current.module.view.is_streaming, LIMIT_S), "the module did not stream"
        turn_for(WARM_UP_S)
        before, began, cpu = traffic.samples, time.perf_counter(), time.process_time()
        turn_for(SECONDS)
        cpu_s, wall_s, samples = time.process_time() - cpu, time.perf_counter() - began, traffic.samples - before
        beats, watch.is_measuring = watch.timer(), True
        beats.start()  # only now, since it takes a tenth of all CPU time
        turn_for(SECONDS)
        beats.stop()
        ports.current.disconnect_port()
        assert turn_until(lambda: ports.current.connection.state is PortState.CLOSED, LIMIT_S), "it did not close"
        turn_for(0.3)  # until the page draws next
        kept = len(live_page(assembly).data.tilt)
    return {
        "cpu_share": cpu_s / wall_s, "rate_hz": samples / wall_s, "statuses": traffic.statuses, "asked": traffic.asked,
        "samples": traffic.samples, "kept": kept, "stall_s": watch.longest_s,
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1])))
