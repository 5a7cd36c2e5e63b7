"""Makes flights from arrays, as the readers of logs do."""

import numpy as np
from numpy.typing import ArrayLike

from app.flight_logs.flight_log import REPORT_HZ, FlightLog

STEP_S = 1 / REPORT_HZ


def made_flight(
    tilt_deg: ArrayLike,
    force_g: ArrayLike,
    *,
    name: str = "made",
    time_s: ArrayLike | None = None,
    is_judged: ArrayLike | None = None,
    altitude_m: ArrayLike | None = None,
    is_on_ground: ArrayLike | None = None,
    resets_s: tuple[float, ...] = (),
) -> FlightLog:
    """Make a flight; without `time_s`, its rows come at the report rate. Scalars apply to every row."""
    count = max(np.size(one) for one in (tilt_deg, force_g))
    times = np.arange(count) / REPORT_HZ if time_s is None else np.asarray(time_s, np.float64)
    return FlightLog(
        name=name,
        time_s=times,
        tilt_deg=np.broadcast_to(np.asarray(tilt_deg, np.float64), count).copy(),
        specific_force_g=np.broadcast_to(np.asarray(force_g, np.float64), count).copy(),
        is_judged=np.ones(count, np.bool_) if is_judged is None else np.asarray(is_judged, np.bool_),
        duration_s=float(times[-1] - times[0]) if count else 0.0,
        altitude_m=None if altitude_m is None else np.asarray(altitude_m, np.float64),
        is_on_ground=None if is_on_ground is None else np.asarray(is_on_ground, np.bool_),
        resets_s=resets_s,
    )


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
