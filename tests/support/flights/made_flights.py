"""Makes flights: from arrays, as the readers of logs do; ordinary ones with turns and bumps, crashes, recordings."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from app.engine.conversation import StatusSample
from app.flights.flight_log import REPORT_HZ, FlightLog
from app.flights.judge import Judge, SensorSample, TriggerLimits
from app.flights.judging import samples_of
from protocol.messages import Source
from tests.support.records.recordings_made import asked, batch, recorder_in

STEP_S = 1 / REPORT_HZ


def made_flight(
    tilt_deg: ArrayLike,
    force_g: ArrayLike,
    *,
    name: str = "made",
    time_s: ArrayLike | None = None,
    is_judged: ArrayLike | None = None,
    altitude_m: ArrayLike = np.nan,
    resets_s: tuple[float, ...] = (),
) -> FlightLog:
    """Make a flight; without `time_s`, its rows come at the report rate. Scalars apply to every row."""
    count = max(np.size(one) for one in (tilt_deg, force_g))
    times = np.arange(count) / REPORT_HZ if time_s is None else np.asarray(time_s, np.float64)
    tilts = np.broadcast_to(np.asarray(tilt_deg, np.float64), count).copy()
    forces = np.broadcast_to(np.asarray(force_g, np.float64), count).copy()
    return FlightLog(
        name=name,
        time_s=times,
        tilt_deg=tilts,
        specific_force_g=forces,
        is_judged=np.ones(count, np.bool_) if is_judged is None else np.asarray(is_judged, np.bool_),
        duration_s=float(times[-1] - times[0]) if count else 0.0,
        altitude_m=np.broadcast_to(np.asarray(altitude_m, np.float64), count),
        resets_s=np.array(resets_s),
    )


def plainly_judged(log: FlightLog, limits: TriggerLimits) -> list[tuple[float, Source]]:
    """Ask the judge of the simulated module row by row; return all firings."""
    fired: dict[float, Source] = {}
    for source, values, per_unit in ((Source.ATTITUDE, log.tilt_deg, 1), (Source.FREEFALL, log.specific_force_g, 10)):
        samples = samples_of(log, values, per_unit)
        is_tilt = source is Source.ATTITUDE
        only = limits._replace(**{"freefall_is_enabled" if is_tilt else "attitude_is_enabled": False})
        judge, resets = Judge(), log.resets_s.tolist()
        for at_s, steps, is_active in zip(*(column.tolist() for column in samples), strict=True):
            while resets and resets[0] <= at_s:
                judge.reset()
                resets.pop(0)
            value = steps / per_unit
            sample = SensorSample(at_s, value if is_tilt else 0.0, 1.0 if is_tilt else value)
            if judge.judge(sample, only, is_active=is_active).fired:
                fired[at_s] = fired.get(at_s, Source(0)) | source
    return sorted(fired.items())


def random_flight(random: np.random.Generator, rows: int = 400) -> FlightLog:
    """Make a flight with swings, falls, gaps, unknown values, rows that are not judged, and restarts."""
    steps = np.full(rows, STEP_S)
    steps[random.random(rows) < 0.01] = random.choice([0.3, 0.5, 0.52, 3.0])
    tilt = np.abs(np.cumsum(random.normal(0, 6, rows))) % 180
    force = 1 + random.normal(0, 0.05, rows)
    for _ in range(random.integers(0, 6)):
        start, length = random.integers(0, rows), random.integers(1, 130)
        force[start : start + length] = random.choice([0.0, 0.2, 0.34, 0.45, 0.5, 0.65]) + random.normal(0, 0.03)
    is_judged = np.ones(rows, np.bool_)
    for values in (tilt, force):
        start = random.integers(0, rows)
        values[start : start + random.integers(0, 40)] = np.nan
    start = random.integers(0, rows)
    is_judged[start : start + random.integers(0, 60)] = False
    times = np.cumsum(steps)
    resets = tuple(sorted(random.choice(times, random.integers(0, 3)).tolist()))
    return made_flight(tilt, np.abs(force), time_s=times, is_judged=is_judged, resets_s=resets)


# Sets of flights


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


def write_csv(path: Path, log: FlightLog, head: str = "time_s,tilt_deg,acceleration_g,altitude_m") -> Path:
    """Write a flight as a table of comma-separated values."""
    table = np.stack([log.time_s, log.tilt_deg, log.specific_force_g, np.nan_to_num(log.altitude_m)], axis=1)
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


STARTS_S = 1000.0


def recorded_reports(folder: Path, rows: Iterable[tuple[float, float, float]]) -> Path:
    """Record rows of time, tilt and acceleration; return the folder of the recording."""
    samples = [StatusSample(STARTS_S + at_s, int(tilt), force, False, True) for at_s, tilt, force in rows]
    with recorder_in(folder) as bench:
        bench.begin()
        bench.recorder.on_batch(batch(STARTS_S, events=(asked(STARTS_S),)))
        bench.feed(batch(samples[-1].at, *samples))
        bench.finish()
        return bench.path
