"""CPU time of the whole program, window and worker, and stalls of its event loop, while a module in another process
streams to its Live page."""

import statistics
from typing import Any, Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import lively_module, measured

LINE_HZ: Final = 1440
_AIMS: Final = {50: 0.09, LINE_HZ: 0.15}
"""Of one core."""
STALL_AIM_S: Final = 0.050
_RUNS: Final = {50: 1, 200: 1, LINE_HZ: 3}


def _run(rate_hz: int, seconds: float) -> dict[str, Any]:
    """One window on one module; `lost`: status frames that were sent but not delivered by the worker."""
    with lively_module(rate_hz) as module:
        found = measured("tests.benchmarks.window", module.port, str(seconds))
        sent = module.frames_sent + found["asked"]
    if not (found["is_streaming"] and found["is_closed"]):
        raise RuntimeError(f"the module did not stream, or the port did not close: {found}")
    return {**found, "sent": sent, "lost": sent - found["statuses"], "not_kept": found["samples"] - found["kept"]}


def figures(seconds: float = 6.0) -> list[Figure]:
    """Three rows per rate: CPU, status frames from the port to the page's series, the longest stall."""
    found = []
    for rate_hz, count in _RUNS.items():
        runs = [_run(rate_hz, seconds) for _ in range(count)]
        shares = [run["cpu_share"] for run in runs]
        share = statistics.median(shares)
        aim = _AIMS.get(rate_hz)
        spread = f" ({min(shares):.1%} to {max(shares):.1%} in {count} runs)" if count > 1 else ""
        found.append(
            Figure(
                f"CPU of window and worker at {rate_hz} Hz",
                f"{share:.1%} of one core{spread}",
                "" if aim is None else f"<= {aim:.0%}",
                None if aim is None else share <= aim,
            )
        )
        sent, lost, not_kept = (sum(run[key] for run in runs) for key in ("sent", "lost", "not_kept"))
        rate = statistics.median(run["rate_hz"] for run in runs)
        found.append(
            Figure(
                f"status frames at {rate_hz} Hz ({rate:.0f} measured)",
                f"{sent} sent, {lost} lost, {not_kept} not in the plots",
                "none lost",
                lost == 0 and not_kept == 0,
            )
        )
        stall_s = statistics.median(run["stall_s"] for run in runs)
        found.append(
            Figure(
                f"longest stall of the event loop at {rate_hz} Hz",
                f"{stall_s * 1000:.1f} ms",
                f"<= {STALL_AIM_S * 1000:.0f} ms",
                stall_s <= STALL_AIM_S,
            )
        )
    return found
