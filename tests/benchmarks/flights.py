"""Flight logs of ten minutes, read and summarised by worker processes; and the map over a thousand flights."""

import os
import shutil
import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np

from app.firing.judge import TriggerLimits
from app.flight_analysis.flight_set import FlightGroup, FlightSet
from app.flight_analysis.many_logs import summarise_logs
from app.flight_analysis.proposal import propose
from app.flight_analysis.summary import summarise
from app.flight_logs.flight_log import Floats
from tests.benchmarks.figures import Figure, quantile
from tests.benchmarks.runs import cores
from tests.support.flights import log_bytes as made
from tests.support.flights.made_flights import random_flight

MINUTES: Final = 10
THOUSAND: Final = 1000
THOUSAND_AIM_S: Final = 60.0
MAP_AIM_MS: Final = 100.0
_OTHERS: Final = 3
"""Number of other records per record that is read."""


def figures(logs: int = 200, flights: int = THOUSAND, redraws: int = 50) -> list[Figure]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = [_logs_figure(folder, "DataFlash", ".bin", dataflash_of(MINUTES), logs),
                 _logs_figure(folder, "ULog", ".ulg", ulog_of(MINUTES), logs)]  # fmt: skip
    return [*found, *_map_figures(flights, redraws)]


def dataflash_of(minutes: float) -> bytes:
    """Attitude 25 times and acceleration 50 times a second, and three times as many records of other kinds."""
    times = np.arange(0, 60 * minutes, 0.02)
    tilt, force = _flown(times)
    rows = made.dataflash_attitude(times[::2], tilt[::2]) + made.dataflash_force(times, force)
    for _ in range(_OTHERS):
        for others_s in (times, times[::2]):
            rows += made.dataflash_table("XYZ", ((at_s, [0.0]) for at_s in others_s.tolist()))
    return made.dataflash_bytes(rows)


def ulog_of(minutes: float) -> bytes:
    """Attitude 50 times and acceleration 200 times a second."""
    times = np.arange(0, 60 * minutes, 0.005)
    tilt, force = _flown(times)
    return made.ulog_bytes(made.ulog_attitude(times[::4], tilt[::4]) + made.ulog_force(times, force))


def _flown(times: Floats) -> tuple[Floats, Floats]:
    random = np.random.default_rng(10)
    tilt = np.abs(20 * np.sin(times / 3) + random.normal(0, 2, len(times)))
    return tilt, 1 + random.normal(0, 0.15, len(times))


def _logs_figure(folder: Path, name: str, ending: str, data: bytes, count: int) -> Figure:
    original = folder / f"0{ending}"
    original.write_bytes(data)
    paths = [original, *(folder / f"{number}{ending}" for number in range(1, count))]
    for path in paths[1:]:
        _same_file(original, path)
    worked_s, began = _worked_s(), time.perf_counter()
    found = sum(one.flight is not None for one in summarise_logs(paths))
    seconds = (time.perf_counter() - began) * THOUSAND / count
    assert found == count
    worked_s = (_worked_s() - worked_s) * THOUSAND / count
    text = f"{seconds:.0f} s for a thousand ({count} measured, {len(data) / 1e6:.1f} MB each), {cores()} cores"
    text += f"; {worked_s:.0f} s of processor time"
    aim = f"<= {THOUSAND_AIM_S:g} s"
    return Figure(f"{name} logs of {MINUTES} minutes", text, aim, seconds <= THOUSAND_AIM_S)


def _worked_s() -> float:
    """CPU time of this process and its ended children."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _same_file(original: Path, path: Path) -> None:
    try:
        os.link(original, path)
    except OSError:
        shutil.copyfile(original, path)


def _map_figures(count: int, redraws: int) -> list[Figure]:
    random = np.random.default_rng(11)
    summaries = [summarise(random_flight(random, 200)) for _ in range(count)]
    flights = FlightSet()
    for number, one in enumerate(summaries):
        object.__setattr__(one, "name", f"flight {number}")
        group = FlightGroup.MUST if number % 10 == 0 else FlightGroup.MUST_NOT
        flights.add([one], group)
    flights.fire_map(TriggerLimits())
    waits_ms = []
    for number in range(redraws):
        limits = TriggerLimits(freefall_acceleration_g=(1 + number % 8) / 10)
        began = time.perf_counter()
        flights.fire_map(limits)
        flights.outcomes(limits)
        waits_ms.append((time.perf_counter() - began) * 1000)
    slowest_ms = quantile(waits_ms, 0.99)
    began = time.perf_counter()
    propose(flights)
    text = f"{quantile(waits_ms, 0.5):.0f} ms median, {slowest_ms:.0f} ms p99"
    return [
        Figure(f"map and outcomes of {count:,} flights for other thresholds", text, f"<= {MAP_AIM_MS:g} ms",
               slowest_ms <= MAP_AIM_MS),
        Figure(f"proposal for {count:,} flights", f"{time.perf_counter() - began:.2f} s"),
    ]  # fmt: skip
