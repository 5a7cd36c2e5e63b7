"""Estimates loss of control and impact of a flight from tilt and specific force alone."""

from typing import Final, NamedTuple

import numpy as np

from app.flight_logs.flight_log import Flags, FlightLog, Floats

CALM_S: Final = 1.0
CALM_TILT_DEG: Final = 30.0
CALM_G: Final = (0.5, 1.5)
IMPACT_G: Final = 3.0
MIN_LOSS_S: Final = 0.3
"""A calm flight until less than this before the impact was a hard landing."""
BOUNCE_S: Final = 2.0
"""Peaks within this time are one impact."""
REST_M: Final = 2.0
"""Altitudes within this of the last one are those of an aircraft that flew no more."""


class LossOfControl(NamedTuple):
    """Times of the `FlightLog`; None where unknown."""

    loss_s: float | None
    """End of the last calm second in flight before the impact: tilt up to 30°, 0.5 to 1.5 g. An estimate."""
    impact_s: float | None
    """First of the last peaks of 3 g or more, else the touchdown in the log."""


NOT_LOST: Final = LossOfControl(None, None)


def loss_of_control(log: FlightLog) -> LossOfControl:
    """`loss_s` is None for a flight that was calm to its end or landing."""
    is_known = log.is_judged & np.isfinite(log.tilt_deg) & np.isfinite(log.specific_force_g)
    ended_s = _fell_to_rest(log, is_known)
    if ended_s is not None:  # what moves it later is a hand
        is_known &= log.time_s <= ended_s + BOUNCE_S
    time_s = log.time_s[is_known]
    if not len(time_s):
        return NOT_LOST
    tilt_deg, force_g = log.tilt_deg[is_known], log.specific_force_g[is_known]
    impact_s = _last_impact(time_s[force_g >= IMPACT_G])
    if impact_s is None:
        impact_s = _touchdown(log)
    if impact_s is None:
        impact_s = ended_s
    is_calm = _is_calm(tilt_deg, force_g)
    loss_s = _last_calm_end(time_s, is_calm)
    end_s = float(time_s[-1])
    if impact_s is not None and (loss_s is None or loss_s <= impact_s or end_s - loss_s < MIN_LOSS_S):
        before = time_s <= impact_s
        loss_s, end_s = _last_calm_end(time_s[before], is_calm[before]), impact_s
    else:  # it flew on after that peak
        impact_s = None
    if loss_s is not None and end_s - loss_s < MIN_LOSS_S:
        loss_s = None
    return LossOfControl(loss_s, impact_s)


def _is_calm(tilt_deg: Floats, force_g: Floats) -> Flags:
    calm: Flags = (tilt_deg <= CALM_TILT_DEG) & (force_g >= CALM_G[0]) & (force_g <= CALM_G[1])
    return calm


def _fell_to_rest(log: FlightLog, is_known: Flags) -> float | None:
    """From when on it stayed at its last altitude, if it was not calm when it came there; None where unknown."""
    if log.altitude_m is None:
        return None
    rows = np.flatnonzero(np.isfinite(log.altitude_m))
    away = np.flatnonzero(np.abs(log.altitude_m[rows] - log.altitude_m[rows[-1:]]) > REST_M)
    if not len(away):
        return None
    rest_s = float(log.time_s[rows[away[-1]]])
    before = is_known & (log.time_s > rest_s - CALM_S) & (log.time_s <= rest_s)
    if not before.any() or _is_calm(log.tilt_deg[before], log.specific_force_g[before]).any():
        return None
    return rest_s


def _last_impact(peaks_s: Floats) -> float | None:
    if not len(peaks_s):
        return None
    first = np.flatnonzero(np.diff(peaks_s, prepend=-np.inf) > BOUNCE_S)[-1]
    return float(peaks_s[first])


def _touchdown(log: FlightLog) -> float | None:
    """The last touchdown in the log."""
    if log.is_on_ground is None:
        return None
    touches = np.flatnonzero(log.is_on_ground[1:] & ~log.is_on_ground[:-1]) + 1
    return float(log.time_s[touches[-1]]) if len(touches) else None


def _last_calm_end(time_s: Floats, is_calm: Flags) -> float | None:
    """End of the last run of calm rows of at least `CALM_S`."""
    edges = np.flatnonzero(np.diff(is_calm, prepend=False, append=False))
    starts, lasts = edges[::2], edges[1::2] - 1
    is_long = time_s[lasts] - time_s[starts] >= CALM_S
    return float(time_s[lasts[is_long][-1]]) if is_long.any() else None
