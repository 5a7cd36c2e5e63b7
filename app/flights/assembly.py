"""Makes a `FlightLog` of raw channels: one clock, rows at the module's report rate, invalid samples removed.

A row holds the newest sample up to its time. A pause in the samples has no rows. An acceleration sensor with a wrong
scale, stuck, or in disagreement with another one is not believed.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.flights.flight_log import (
    LONGEST_LOG_S,
    NO_GAPS,
    REPORT_HZ,
    SHORTEST_LOG_S,
    TILT_GAP_S,
    Flags,
    FlightLog,
    Floats,
    Gaps,
    gaps_between,
    unreadable,
)
from app.flights.judge import MAX_GAP_S
from app.flights.module_view import averaged
from app.flights.raw_log import Channel, FlagChannel, RawLog
from app.flights.samples import runs
from app.text.messages import UserMessage, joined, message
from app.text.user_error import UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.recordings.markers import Marker

MAX_ROWS: Final = 48 * 3600 * REPORT_HZ
"""Two days."""
LATEST_S: Final = 1e10
"""Latest plausible time, since boot or since 1970."""
AFTER_DISARM_S: Final = 5.0
"""Also judged after disarming: an aircraft whose motors stop in the air still falls."""
ALTITUDE_HOLDS_S: Final = 5.0
_TICK: Final = 1e-6
_DECIMALS: Final = 3
"""Rounds away the error of 32-bit floats."""


def assembled(raw: RawLog) -> FlightLog:
    """Raises `UserError` where neither attitude nor acceleration can be judged."""
    problems = list(raw.problems)
    tilt: Channel | None = None
    tilt_left_out = 0.0
    for candidate in raw.tilts_deg:
        cleaned = _cleaned(candidate, problems)
        if len(cleaned.time_s):
            tilt, tilt_left_out = cleaned, _share_left_out(cleaned, candidate)
            break
    forces: list[Channel] = []
    forces_left_out: list[float] = []
    for candidate in raw.forces_g:
        cleaned = _cleaned(candidate, problems)
        if len(cleaned.time_s):
            forces.append(cleaned)
            forces_left_out.append(_share_left_out(cleaned, candidate))
    sensed = forces if tilt is None else [tilt, *forces]
    if not sensed:
        raise unreadable(marked("no attitude and no acceleration"))
    if tilt is None:
        problems.append(message(marked("No attitude: attitude trigger not judged.")))
    if not forces:
        problems.append(message(marked("No acceleration: free-fall trigger not judged.")))
    altitude_m = None if raw.altitude_m is None else _cleaned(raw.altitude_m, [])
    timed = sensed if altitude_m is None or not len(altitude_m.time_s) else [*sensed, altitude_m]
    start_s = min(float(channel.time_s[0]) for channel in timed)
    end_s = max(float(channel.time_s[-1]) for channel in timed)
    if raw.span_s is not None:
        start_s = min(start_s, raw.span_s[0])
        end_s = max(end_s, raw.span_s[1])
    duration_s = end_s - start_s + raw.lost_end_s
    held = [_held(channel.time_s - start_s) for channel in sensed]
    ticks = _merged([places[0] for places in held])
    time_s = ticks / REPORT_HZ
    columns = [_column(ticks, *places, channel.values) for places, channel in zip(held, sensed, strict=True)]
    tilt_deg = columns.pop(0) if tilt is not None else np.full(len(ticks), np.nan)
    force_g = believed_force(time_s, columns, problems) if columns else np.full(len(ticks), np.nan)
    is_armed, is_on_ground = (
        None if flags is None else _flags_at(flags, time_s + start_s) for flags in (raw.armed, raw.on_ground)
    )
    is_judged = _judged(time_s, is_armed, is_on_ground)
    if not (is_judged & (np.isfinite(tilt_deg) | np.isfinite(force_g))).any():
        raise UserError(joined(problems, " "))
    _note_pauses(time_s, is_judged, problems)
    _note_length(duration_s, problems)
    tilts_s = np.empty(0) if tilt is None else tilt.time_s - start_s
    return FlightLog(
        name=raw.name,
        time_s=time_s,
        tilt_deg=tilt_deg,
        specific_force_g=force_g,
        is_judged=is_judged,
        duration_s=duration_s,
        tilt_gaps=_but_joins(gaps_between(tilts_s, 0.0, duration_s, TILT_GAP_S), raw.joins_s - start_s),
        force_gaps=_but_joins(
            gaps_between(time_s[np.isfinite(force_g)], 0.0, duration_s, MAX_GAP_S), raw.joins_s - start_s
        ),
        left_out_share=max(tilt_left_out, min(forces_left_out, default=0.0)),
        disarmed_gaps=NO_GAPS if is_armed is None else _disarmed_gaps(time_s, is_armed),
        is_on_ground=is_on_ground,
        altitude_m=None if altitude_m is None else _altitude_at(altitude_m, time_s + start_s),
        problems=tuple(dict.fromkeys(problems)),
    )


def _cleaned(channel: Channel, problems: list[UserMessage]) -> Channel:
    """Finite samples in order of time; appends what was left out to `problems`."""
    time_s, values = (np.asarray(column, np.float64) for column in channel)
    is_number = np.isfinite(time_s) & (np.abs(time_s) <= LATEST_S) & np.isfinite(values)
    _note_left_out(marked("Invalid samples left out: {count}."), is_number, problems)
    time_s, values = time_s[is_number], values[is_number]
    is_newest = np.diff(time_s, append=np.inf) != 0  # of samples with equal times
    time_s, values = time_s[is_newest], values[is_newest]
    kept = ascending(time_s)
    _note_left_out(marked("The clock jumps back; samples left out: {count}."), kept, problems)
    return Channel(time_s[kept], values[kept])


def _share_left_out(cleaned: Channel, channel: Channel) -> float:
    """Samples that follow each other with equal times are no loss: the newest is used."""
    counted = int((np.diff(channel.time_s, append=np.inf) != 0).sum())
    return 1 - len(cleaned.time_s) / counted


def _but_joins(gaps: Gaps, joins_s: Floats) -> Gaps:
    """Without those that are only the pause between two flights of one file; rows come up to a report later."""
    is_join = np.zeros(len(gaps), np.bool_)
    for join_s in joins_s.tolist():
        is_join |= (gaps[:, 0] < join_s) & (np.abs(gaps[:, 1] - join_s) <= 1.5 / REPORT_HZ)
    return gaps[~is_join]


def _note_length(duration_s: float, problems: list[UserMessage]) -> None:
    if not SHORTEST_LOG_S <= duration_s <= LONGEST_LOG_S:
        text = marked("The log lasts {seconds:.6g} s, too short or too long for a flight: not judged.")
        problems.append(message(text, seconds=duration_s))


def _note_left_out(text: str, kept: Flags, problems: list[UserMessage]) -> None:
    if not kept.all():
        problems.append(message(text, count=f"{int((~kept).sum()):,}"))


def ascending(time_s: Floats) -> Flags:
    """The rows to keep so that times ascend: drops either rows older than one before them or rows newer than one after
    them, whichever keeps more. Equal times keep the last row."""
    if not len(time_s):
        return np.ones(0, np.bool_)
    is_last = np.append(np.diff(time_s) != 0, np.True_)
    newest_before = np.concatenate(((-np.inf,), np.maximum.accumulate(time_s)[:-1]))
    oldest_after = np.append(np.minimum.accumulate(time_s[::-1])[::-1][1:], np.inf)
    forwards, backwards = (time_s >= newest_before) & is_last, (time_s <= oldest_after) & is_last
    kept: Flags = forwards if forwards.sum() >= backwards.sum() else backwards
    # Equal times that do not follow each other.
    rows = np.flatnonzero(kept)
    kept[rows[:-1][np.diff(time_s[rows]) <= 0]] = False
    return kept


AVERAGED_S: Final = 1.0
REST_G: Final = (0.8, 1.25)
MIN_REST: Final = 0.05
"""Share of the log in which the average must be at rest: over time any aircraft measures 1 g."""
MAX_FALL_S: Final = 10.0
"""An average below 0.8 g for longer is a bad sensor: within 10 s of falling drag brings it back to 1 g."""
DISAGREE_G: Final = 0.3


def believed_force(time_s: Floats, sensors: list[Floats], problems: list[UserMessage]) -> Floats:
    """Combines the sensors' columns (g, NaN without a sample); NaN where none is plausible."""
    checked = [_checked(time_s, sensor, number, problems) for number, sensor in enumerate(sensors, 1)]
    believed = max(checked, key=lambda force_g: int(np.isfinite(force_g).sum()))  # the first of equals
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
    for start_s, end_s in zip(*(times[rows].tolist() for rows in runs(mean_g < REST_G[0])), strict=True):
        if end_s - start_s <= MAX_FALL_S:
            continue
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


def _agreed(time_s: Floats, believed: Floats, other: Floats, problems: list[UserMessage]) -> Floats:
    rows = np.flatnonzero(np.isfinite(believed) & np.isfinite(other))
    if not len(rows):
        return believed
    means_g = [averaged(time_s[rows], force_g[rows], AVERAGED_S) for force_g in (believed, other)]
    matters = np.minimum(*means_g) < REST_G[0]  # sensors may clip an impact at different values
    is_apart = np.zeros(len(believed), np.bool_)
    is_apart[rows[matters & (np.abs(means_g[0] - means_g[1]) > DISAGREE_G)]] = True
    if not is_apart.any():
        return believed
    seconds = float(np.diff(time_s, prepend=time_s[0])[is_apart].clip(max=AVERAGED_S).sum())
    problems.append(
        message(marked("Acceleration sensors differ by over {limit:.1f} g for {seconds:.2f} s; not judged."),
             limit=DISAGREE_G, seconds=seconds)
    )  # fmt: skip
    return np.where(is_apart, np.nan, believed)


def _held(time_s: Floats) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """Ticks of the report rate that are covered by a sample, and the sample of each."""
    firsts = np.ceil(time_s * REPORT_HZ - _TICK).astype(np.int64)
    counts = np.ones(len(firsts), np.int64)
    holds = np.diff(time_s) <= MAX_GAP_S
    counts[:-1][holds] = np.diff(firsts)[holds]
    total = int(counts.sum())
    if total > MAX_ROWS:
        raise unreadable(marked("longer than 48 hours"))
    samples = np.repeat(np.arange(len(firsts)), counts)
    ramp = np.arange(total) - np.repeat(np.cumsum(counts) - counts, counts)
    return firsts[samples] + ramp, samples


def _merged(ticks: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Every tick once; a stable sort merges the ascending arrays."""
    merged = np.sort(np.concatenate(ticks), kind="stable")
    return merged[np.diff(merged, prepend=merged[0] - 1) > 0]


def _column(ticks: NDArray[np.int64], held: NDArray[np.int64], samples: NDArray[np.intp], values: Floats) -> Floats:
    column = np.full(len(ticks), np.nan)
    column[np.searchsorted(ticks, held)] = values[samples]
    return column


def _flags_at(flags: FlagChannel, time_s: Floats) -> Flags:
    order = np.argsort(flags.time_s, kind="stable")
    known_s, values = flags.time_s[order], flags.values[order]
    if not len(values):
        return np.zeros(len(time_s), np.bool_)
    places = np.searchsorted(known_s, time_s + _TICK, "right") - 1
    before = values[0] != flags.is_changes
    return np.where(places < 0, before, values[np.maximum(places, 0)])


def _judged(time_s: Floats, is_armed: Flags | None, is_on_ground: Flags | None) -> Flags:
    """From the first arming until `AFTER_DISARM_S` after disarming, or until it is on the ground."""
    if is_armed is None or not is_armed.any():
        return np.ones(len(time_s), np.bool_)
    armed_s = np.maximum.accumulate(np.where(is_armed, time_s, -np.inf))
    is_judged: Flags = time_s - armed_s <= AFTER_DISARM_S
    if is_on_ground is not None:
        is_judged &= is_armed | ~is_on_ground
    return is_judged


def _disarmed_gaps(time_s: Floats, is_armed: Flags) -> Gaps:
    """The pauses of the whole log that begin disarmed, unless it is never armed."""
    if not is_armed.any():
        return NO_GAPS
    rows = np.flatnonzero((np.diff(time_s) > MAX_GAP_S) & ~is_armed[:-1])
    return np.column_stack((time_s[rows], time_s[rows + 1]))


def _altitude_at(altitude_m: Channel, time_s: Floats) -> Floats:
    """Interpolated between samples within `ALTITUDE_HOLDS_S`; NaN elsewhere."""
    channel = altitude_m
    if not len(channel.time_s):
        return np.full(len(time_s), np.nan)
    after = np.searchsorted(channel.time_s, time_s, "left")
    before = np.maximum(after - 1, 0)
    after = np.minimum(after, len(channel.time_s) - 1)
    is_near = (np.abs(channel.time_s[after] - time_s) <= ALTITUDE_HOLDS_S) & (
        np.abs(channel.time_s[before] - time_s) <= ALTITUDE_HOLDS_S
    )
    return np.where(is_near, np.interp(time_s, channel.time_s, channel.values), np.nan)


def _note_pauses(time_s: Floats, is_judged: Flags, problems: list[UserMessage]) -> None:
    """Appends pauses and time that is not judged to `problems`."""
    steps = np.diff(time_s)
    pauses = steps[steps > MAX_GAP_S]
    if len(pauses):
        problems.append(
            message(
                marked("Pauses: {count}, {total:.1f} s in all, at most {longest:.1f} s."),
                count=len(pauses), total=float(pauses.sum()), longest=float(pauses.max()),
            )
        )  # fmt: skip
    if not is_judged.all():
        left_out_s = float(steps[(steps <= MAX_GAP_S) & ~is_judged[1:]].sum())
        problems.append(message(marked("Not judged: {total:.1f} s on the ground."), total=left_out_s))


def flight_of_reports(
    name: str,
    time_s: Floats,
    tilt_deg: Floats,
    acceleration_g: Floats,
    problems: list[UserMessage],
    resets: Iterable["Marker"] = (),
    *,
    joins_s: Floats | None = None,
    span_s: tuple[float, float] | None = None,
) -> FlightLog:
    """Makes each status report a row. `resets`: by the same clock. Raises `UserError` where there is none.

    `joins_s`: where another recording of the same table begins; the pause before it is none of the module's. `span_s`:
    first and last time of the recording.
    """
    count = len(time_s)
    is_good = np.isfinite(time_s) & (np.abs(time_s) <= LATEST_S) & np.isfinite(tilt_deg) & np.isfinite(acceleration_g)
    newest = np.maximum.accumulate(np.where(is_good, time_s, -np.inf)) if len(time_s) else time_s
    is_good &= time_s >= newest
    _note_left_out(marked("Invalid samples left out: {count}."), is_good, problems)
    time_s, tilt_deg, acceleration_g = time_s[is_good], tilt_deg[is_good], acceleration_g[is_good]
    if not len(time_s):
        raise unreadable(marked("no status reports"))
    start_s, end_s = float(time_s[0]), float(time_s[-1])
    if span_s is not None:
        start_s = min(start_s, span_s[0])
        end_s = max(end_s, span_s[1])
    duration_s = end_s - start_s
    is_judged = np.ones(len(time_s), np.bool_)
    _note_pauses(time_s, is_judged, problems)
    _note_length(duration_s, problems)
    joins_s = np.empty(0) if joins_s is None else joins_s
    tilt_gaps = _but_joins(gaps_between(time_s, start_s, end_s, TILT_GAP_S), joins_s)
    force_gaps = _but_joins(gaps_between(time_s, start_s, end_s, MAX_GAP_S), joins_s)
    return FlightLog(
        name=name,
        time_s=time_s - start_s,
        tilt_deg=tilt_deg.round(_DECIMALS),
        specific_force_g=acceleration_g.round(_DECIMALS),
        is_judged=is_judged,
        duration_s=duration_s,
        tilt_gaps=tilt_gaps - start_s,
        force_gaps=force_gaps - start_s,
        left_out_share=1 - len(time_s) / count,
        resets=tuple(reset._replace(time_s=reset.time_s - start_s) for reset in resets),
        problems=tuple(dict.fromkeys(problems)),
    )
