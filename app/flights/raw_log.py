"""What every reader of a log yields: tables of records, and of these the channels of what is judged.

Each channel has its own times, by the log's clock. Nothing is checked yet: see `app.flights.assembly`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from app.text.messages import UserError, UserMessage, message
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.recordings.markers import Marker

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# Indices, ascending.
Places = NDArray[np.int64]
Layout = np.dtype[np.void]
Table = dict[str, Floats]
"""The records of one kind: a column of numbers for each name, `TIME` in seconds."""
TIME: Final = "time"
STANDARD_GRAVITY_M_S2: Final = 9.80665
AT_ONCE: Final = 1 << 18
"""Bytes that are searched for records: what may be one takes a multiple of its size in memory."""


def unreadable(why: str) -> UserError:
    """`why` without a full stop, English, marked."""
    return UserError(marked("{why}."), why=message(why))


class Channel(NamedTuple):
    """Samples of one quantity; times in seconds."""

    time_s: Floats
    values: Floats


class ChannelSource(NamedTuple):
    """Where logs of a kind have a quantity: in which table, in which columns, and what makes one value of these."""

    table: str
    columns: tuple[str, ...]
    value_of: Callable[..., Floats] = np.positive


def channels_of(tables: Mapping[str, Sequence[Table]], sources: Iterable[ChannelSource]) -> list[Channel]:
    """A channel for each table that has the columns, in the order of the sources."""
    found: list[Channel] = []
    for name, columns, value_of in sources:
        for table in tables.get(name, ()):
            if TIME in table and all(column in table for column in columns):
                values = value_of(*(table[column] for column in columns))
                found.append(Channel(table[TIME], values))
    return found


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

    name: str
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
    resets: "tuple[Marker, ...]" = ()
    problems: list[UserMessage] = field(default_factory=list)

    def note(self, text: str, /, **values: object) -> None:
        """Adds a problem; `text` is `marked`."""
        self.problems.append(message(text, **values))

    def note_damage(self, skipped_bytes: int, read_until: int, all_bytes: int) -> None:
        """Says how much of the file was not read, and estimates how long the end was that is missing.

        `read_until`: where the last record ends that was read.
        """
        if not skipped_bytes:
            return
        self.note(marked("Damaged; bytes left out: {count}."), count=f"{skipped_bytes:,}")
        times_s = np.concatenate([np.empty(0), *(channel.time_s for channel in (*self.tilts_deg, *self.forces_g))])
        times_s = times_s[np.isfinite(times_s)]
        if len(times_s):
            # A damaged time must not stretch it: the first and the last twentieth do not count.
            early_s, late_s = np.quantile(times_s, (0.05, 0.95))
            self.lost_end_s = float(late_s - early_s) / 0.9 * (all_bytes - read_until) / read_until


def kept_apart(time_s: Floats) -> Floats:
    """Ascending times of a module's reports, of which several may have the same: a nanosecond later each."""
    number_of_report = np.arange(len(time_s)) - np.searchsorted(time_s, time_s)
    return time_s + number_of_report * 1e-9


def tilt_of_quaternion(w: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Degrees between the body's and the world's vertical; NaN where the quaternion is not normalised."""
    with np.errstate(all="ignore"):
        length = np.sqrt(w * w + x * x + y * y + z * z)
        tilt = np.degrees(2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)))
    return np.where(np.abs(length - 1) <= 0.1, tilt, np.nan)


def tilt_of_roll_and_pitch(roll_deg: Floats, pitch_deg: Floats) -> Floats:
    """Degrees between the body's and the world's vertical."""
    with np.errstate(all="ignore"):
        product = np.cos(np.radians(roll_deg)) * np.cos(np.radians(pitch_deg))
    tilt: Floats = np.degrees(np.arccos(np.clip(product, -1, 1)))
    return tilt


def force_of_axes(x_m_s2: Floats, y_m_s2: Floats, z_m_s2: Floats) -> Floats:
    """Length in g."""
    with np.errstate(all="ignore"):
        force: Floats = np.sqrt(x_m_s2 * x_m_s2 + y_m_s2 * y_m_s2 + z_m_s2 * z_m_s2) / STANDARD_GRAVITY_M_S2
    return force
