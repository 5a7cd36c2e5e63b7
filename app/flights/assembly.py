"""Makes a `FlightLog` of raw channels: one clock, rows at the module's report rate, invalid samples removed.

A row holds the newest sample up to its time. A pause in the samples has no rows. An acceleration sensor with a wrong
scale, stuck, or in disagreement with another one is not believed.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import GAP_TOLERANCE_S, REPORT_HZ, TILT_GAP_S, FlightLog, runs, total_s
from app.flights.judge import MAX_GAP_S
from app.flights.judging import averaged
from app.flights.raw_log import Channel, Flags, Floats, RawLog, unreadable
from app.text.messages import UserError, joined
from protocol.translatable import marked

MAX_ROWS: Final = 48 * 3600 * REPORT_HZ
"""Two days."""
LATEST_S: Final = 1e10
"""Latest plausible time, since boot or since 1970."""
AFTER_DISARM_S: Final = 5.0
"""Also judged after disarming: an aircraft whose motors stop in the air still falls."""
LATE_S: Final = 1.0
"""A sample that stands so far behind its place is late; a step back of more is a clock that jumps."""
_TICK: Final = 1e-6

AVERAGED_S: Final = 1.0
REST_G: Final = (0.8, 1.25)
MIN_REST: Final = 0.05
"""Share of the log in which the average must be at rest: over time any aircraft measures 1 g."""
MAX_FALL_S: Final = 10.0
"""An average below 0.8 g for longer is a bad sensor: within 10 s of falling drag brings it back to 1 g."""
DISAGREE_G: Final = 0.3


class _Sensor(NamedTuple):
    """A channel without its invalid samples."""

    time_s: Floats
    values: Floats
    left_out_share: float


def assembled(raw: RawLog) -> FlightLog:
    """Raises `UserError` where neither attitude nor acceleration can be judged."""
    raw = replace(raw, problems=[*raw.problems])
    # Of the attitudes the first that is usable, and of all sensors what can be believed.
    tilts = list(islice(_usable(raw.tilts_deg, raw, is_tilt=True), 1))
    forces = list(_usable(raw.forces_g, raw, is_tilt=False))
    if not tilts and not forces:
        raise unreadable(marked("no attitude and no acceleration"))
    if not tilts:
        raw.note(marked("No attitude: attitude trigger not judged."))
    if not forces:
        raw.note(marked("No acceleration: free-fall trigger not judged."))
    bounds_s = np.concatenate([raw.span_s or (), *(sensor.time_s[[0, -1]] for sensor in (*tilts, *forces))])
    start_s = float(bounds_s.min())
    held = [_held(sensor, start_s, raw, is_tilt=True) for sensor in tilts]
    held += [_held(sensor, start_s, raw, is_tilt=False) for sensor in forces]
    time_s = np.unique(np.concatenate([channel.time_s for channel in held]))
    columns = [_column(channel, time_s) for channel in held]
    tilt_deg = columns.pop(0) if tilts else np.full(len(time_s), np.nan)
    force_g = believed_force(time_s, columns, raw) if forces else np.full(len(time_s), np.nan)
    clock_s = time_s + start_s
    log = FlightLog(
        name=raw.name,
        start_s=start_s,
        time_s=time_s,
        tilt_deg=tilt_deg,
        specific_force_g=force_g,
        is_judged=_judged(time_s, _armed_at(raw.armed, clock_s)),
        duration_s=float(bounds_s.max()) - start_s + raw.lost_end_s,
        left_out_share=max(
            max((tilt.left_out_share for tilt in tilts), default=0.0),
            min((force.left_out_share for force in forces), default=0.0),
        ),
        altitude_m=_altitude_at(raw.altitudes_m, clock_s),
        resets=tuple(reset._replace(time_s=reset.time_s - start_s) for reset in raw.resets),
    )
    if not (log.is_judged & (np.isfinite(tilt_deg) | np.isfinite(force_g))).any():
        raise UserError(joined(raw.problems, " "))
    _note_what_is_missing(log, raw)
    return replace(log, problems=tuple(dict.fromkeys(raw.problems)))


def _note_what_is_missing(log: FlightLog, raw: RawLog) -> None:
    steps_s = np.diff(log.time_s)
    pauses_s = steps_s[steps_s > MAX_GAP_S + GAP_TOLERANCE_S]
    if len(pauses_s):
        text = marked("Pauses: {count}, {total:.1f} s in all, at most {longest:.1f} s.")
        raw.note(text, count=len(pauses_s), total=float(pauses_s.sum()), longest=float(pauses_s.max()))
    if not log.is_judged.all():
        raw.note(marked("Not judged: {total:.1f} s on the ground."), total=log.duration_s - total_s(log.flights))
    if not log.has_plausible_length:
        text = marked("The log lasts {seconds:.6g} s, too short or too long for a flight: not judged.")
        raw.note(text, seconds=log.duration_s)


def _usable(channels: Iterable[Channel], raw: RawLog, *, is_tilt: bool) -> Iterator[_Sensor]:
    """Those with valid samples, and of these no others, in order of time."""
    for time_s, values in channels:
        is_number = np.isfinite(time_s) & (np.abs(time_s) <= LATEST_S) & np.isfinite(values)
        _note_left_out(marked("Invalid samples left out: {count}."), is_number, raw)
        # Of samples with equal times the last one is used, and of tilts the largest; the others are no loss.
        known_s, known = time_s[is_number], values[is_number]
        if not (np.diff(known_s) < -LATE_S).any():
            order = np.argsort(known_s, kind="stable")
            known_s, known = known_s[order], known[order]
        places = np.flatnonzero(np.diff(known_s, prepend=np.inf))
        known_s = known_s[places]
        known = np.maximum.reduceat(known, places) if is_tilt else known[np.append(places, len(known))[1:] - 1]
        is_kept = ascending(known_s)
        _note_left_out(marked("The clock jumps back; samples left out: {count}."), is_kept, raw)
        if is_kept.any():
            count = np.count_nonzero(np.diff(time_s, append=np.inf))
            yield _Sensor(known_s[is_kept], known[is_kept], 1 - np.count_nonzero(is_kept) / count)


def _note_left_out(text: str, is_kept: Flags, raw: RawLog) -> None:
    if not is_kept.all():
        raw.note(text, count=f"{np.count_nonzero(~is_kept):,}")


def ascending(time_s: Floats) -> Flags:
    """The rows to keep so that times ascend: drops either rows older than one before them or rows newer than one after
    them, whichever keeps more."""
    newest_before = np.maximum.accumulate(np.append(-np.inf, time_s))[:-1]
    oldest_after = np.minimum.accumulate(np.append(time_s, np.inf)[::-1])[::-1][1:]
    forwards, backwards = time_s > newest_before, time_s < oldest_after
    kept: Flags = forwards if forwards.sum() >= backwards.sum() else backwards
    return kept


def _held(sensor: _Sensor, start_s: float, raw: RawLog, *, is_tilt: bool) -> Channel:
    """A sample for each report: the newest one before it, none in a pause that is too long. Of several tilts since the
    report before, the largest: one that would fire must not fall between two rows."""
    time_s = sensor.time_s - start_s
    if raw.is_of_module:
        return Channel(time_s, sensor.values)
    ticks = np.ceil(time_s * REPORT_HZ - _TICK).astype(np.int64)
    counts = np.ones(len(ticks), np.int64)
    goes_on = np.diff(time_s) <= (TILT_GAP_S if is_tilt else MAX_GAP_S) + GAP_TOLERANCE_S
    counts[:-1][goes_on] = np.diff(ticks)[goes_on]
    if counts.sum() > MAX_ROWS:
        raise unreadable(marked("longer than 48 hours"))
    rows = np.repeat(np.arange(len(ticks)), counts)
    number_of_sample = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    values = sensor.values[rows]
    if is_tilt:
        first_of_tick = np.flatnonzero(np.diff(ticks, prepend=ticks[0] - 1))
        values[number_of_sample == 0] = np.maximum.reduceat(sensor.values, first_of_tick)
    return Channel((ticks[rows] + number_of_sample) / REPORT_HZ, values)


def _column(channel: Channel, time_s: Floats) -> Floats:
    column = np.full(len(time_s), np.nan)
    column[np.searchsorted(time_s, channel.time_s)] = channel.values
    return column


def _armed_at(channels: list[Channel], time_s: Floats) -> Flags:
    """Everywhere where the log does not say."""
    for channel in channels:
        if len(channel.time_s):
            order = np.argsort(channel.time_s, kind="stable")
            places = np.searchsorted(channel.time_s[order], time_s + _TICK, "right") - 1
            is_armed: Flags = channel.values[order][np.maximum(places, 0)] != 0
            return is_armed
    return np.ones(len(time_s), np.bool_)


def _judged(time_s: Floats, is_armed: Flags) -> Flags:
    """From the first arming until `AFTER_DISARM_S` after disarming."""
    if not is_armed.any():
        return np.ones(len(time_s), np.bool_)
    armed_s = np.maximum.accumulate(np.where(is_armed, time_s, -np.inf))
    is_judged: Flags = time_s - armed_s <= AFTER_DISARM_S
    # A pause that begins disarmed is on the ground, as where only flights are logged.
    is_judged[:-1] &= is_armed[:-1] | (np.diff(time_s) <= MAX_GAP_S)
    return is_judged


def _altitude_at(channels: list[Channel], time_s: Floats) -> Floats | None:
    """Interpolated; NaN before the first and after the last sample. None: the log does not say."""
    for channel in channels:
        rows = np.flatnonzero(np.isfinite(channel.time_s) & np.isfinite(channel.values))
        rows = rows[ascending(channel.time_s[rows])]
        if len(rows):
            known_s, known_m = channel.time_s[rows], channel.values[rows]
            altitude_m: Floats = np.interp(time_s, known_s, known_m, left=np.nan, right=np.nan)
            return altitude_m
    return None


# Which sensors are believed


def believed_force(time_s: Floats, sensors: list[Floats], raw: RawLog) -> Floats:
    """Combines the sensors' columns (g, NaN without a sample); NaN where none is plausible."""
    if raw.is_of_module:
        return sensors[0]
    checked = [_checked(time_s, force_g, number, raw) for number, force_g in enumerate(sensors, 1)]
    believed = max(checked, key=lambda force_g: np.count_nonzero(np.isfinite(force_g)))  # the first of equals
    for other in checked:
        if other is not believed:
            believed = _agreed(time_s, believed, other, raw)
    return believed


def _checked(time_s: Floats, force_g: Floats, number: int, raw: RawLog) -> Floats:
    """Without what a sensor with a wrong scale, or one that is stuck, measured."""
    rows = np.flatnonzero(np.isfinite(force_g))
    times_s, mean_g = time_s[rows], averaged(time_s[rows], force_g[rows], AVERAGED_S)
    if ((mean_g >= REST_G[0]) & (mean_g <= REST_G[1])).mean() < MIN_REST:
        text = marked("Acceleration sensor {number} never rests at 1 g (median {median:.2f} g); not judged.")
        raw.note(text, number=number, median=float(np.median(force_g[rows])))
        return np.full(len(force_g), np.nan)
    believed = force_g.copy()
    for first, last in zip(*runs(mean_g < REST_G[0]), strict=True):
        start_s, end_s = float(times_s[first]), float(times_s[last])
        if end_s - start_s > MAX_FALL_S:
            is_bad = (time_s >= start_s - AVERAGED_S) & (time_s <= end_s)
            text = marked(
                "Acceleration sensor {number} stuck at {median:.2f} g for {seconds:.0f} s from {start:.1f} s; "
                "not judged."
            )
            median = float(np.nanmedian(force_g[is_bad]))
            raw.note(text, number=number, median=median, seconds=end_s - start_s, start=start_s)
            believed[is_bad] = np.nan
    return believed


def _agreed(time_s: Floats, believed: Floats, other: Floats, raw: RawLog) -> Floats:
    """Without the time in which one of them falls and the other does not."""
    rows = np.flatnonzero(np.isfinite(believed) & np.isfinite(other))
    mean_g, other_mean_g = (averaged(time_s[rows], force_g[rows], AVERAGED_S) for force_g in (believed, other))
    matters = np.minimum(mean_g, other_mean_g) < REST_G[0]  # sensors may clip an impact at different values
    apart = rows[matters & (np.abs(mean_g - other_mean_g) > DISAGREE_G)]
    if not len(apart):
        return believed
    steps_s = np.diff(time_s, prepend=time_s[0])[apart].clip(max=AVERAGED_S)
    text = marked("Acceleration sensors differ by over {limit:.1f} g for {seconds:.2f} s; not judged.")
    raw.note(text, limit=DISAGREE_G, seconds=float(steps_s.sum()))
    believed = believed.copy()
    believed[apart] = np.nan
    return believed
