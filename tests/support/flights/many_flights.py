"""Makes sets of flights: ordinary ones with turns and bumps, and crashes."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from app.flight_analysis.summary import FlightSummary, summarise
from app.flight_logs.flight_log import REPORT_HZ, FlightLog
from tests.support.flights.made_flights import made_flight


def ordinary_flight(name: str, random: np.random.Generator, *, seconds: float = 120.0) -> FlightLog:
    """Make a flight with turns of up to 50° and short dips of the force."""
    rows = round(seconds * REPORT_HZ)
    times = np.arange(rows) / REPORT_HZ
    tilt = np.abs(8 * np.sin(times / 3)) + random.normal(0, 1, rows)
    tilt += random.uniform(15, 48) * np.exp(-(((times - seconds * random.uniform(0.3, 0.7)) / 1.5) ** 2))
    force = 1 + random.normal(0, 0.04, rows)
    start, length = round(rows * random.uniform(0.2, 0.8)), random.integers(5, 45)
    force[start : start + length] = 0.4
    height = 40 + 10 * np.sin(times / 20)
    return made_flight(np.clip(tilt, 0, 180), np.abs(force), name=name, altitude_m=height)


def crash(name: str, random: np.random.Generator, *, seconds: float = 60.0) -> FlightLog:
    """Make a flight that ends in a tumbling fall from 60 m to the ground."""
    rows = round(seconds * REPORT_HZ)
    times = np.arange(rows) / REPORT_HZ
    lost_s = seconds - 4.0 - random.uniform(0, 1)
    since = np.clip(times - lost_s, 0, None)
    tilt = np.abs(5 * np.sin(times)) + np.clip(since * random.uniform(60, 140), 0, 175)
    force = 1 + random.normal(0, 0.03, rows)
    force[since > 0.2] = random.uniform(0.05, 0.35)
    height = np.clip(60 - 4.9 * since**2, 0, None)
    hit = since >= 3.4
    force[hit] = np.where(np.arange(hit.sum()) < 5, 8.0, 1.0)
    return made_flight(np.clip(tilt, 0, 180), np.abs(force), name=name, altitude_m=height)


def summaries(must_not: int, must: int) -> Iterator[tuple[FlightSummary, bool]]:
    """Yield summaries, each with whether the module must fire."""
    random = np.random.default_rng(3)
    for number in range(must_not):
        yield summarise(ordinary_flight(f"/logs/survey-{number:03}.ulg", random)), False
    for number in range(must):
        yield summarise(crash(f"/logs/crash-{number:03}.bin", random)), True


def write_csv(path: Path, log: FlightLog, head: str = "time_s,tilt_deg,acceleration_g,altitude_m") -> Path:
    """Write a flight as a table of comma-separated values."""
    height = np.zeros(len(log.time_s)) if log.altitude_m is None else log.altitude_m
    table = np.stack([log.time_s, log.tilt_deg, log.specific_force_g, height], axis=1)
    np.savetxt(path, table, fmt="%.3f", delimiter=",", header=head, comments="")
    return path


def write_logs(folder: Path) -> list[Path]:
    """Write a crash, an ordinary flight, and a table with unknown columns.

    So few files are read without worker processes; their names do not count as words of a language.
    """
    folder.mkdir(parents=True)
    random = np.random.default_rng(7)
    return [
        write_csv(folder / "c1.csv", crash("", random, seconds=20)),
        write_csv(folder / "s1.csv", ordinary_flight("", random, seconds=20)),
        write_csv(folder / "t1.csv", ordinary_flight("", random, seconds=5), "w,a,g,h"),
    ]
