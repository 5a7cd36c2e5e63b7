"""Checks acceleration sensors for wrong scale, stuck values and disagreement."""

from typing import Final

import numpy as np

from app.flight_logs.flight_log import Flags, Floats
from app.flight_logs.module_view import averaged
from app.text.messages import UserMessage, message
from protocol.translatable import marked

AVERAGED_S: Final = 1.0
REST_G: Final = (0.8, 1.25)
MIN_REST: Final = 0.05
"""Share of the log in which the average must be at rest: over time any aircraft measures 1 g."""
MAX_FALL_S: Final = 10.0
"""An average below 0.8 g for longer is a bad sensor: within 10 s of falling drag brings it back to 1 g."""
DISAGREE_G: Final = 0.3


def believed_force(time_s: Floats, sensors: list[Floats], problems: list[UserMessage]) -> Floats:
    """Combines the sensors' columns (g, NaN without a sample); NaN where none is plausible."""
    checked = [_checked(time_s, one, number, problems) for number, one in enumerate(sensors, 1)]
    believed = max(checked, key=lambda one: int(np.isfinite(one).sum()))  # the first of equals
    for other in checked:
        if other is not believed:
            believed = _agreed(time_s, believed, other, problems)
    return believed


def _checked(time_s: Floats, force_g: Floats, number: int, problems: list[UserMessage]) -> Floats:
    rows = np.flatnonzero(np.isfinite(force_g))
    if not len(rows):
        return force_g
    times, mean_g = time_s[rows], averaged(time_s[rows], force_g[rows], AVERAGED_S)
    is_rest = (mean_g >= REST_G[0]) & (mean_g <= REST_G[1])
    if is_rest.mean() < MIN_REST:
        problems.append(
            message(
                marked("Acceleration sensor {number} never rests at 1 g (median {median:.2f} g); not judged."),
                number=number, median=float(np.median(force_g[rows])),
            )
        )  # fmt: skip
        return np.full(len(force_g), np.nan)
    believed = force_g.copy()
    for start_s, end_s in _long_runs(times, mean_g < REST_G[0]):
        is_bad = (time_s >= start_s - AVERAGED_S) & (time_s <= end_s)
        problems.append(
            message(
                marked("Acceleration sensor {number} stuck at {median:.2f} g for {seconds:.0f} s from {start:.1f} s; "
                       "not judged."),
                number=number, median=float(np.nanmedian(force_g[is_bad])), seconds=end_s - start_s, start=start_s,
            )
        )  # fmt: skip
        believed[is_bad] = np.nan
    return believed


def _long_runs(time_s: Floats, is_low: Flags) -> list[tuple[float, float]]:
    """Start and end of the runs longer than `MAX_FALL_S`."""
    edges = np.flatnonzero(np.diff(is_low, prepend=False, append=False))
    starts_s, ends_s = time_s[edges[::2]], time_s[edges[1::2] - 1]
    is_long = ends_s - starts_s > MAX_FALL_S
    return list(zip(starts_s[is_long].tolist(), ends_s[is_long].tolist(), strict=True))


def _agreed(time_s: Floats, one: Floats, other: Floats, problems: list[UserMessage]) -> Floats:
    rows = np.flatnonzero(np.isfinite(one) & np.isfinite(other))
    if not len(rows):
        return one
    means_g = [averaged(time_s[rows], each[rows], AVERAGED_S) for each in (one, other)]
    matters = np.minimum(*means_g) < REST_G[0]  # sensors may clip an impact at different values
    is_apart = np.zeros(len(one), np.bool_)
    is_apart[rows[matters & (np.abs(means_g[0] - means_g[1]) > DISAGREE_G)]] = True
    if not is_apart.any():
        return one
    seconds = float(np.diff(time_s, prepend=time_s[0])[is_apart].clip(max=AVERAGED_S).sum())
    problems.append(
        message(marked("Acceleration sensors differ by over {limit:.1f} g for {seconds:.2f} s; not judged."),
             limit=DISAGREE_G, seconds=seconds)
    )  # fmt: skip
    return np.where(is_apart, np.nan, one)
