"""What was measured, live or recorded: series, limits over time, markers; an excerpt of it and its CSV table.

Times are seconds of the program's clock.
"""

import csv
from collections.abc import Iterator, Sequence
from heapq import merge
from io import StringIO
from itertools import islice
from math import inf
from operator import itemgetter
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.engine.target import is_simulated
from app.recordings.markers import STATE_LOST, Marker, MarkerKind, ModuleLimits
from app.samples.samples import Readable, StepFunction, Window

# Bits of `Excerpt.flags`.
ACTIVE, TRIGGERED = 0x01, 0x02
HEAD: Final = "time_utc,elapsed_s,tilt_deg,acceleration_g,triggered,active,charging,cell_voltage_v,light_v,event"
# Rows per part, about 10 ms: how often a cancellation is checked.
ROWS_AT_ONCE: Final = 5000
# It is asked for once a second.
CHARGING_HOLDS_S: Final = 5.0
_FLAGS: Final = ("false", "true")


class Excerpt(NamedTuple):
    tilt: Window
    # Its times, and those of `flags`, are those of `tilt`.
    acceleration: Window
    flags: NDArray[np.uint8]
    cell: Window
    light: Window
    # Whether there was external power, also from `CHARGING_HOLDS_S` before the span.
    charging: Window
    markers: tuple[Marker, ...]
    # False where the span includes times that are no longer kept sample by sample.
    is_whole: bool = True

    @property
    def row_count(self) -> int:
        return sum(len(times) for times, _ in (self.tilt, self.cell, self.light)) + len(self.markers)


class LimitSteps:
    """The limits of a module over time."""

    def __init__(self) -> None:
        self._steps = [StepFunction() for _ in ModuleLimits._fields]
        self.fires, self.rearms, self.falls, self.fall_times, self.lights = self._steps

    def put(self, at: float, limits: ModuleLimits) -> None:
        for steps, value in zip(self._steps, limits, strict=True):
            steps.put(at, value)

    def last(self) -> ModuleLimits:
        """What was last known of each."""
        known = ([step.value for step in steps.between(-inf, inf) if step.value is not None] for steps in self._steps)
        return ModuleLimits(*(values[-1] if values else None for values in known))

    def clear(self) -> None:
        for steps in self._steps:
            steps.clear()


class Measured(LimitSteps):
    """Source of the plots: the current session, or a recording."""

    tilt: Readable
    acceleration: Readable
    cell: Readable
    light: Readable
    charging: Readable
    # A value for each sample of tilt.
    flags: Readable
    markers: Sequence[Marker]

    def charging_at(self, time_s: float) -> bool | None:
        """Whether there was external power; None: unknown."""
        states = self.charging.window(time_s - CHARGING_HOLDS_S, time_s).value
        return bool(states[-1]) if len(states) else None

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """The data of a span, both ends included, as views of the series."""
        # Of the marks before it, that the module is simulated, and its name, hold on.
        held: dict[MarkerKind, Marker] = {}
        for marker in self.markers:
            if marker.time_s >= start_s:
                break
            if marker.kind in STATE_LOST:
                held.pop(MarkerKind.NAMED, None)
            if marker.kind is MarkerKind.CONNECTED:
                held.clear()
            if marker.kind is MarkerKind.NAMED or (marker.kind is MarkerKind.CONNECTED and is_simulated(marker.text)):
                held[marker.kind] = marker._replace(time_s=start_s)
        within = [marker for marker in self.markers if start_s <= marker.time_s <= end_s]
        tilt, acceleration, flags, cell, light = (
            series.window(start_s, end_s)
            for series in (self.tilt, self.acceleration, self.flags, self.cell, self.light)
        )
        charging = self.charging.window(start_s - CHARGING_HOLDS_S, end_s)
        markers = (*held.values(), *within)
        return Excerpt(tilt, acceleration, flags.value.astype(np.uint8), cell, light, charging, markers)


# The CSV table


def part_count(excerpt: Excerpt) -> int:
    return excerpt.row_count // ROWS_AT_ONCE + 2


def csv_parts(excerpt: Excerpt, *, wall_offset_s: float) -> Iterator[bytes]:
    """Yields the table in UTF-8, in parts.

    Status reports, cell voltage, light and events have rows of their own, in order of time; other cells are empty.
    `wall_offset_s` added to the times gives seconds since 1970; `elapsed_s` counts from the first row.
    """
    yield f"{HEAD}\r\n".encode()
    # Of each row its time and the further cells but charging.
    others = [(at, ("", "", "", "", f"{volts:.2f}", "", "")) for at, volts in zip(*excerpt.cell, strict=True)]
    others += [(at, ("", "", "", "", "", f"{volts:.1f}", "")) for at, volts in zip(*excerpt.light, strict=True)]
    for marker in excerpt.markers:
        # "connected: /dev/ttyUSB0"; in English, as in all files.
        simulated = " (simulated)" if is_simulated(marker.text) else ""
        event = f"{marker.kind.value}: {marker.text}{simulated}" if marker.text else marker.kind.value
        others.append((marker.time_s, ("", "", "", "", "", "", event)))
    others.sort()
    first_s = min([*excerpt.tilt.time_s[:1].tolist(), *(at for at, _ in others[:1])], default=0.0)
    charging = Readable(*excerpt.charging)

    def reports() -> Iterator[tuple[float, tuple[str, ...]]]:
        columns = (*excerpt.tilt, excerpt.acceleration.value, excerpt.flags)
        for first in range(0, len(excerpt.flags), ROWS_AT_ONCE):
            part = (column[first : first + ROWS_AT_ONCE].tolist() for column in columns)
            for at, tilt, force, flags in zip(*part, strict=True):
                is_triggered, is_active = _FLAGS[flags & TRIGGERED != 0], _FLAGS[flags & ACTIVE != 0]
                yield at, (f"{tilt:g}", f"{force:.1f}", is_triggered, is_active, "", "", "")

    rows = merge(reports(), others, key=itemgetter(0))
    while batch := list(islice(rows, ROWS_AT_ONCE)):
        # As spreadsheets take them: UTC to the millisecond.
        wall_ms = np.rint((np.array([at for at, _ in batch]) + wall_offset_s) * 1000)
        stamps = np.char.replace(np.datetime_as_string(wall_ms.astype("M8[ms]")), "T", " ").tolist()
        text = StringIO()
        lines = csv.writer(text)
        for stamp, (at, cells) in zip(stamps, batch, strict=True):
            last = charging.window(at - CHARGING_HOLDS_S, at).value[-1:].tolist()
            is_charging = _FLAGS[last[0] != 0] if last else ""
            lines.writerow((stamp, f"{at - first_s:.3f}", *cells[:4], is_charging, *cells[4:]))
        yield text.getvalue().encode(errors="backslashreplace")  # a name may have bytes that are no text
