"""The visible time span of the plots, and the cursor in it."""

import math
from typing import Final

from PySide6.QtCore import QObject, Signal

from ui.plots.lanes import Span

_SHORTEST_S: Final = 0.03
"""Limit of zooming in: some forty status frames at line rate."""
_LONGEST_S: Final = 10 * 3600.0
"""Limit of panning back: what a series keeps."""


class TimeRange(QObject):
    """The only place that moves span and cursor.

    Live the span ends now and is as long as was chosen; pausing, panning and zooming hold a span until `back_to_live`.
    `bounds` are those of a recording, which has no live end to follow; at first all of it is in sight.
    """

    changed = Signal()

    def __init__(self, bounds: Span | None) -> None:
        super().__init__()
        self.now_s = 0.0
        self.width_px = 1.0
        """Of the plots, in device pixels."""
        self.cursor: float | None = None
        """The place of the cursor within the span, 0 to 1."""
        self._live_s = 60.0
        self._held: Span | None = None
        self._bounds = bounds
        if bounds is not None and bounds.length_s < _SHORTEST_S:
            middle_s = (bounds.start_s + bounds.end_s) / 2
            self._bounds = Span(middle_s - _SHORTEST_S / 2, middle_s + _SHORTEST_S / 2)

    @property
    def is_recorded(self) -> bool:
        return self._bounds is not None

    @property
    def is_live(self) -> bool:
        return self._held is None and self._bounds is None

    @property
    def is_whole(self) -> bool:
        """Whether all of a recording is in sight."""
        return self._bounds is not None and self.span.length_s >= self._bounds.length_s * (1 - 1e-9)

    @property
    def span(self) -> Span:
        return self.span_at(self.now_s)

    def span_at(self, now_s: float) -> Span:
        """What is in sight then; live it moves by whole pixels, so that lines do not flicker."""
        return self._held or self._bounds or self._live_span(now_s)

    def _live_span(self, now_s: float) -> Span:
        pixel_s = self._live_s / self.width_px
        end_s = math.ceil(max(now_s, self.now_s) / pixel_s) * pixel_s
        return Span(end_s - self._live_s, end_s)

    @property
    def pixel_s(self) -> float:
        """Seconds per device pixel."""
        return self.span.length_s / self.width_px

    @property
    def cursor_s(self) -> float | None:
        return None if self.cursor is None else self.span.start_s + self.cursor * self.span.length_s

    def follow(self, now_s: float) -> None:
        """The newest samples are of this monotonic time."""
        self.now_s = max(self.now_s, now_s)

    # What a person does

    def toggle_pause(self) -> None:
        """Pauses, or goes back to live; no effect on a recording."""
        if self.is_live:
            self._hold(self.span)
        elif not self.is_recorded:
            self.back_to_live()

    def back_to_live(self) -> None:
        """Follows the newest samples in the chosen length, or shows all of a recording."""
        self._held = None
        self.changed.emit()

    def choose_length(self, length_s: float) -> None:
        """Sets the length of the time line; a held span keeps its end, that of a recording its middle."""
        span, self._live_s = self.span, length_s
        if self.is_live:
            self.changed.emit()
        else:
            later_s = (length_s - span.length_s) / 2 if self.is_recorded else 0.0
            self._hold(Span(span.end_s + later_s - length_s, span.end_s + later_s))

    def show_instant(self, time_s: float) -> None:
        """Pauses with `time_s` and the cursor in the middle."""
        length_s = min(self.span.length_s, self._live_s) if self.is_whole else self.span.length_s
        self._hold(Span(time_s - length_s / 2, time_s + length_s / 2))
        self.point_at(time_s)

    def pan(self, part: float, cursor: float | None = None) -> None:
        """By a part of the span, negative to the past; the cursor moves within the span if it is given."""
        span = self.span
        self.cursor = self.cursor if cursor is None else cursor
        self._hold(Span(span.start_s + part * span.length_s, span.end_s + part * span.length_s))

    def zoom(self, factor: float, part: float) -> None:
        """Shows `factor` times as much time around a part of the span."""
        span = self.span
        factor = max(factor, _SHORTEST_S / span.length_s)
        start_s = span.start_s + part * (1 - factor) * span.length_s
        self._hold(Span(start_s, start_s + factor * span.length_s))

    def point(self, part: float | None) -> None:
        """Puts the cursor at a part of the span, or nowhere; in a recording, whose numbers it chooses, it stays."""
        if part is None and self.is_recorded:
            return
        part = None if part is None else min(1.0, max(0.0, part))
        if part != self.cursor:
            self.cursor = part
            self.changed.emit()

    def point_at(self, time_s: float) -> None:
        self.point((time_s - self.span.start_s) / self.span.length_s)

    def _hold(self, span: Span) -> None:
        """Shows `span`, as far as there are data."""
        live_end_s = self._live_span(self.now_s).end_s
        first_s, last_s = self._bounds or (live_end_s - _LONGEST_S, live_end_s)
        length_s = min(span.length_s, last_s - first_s)
        end_s = max(min(span.end_s, last_s), first_s + length_s)
        self._held = Span(end_s - length_s, end_s)
        self.changed.emit()
