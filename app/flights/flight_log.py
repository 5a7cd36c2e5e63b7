"""A flight as a module on the aircraft would have measured it, whatever the format of its log.

Every reader yields a `RawLog`: channels with times of their own, by the log's clock, and nothing checked. `assembled`
makes a `FlightLog` of it: one clock, rows at the module's report rate, invalid samples removed. Angles are degrees,
accelerations multiples of g.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Final, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from app.flights.judge import MAX_GAP_S, ROUNDING_S
from app.text.messages import UserError, UserMessage, joined, message
from protocol.translatable import marked

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# Indices, ascending.
Places = NDArray[np.int64]
# Begin and end of each in seconds, shape (number, 2), ascending.
Spans = NDArray[np.float64]
Layout = np.dtype[np.void]
# The records of one kind: a column of numbers for each name, `TIME` in seconds.
Table = dict[str, Floats]
TIME: Final = "time"
STANDARD_GRAVITY_M_S2: Final = 9.80665
# Bytes that are searched for records at once: what may be one takes a multiple of its size in memory.
AT_ONCE: Final = 1 << 18
# Rows per second of a flight that no module measured; the rate of the simulated module.
REPORT_HZ: Final = 50
# Half a report: clocks of logs jitter.
GAP_TOLERANCE_S: Final = 0.01
# A tilt that is shorter than this is not said to be missing: loggers pause for as long.
TILT_GAP_S: Final = 0.2
# No flight is shorter or longer: where a log is, its clock or the unit of its times is wrong.
SHORTEST_LOG_S: Final = 1.0
LONGEST_LOG_S: Final = 24 * 3600.0


def unreadable(why: str) -> UserError:
    """`why` without a full stop, English, marked."""
    return UserError(marked("{why}."), why=message(why))


# What readers yield


class Channel(NamedTuple):
    """Samples of one quantity; times in seconds."""

    time_s: Floats
    values: Floats


class ChannelSource(NamedTuple):
    """The place where logs of a kind have a quantity: in which table, in which columns, and what makes one value of
    these."""

    table: str
    columns: tuple[str, ...]
    value_of: Callable[..., Floats] = np.positive


def channels_of(tables: Mapping[str, Sequence[Table]], sources: Iterable[ChannelSource]) -> list[Channel]:
    """A channel for each table that has the columns, in the order of the sources."""
    return [
        Channel(table[TIME], value_of(*(table[column] for column in columns)))
        for name, columns, value_of in sources
        for table in tables.get(name, ())
        if table.keys() >= {TIME, *columns}
    ]


def columns_of(data: bytes, layout: Layout, places: Places, wanted: Mapping[str, float]) -> Table:
    """Reads binary records, which begin at these places in `data`, where each of them is whole.

    `wanted`: names of columns, and what their numbers are multiplied with. Those that are there are read.
    """
    table: Table = {}
    read = np.frombuffer(data, np.uint8)
    for name, (kind, offset, *_) in (layout.fields or {}).items():
        if name in wanted and kind.kind in "iuf" and len(places):
            # A view of all stretches of the number's length in the file, of which one is picked for each record.
            picked = sliding_window_view(read, kind.itemsize)[places + offset]
            with np.errstate(all="ignore"):  # a damaged number may be any
                table[name] = picked.view(kind)[:, 0].astype(np.float64) * wanted[name]
    return table


@dataclass(slots=True, kw_only=True)
class RawLog:
    """Channels of one quantity are in order of preference."""

    tilts_deg: list[Channel] = field(default_factory=list)
    # The length of the specific force, one channel for each sensor.
    forces_g: list[Channel] = field(default_factory=list)
    altitudes_m: list[Channel] = field(default_factory=list)
    # 0 or not 0; a value holds until the next one, and the first one before it, too.
    armed: list[Channel] = field(default_factory=list)
    # First and last time in the file, where also those without a value are known.
    span_s: tuple[float, float] | None = None
    # An estimate of the time that the damaged end of the file would have held.
    lost_end_s: float = 0.0
    # The samples are the module's own reports: they are used as they are.
    is_of_module: bool = False
    # Where the module that measured lost its state, or another one may have followed.
    resets_s: Floats = field(default_factory=lambda: np.empty(0))
    problems: list[UserMessage] = field(default_factory=list)

    def note(self, text: str, /, **values: object) -> None:
        """Adds a problem; `text` is `marked`."""
        self.problems.append(message(text, **values))

    def note_damage(self, skipped_bytes: int, read_until: int, all_bytes: int) -> None:
        """Says how much of the file was not read, and estimates how long the end was that is missing.

        `read_until`: where the last record ends that was read.
        """
        if skipped_bytes:
            self.note(marked("Damaged; bytes left out: {count}."), count=f"{skipped_bytes:,}")
        times_s = np.concatenate([np.empty(0), *(channel.time_s for channel in (*self.tilts_deg, *self.forces_g))])
        times_s = times_s[np.isfinite(times_s)]
        if len(times_s) and read_until < all_bytes:
            # A damaged time must not stretch it: the first and the last twentieth do not count.
            early_s, late_s = np.quantile(times_s, (0.05, 0.95))
            self.lost_end_s = float(late_s - early_s) / 0.9 * (all_bytes - read_until) / read_until


@np.errstate(all="ignore")
def tilt_of_quaternion(w: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Degrees between the body's and the world's vertical; NaN where the quaternion is not normalised."""
    length = np.sqrt(w * w + x * x + y * y + z * z)
    tilt = np.degrees(2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)))
    return np.where(np.abs(length - 1) <= 0.1, tilt, np.nan)


@np.errstate(all="ignore")
def tilt_of_roll_and_pitch(roll_deg: Floats, pitch_deg: Floats) -> Floats:
    """Degrees between the body's and the world's vertical."""
    product = np.cos(np.radians(roll_deg)) * np.cos(np.radians(pitch_deg))
    tilt: Floats = np.degrees(np.arccos(np.clip(product, -1, 1)))
    return tilt


@np.errstate(all="ignore")
def force_of_axes(x_m_s2: Floats, y_m_s2: Floats, z_m_s2: Floats) -> Floats:
    """Length in g."""
    force: Floats = np.sqrt(x_m_s2 * x_m_s2 + y_m_s2 * y_m_s2 + z_m_s2 * z_m_s2) / STANDARD_GRAVITY_M_S2
    return force


# The flight


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightLog:
    """One flight. All arrays have the same length, one row per report that a module would have sent. Times are seconds
    since the first sample. There are no rows for a time of which nothing was logged."""

    # Path of the file as given.
    name: str
    # The time of its first sample, by its own clock.
    start_s: float = 0.0
    # Ascending.
    time_s: Floats
    # 0 level, 180 upside down; NaN where the attitude is unknown.
    tilt_deg: Floats
    # Length of the specific force, 1 at rest; NaN where it is unknown or the sensor is implausible.
    specific_force_g: Floats
    # False before the first arming and after the landing: these rows are not judged.
    is_judged: Flags
    # From the first sample of the log to its last, including an end that was lost.
    duration_s: float
    # Share of the samples of attitude or acceleration that were left out as invalid, the larger of the two.
    left_out_share: float = 0.0
    # Above any fixed level; NaN where unknown.
    altitude_m: Floats
    resets_s: Floats
    # What was left out or looks wrong.
    problems: tuple[UserMessage, ...] = ()

    @property
    def has_plausible_length(self) -> bool:
        return SHORTEST_LOG_S <= self.duration_s <= LONGEST_LOG_S

    @property
    def flights(self) -> Spans:
        """The time that is judged, both ends of the log included; the rest is on the ground."""
        firsts, lasts = runs(self.is_judged)
        begins_s = self.time_s[firsts]
        begins_s[firsts == 0] = 0.0
        ends_s = np.append(self.time_s, self.duration_s)[lasts + 1]
        return np.column_stack((begins_s, ends_s))

    @property
    def gaps(self) -> tuple[Spans, Spans]:
        """Where in flight no attitude is known for so long that a tilt may be hidden, and no acceleration for so long
        that the module would not go on with a fall."""

        def gaps_of(values: Floats, longest_s: float) -> Spans:
            known_s = self.time_s[np.isfinite(values) & self.is_judged]
            bounds_s = np.sort(np.concatenate((known_s, self.flights.ravel())))
            # What follows the end of a flight is on the ground.
            is_gap = (np.diff(bounds_s) > longest_s + GAP_TOLERANCE_S) & ~np.isin(bounds_s[:-1], self.flights[:, 1])
            return np.column_stack((bounds_s[:-1][is_gap], bounds_s[1:][is_gap]))

        return gaps_of(self.tilt_deg, TILT_GAP_S), gaps_of(self.specific_force_g, MAX_GAP_S)

    @property
    def not_judged_s(self) -> float:
        """Time for which at least one trigger was not judged, whatever the reason, both ends of the log included."""
        if not self.has_plausible_length:
            return round(self.duration_s, 6)
        gaps = np.concatenate(self.gaps)
        begins_s, ends_s = gaps[np.argsort(gaps[:, 0])].T
        # What gaps have in common counts once.
        reached_s = np.maximum.accumulate(np.concatenate(((0.0,), ends_s)))[:-1]
        in_gaps_s = float(np.clip(ends_s - np.maximum(begins_s, reached_s), 0, None).sum())
        return round(self.duration_s - total_s(self.flights) + in_gaps_s, 6)


def total_s(spans: Spans) -> float:
    return float((spans[:, 1] - spans[:, 0]).sum())


def runs(holds: Flags, restarts: Flags | np.bool_ = np.False_) -> tuple[Places, Places]:
    """First and last row of each run of rows in which `holds` is true; a row of `restarts` begins another run."""
    continues = holds & ~restarts
    continues[1:] &= holds[:-1]
    continues[:1] = False
    return np.flatnonzero(holds & ~continues), np.flatnonzero(holds & ~np.append(continues[1:], np.False_))


# How a flight is made

_MAX_ROWS: Final = 48 * 3600 * REPORT_HZ
# Latest plausible time, since boot or since 1970.
_LATEST_S: Final = 1e10
# Also judged after disarming: an aircraft whose motors stop in the air still falls.
_AFTER_DISARM_S: Final = 5.0
# A sample that stands so far behind its place is late; a step back of more is a clock that jumps.
_LATE_S: Final = 1.0
_TICK: Final = 1e-6


def assembled(raw: RawLog, name: str) -> FlightLog:
    """Makes the flight of a raw log. Raises `UserError` where neither attitude nor acceleration can be judged."""
    # Of the attitudes the first that is usable, and of all sensors what can be believed.
    tilts = list(islice(_usable(raw.tilts_deg, raw, is_tilt=True), 1))
    forces = list(_usable(raw.forces_g, raw, is_tilt=False))
    if not tilts and not forces:
        raise unreadable(marked("no attitude and no acceleration"))
    if not tilts:
        raw.note(marked("No attitude: attitude trigger not judged."))
    if not forces:
        raw.note(marked("No acceleration: free-fall trigger not judged."))
    bounds_s = np.concatenate([raw.span_s or (), *(sensor.time_s[[0, -1]] for sensor, _ in (*tilts, *forces))])
    start_s = float(bounds_s.min())
    held = [_held(sensor, start_s, raw, is_tilt=True) for sensor, _ in tilts]
    held += [_held(sensor, start_s, raw, is_tilt=False) for sensor, _ in forces]
    time_s = np.unique(np.concatenate([channel.time_s for channel in held]))
    unknown = np.full(len(time_s), np.nan)
    columns = [unknown.copy() for _ in held]
    for column, channel in zip(columns, held, strict=True):
        column[np.searchsorted(time_s, channel.time_s)] = channel.values
    tilt_deg = columns.pop(0) if tilts else unknown
    force_g = _believed_force(time_s, columns, raw) if forces else unknown
    log = FlightLog(
        name=name,
        start_s=start_s,
        time_s=time_s,
        tilt_deg=tilt_deg,
        specific_force_g=force_g,
        is_judged=_judged(raw.armed, time_s, start_s),
        duration_s=float(bounds_s.max()) - start_s + raw.lost_end_s,
        left_out_share=max([share for _, share in tilts] + sorted(share for _, share in forces)[:1]),
        altitude_m=_altitude_at(raw.altitudes_m, time_s + start_s),
        resets_s=raw.resets_s - start_s,
    )
    if not (log.is_judged & (np.isfinite(tilt_deg) | np.isfinite(force_g))).any():
        raise UserError(joined(raw.problems, " "))
    if not log.is_judged.all():
        raw.note(marked("Not judged: {total:.1f} s on the ground."), total=log.duration_s - total_s(log.flights))
    if not log.has_plausible_length:
        text = marked("The log lasts {seconds:.6g} s, too short or too long for a flight: not judged.")
        raw.note(text, seconds=log.duration_s)
    return replace(log, problems=tuple(dict.fromkeys(raw.problems)))


def _usable(channels: Iterable[Channel], raw: RawLog, *, is_tilt: bool) -> Iterator[tuple[Channel, float]]:
    """Yields the channels with valid samples, and of these no others, in order of time; and which share of the samples
    was left out."""
    for time_s, values in channels:
        is_number = np.isfinite(time_s) & (np.abs(time_s) <= _LATEST_S) & np.isfinite(values)
        if not is_number.all():
            raw.note(marked("Invalid samples left out: {count}."), count=f"{(~is_number).sum():,}")
        # Of samples with equal times the last one is used, and of tilts the largest; the others are no loss.
        known_s, known = time_s[is_number], values[is_number]
        if not (np.diff(known_s) < -_LATE_S).any():
            order = np.argsort(known_s, kind="stable")
            known_s, known = known_s[order], known[order]
        places = np.flatnonzero(np.diff(known_s, prepend=np.inf))
        known_s = known_s[places]
        known = np.maximum.reduceat(known, places) if is_tilt else known[np.append(places, len(known))[1:] - 1]
        is_kept = _ascending(known_s)
        if not is_kept.all():
            raw.note(marked("The clock jumps back; samples left out: {count}."), count=f"{(~is_kept).sum():,}")
        if is_kept.any():
            with np.errstate(invalid="ignore"):
                count = np.count_nonzero(np.diff(time_s, append=np.inf))
            yield Channel(known_s[is_kept], known[is_kept]), 1 - np.count_nonzero(is_kept) / count


def _ascending(time_s: Floats) -> Flags:
    """The rows to keep so that times ascend: drops either rows older than one before them or rows newer than one after
    them, whichever keeps more."""
    newest_before = np.maximum.accumulate(np.append(-np.inf, time_s))[:-1]
    oldest_after = np.minimum.accumulate(np.append(time_s, np.inf)[::-1])[::-1][1:]
    forwards, backwards = time_s > newest_before, time_s < oldest_after
    kept: Flags = forwards if forwards.sum() >= backwards.sum() else backwards
    return kept


def _held(sensor: Channel, start_s: float, raw: RawLog, *, is_tilt: bool) -> Channel:
    """A sample for each report: the newest one before it, none in a pause that is too long. Of several tilts since the
    report before, the largest: one that would fire must not fall between two rows."""
    time_s = sensor.time_s - start_s
    if raw.is_of_module:
        return Channel(time_s, sensor.values)
    ticks = np.ceil(time_s * REPORT_HZ - _TICK).astype(np.int64)
    counts = np.ones(len(ticks), np.int64)
    goes_on = np.diff(time_s) <= (TILT_GAP_S if is_tilt else MAX_GAP_S) + GAP_TOLERANCE_S
    counts[:-1][goes_on] = np.diff(ticks)[goes_on]
    if counts.sum() > _MAX_ROWS:
        raise unreadable(marked("longer than 48 hours"))
    rows = np.repeat(np.arange(len(ticks)), counts)
    number_of_sample = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    values = sensor.values[rows]
    if is_tilt:
        first_of_tick = np.flatnonzero(np.diff(ticks, prepend=ticks[0] - 1))
        values[number_of_sample == 0] = np.maximum.reduceat(sensor.values, first_of_tick)
    return Channel((ticks[rows] + number_of_sample) / REPORT_HZ, values)


def _judged(armed: list[Channel], time_s: Floats, start_s: float) -> Flags:
    """Return the rows that are judged: from the first arming until `_AFTER_DISARM_S` after disarming; everything where
    the log does not say."""
    channel = next((channel for channel in armed if len(channel.time_s)), None)
    if channel is None:
        return np.ones(len(time_s), np.bool_)
    order = np.argsort(channel.time_s, kind="stable")
    places = np.searchsorted(channel.time_s[order], time_s + start_s + _TICK, "right") - 1
    is_armed = channel.values[order][np.maximum(places, 0)] != 0
    if not is_armed.any():
        return np.ones(len(time_s), np.bool_)
    armed_s = np.maximum.accumulate(np.where(is_armed, time_s, -np.inf))
    is_judged: Flags = time_s - armed_s <= _AFTER_DISARM_S
    # A pause that begins disarmed is on the ground, as where only flights are logged.
    is_judged[:-1] &= is_armed[:-1] | (np.diff(time_s) <= MAX_GAP_S)
    return is_judged


def _altitude_at(channels: list[Channel], time_s: Floats) -> Floats:
    """Interpolated; NaN before the first and after the last sample, and where the log does not say."""
    for channel in channels:
        rows = np.flatnonzero(np.isfinite(channel.time_s) & np.isfinite(channel.values))
        rows = rows[_ascending(channel.time_s[rows])]
        if len(rows):
            known_s, known_m = channel.time_s[rows], channel.values[rows]
            altitude_m: Floats = np.interp(time_s, known_s, known_m, left=np.nan, right=np.nan)
            return altitude_m
    return np.full(len(time_s), np.nan)


# Which sensors are believed

_AVERAGED_S: Final = 1.0
_REST_G: Final = (0.8, 1.25)
# Share of the log in which the average must be at rest: over time any aircraft measures 1 g.
_MIN_REST: Final = 0.05
# An average below 0.8 g for longer is a bad sensor: within 10 s of falling drag brings it back to 1 g.
_MAX_FALL_S: Final = 10.0
_DISAGREE_G: Final = 0.3


def _believed_force(time_s: Floats, sensors: list[Floats], raw: RawLog) -> Floats:
    """Combines the sensors' columns (g, NaN without a sample); NaN where none is plausible."""
    if raw.is_of_module:
        return sensors[0]
    checked = [_checked(time_s, force_g, number, raw) for number, force_g in enumerate(sensors, 1)]
    chosen = max(checked, key=lambda force_g: np.count_nonzero(np.isfinite(force_g)))  # the first of equals
    believed = chosen.copy()
    for other in (one for one in checked if one is not chosen):
        rows = np.flatnonzero(np.isfinite(believed) & np.isfinite(other))
        mean_g, other_mean_g = (_averaged(time_s[rows], force_g[rows]) for force_g in (believed, other))
        # Only where one of them falls: sensors may clip an impact at different values.
        matters = np.minimum(mean_g, other_mean_g) < _REST_G[0]
        apart = rows[matters & (np.abs(mean_g - other_mean_g) > _DISAGREE_G)]
        if len(apart):
            steps_s = np.diff(time_s, prepend=time_s[0])[apart].clip(max=_AVERAGED_S)
            text = marked("Acceleration sensors differ by over {limit:.1f} g for {seconds:.2f} s; not judged.")
            raw.note(text, limit=_DISAGREE_G, seconds=float(steps_s.sum()))
            believed[apart] = np.nan
    return believed


def _checked(time_s: Floats, force_g: Floats, number: int, raw: RawLog) -> Floats:
    """Return the samples without those of a sensor with a wrong scale, or of one that is stuck."""
    rows = np.flatnonzero(np.isfinite(force_g))
    times_s, mean_g = time_s[rows], _averaged(time_s[rows], force_g[rows])
    if ((mean_g >= _REST_G[0]) & (mean_g <= _REST_G[1])).mean() < _MIN_REST:
        text = marked("Acceleration sensor {number} never rests at 1 g (median {median:.2f} g); not judged.")
        raw.note(text, number=number, median=float(np.median(force_g[rows])))
        return np.full(len(force_g), np.nan)
    believed = force_g.copy()
    for first, last in zip(*runs(mean_g < _REST_G[0]), strict=True):
        start_s, end_s = float(times_s[first]), float(times_s[last])
        if end_s - start_s > _MAX_FALL_S:
            is_bad = (time_s >= start_s - _AVERAGED_S) & (time_s <= end_s)
            text = marked("Acceleration sensor {number} stuck for {seconds:.0f} s from {start:.1f} s; not judged.")
            raw.note(text, number=number, seconds=end_s - start_s, start=start_s)
            believed[is_bad] = np.nan
    return believed


def _averaged(time_s: Floats, values: Floats) -> Floats:
    """Mean of the last `_AVERAGED_S`, both ends included, since a pause."""
    is_first = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    since_pause = np.maximum.accumulate(np.where(is_first, np.arange(len(time_s)), 0))
    firsts = np.maximum(np.searchsorted(time_s, time_s - (_AVERAGED_S + ROUNDING_S), "left"), since_pause)
    sums, stops = np.concatenate(((0.0,), np.cumsum(values))), np.arange(1, len(values) + 1)
    mean: Floats = (sums[stops] - sums[firsts]) / (stops - firsts)
    return mean
