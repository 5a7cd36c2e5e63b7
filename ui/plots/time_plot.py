"""Plots several quantities over time, with limits, markers and a cursor.

The page fills the series, adds marks, and calls `draw`. Importing this module loads numpy, so import it after the
window's first paint.
"""

import math
import time
from collections import deque
from collections.abc import Hashable, Iterable, Sequence
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.plots.axis import before_now, clock_times
from ui.plots.canvas import Canvas
from ui.plots.header import PlotHeader
from ui.plots.limits import limit_picture
from ui.plots.paint import Picture, cursor_time, reading
from ui.plots.view import Lane, Mark, Span, TimeView
from ui.style.theme import Space, current
from ui.widgets.layouts import in_column
from ui.widgets.visibility_timer import VisibilityTimer

# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
# Room for the label of a tick.
_TICK_PX: Final = 84


class TimePlot(QWidget):
    """The stack of plots with its controls.

    `lanes` from top to bottom. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970.
    `bounds` are those of a recording, which has no live end to follow. The page may add controls to `header`.
    """

    cursor_moved = Signal()
    """`cursor_s` changed."""

    def __init__(
        self,
        lanes: Sequence[Lane],
        texts: Texts,
        *,
        wall_offset_s: float | None = None,
        bounds: Span | None = None,
    ) -> None:
        super().__init__()
        self.setObjectName("time-plot")
        self._view = TimeView(bounds=bounds)
        self._marks: deque[Mark] = deque(maxlen=_MAX_MARKS)
        self._wall_offset_s = time.time() - time.monotonic() if wall_offset_s is None else wall_offset_s
        self._now_s = 0.0
        self._shows_clock = False
        self.reading = ""
        """The values at the cursor in words."""
        self.cursor_s: float | None = None
        self._drawn: Hashable = None
        """What the last picture depended on; None: it has to be drawn again."""
        self._canvas = Canvas(lanes)
        self._canvas.retains_cursor = bounds is not None
        self._head = PlotHeader(texts, self._view)
        self.header, self.pause = self._head.row, self._head.pause
        in_column(self._head, (self._canvas, 1), of=self, spacing=Space.XS, margins=0)
        self.setMinimumHeight(144)
        self._connect(texts)
        self.apply_theme()
        VisibilityTimer(self, retranslate=self._retranslate, restyle=self.apply_theme)

    def be_at(self, wall_offset_s: float) -> None:
        """Sets the offset of wall time for new samples; see the class."""
        self._wall_offset_s = wall_offset_s
        self._drawn = None

    def _connect(self, texts: Texts) -> None:
        texts.bind(self._canvas.setAccessibleName, "Plots")
        texts.bind(self._canvas.setToolTip, "Arrow keys move, + and − zoom, Shift with arrow keys reads off")
        self._canvas.setToolTipDuration(4000)
        self._canvas.panned.connect(self._pan)
        self._canvas.zoomed.connect(self._zoom)
        self._canvas.pause_wanted.connect(self.toggle_pause)
        self._canvas.live_wanted.connect(self.back_to_live)
        self._canvas.cursor_moved.connect(self._redraw)
        self._head.toggle_wanted.connect(self.toggle_pause)
        self._head.whole_wanted.connect(self.back_to_live)
        self._head.clock_toggled.connect(self.show_clock_time)
        self._head.window_chosen.connect(self.choose_window)

    def _retranslate(self) -> None:
        self._canvas.arrange()
        self._redraw()

    @property
    def is_live(self) -> bool:
        """Whether it follows the newest samples."""
        return self._view.is_live

    @property
    def span(self) -> Span:
        """The time span in sight."""
        return self._view.span(self._now_s)

    @property
    def pixel_s(self) -> float:
        """Seconds per device pixel."""
        return self.span.length_s / max(1.0, self._canvas.axis.width() * self._canvas.devicePixelRatio())

    @property
    def is_recorded(self) -> bool:
        """Whether it shows a recording."""
        return self._view.is_recorded

    def add_mark(self, mark: Mark) -> None:
        """Adds a mark, drawn with the next `draw`."""
        self._marks.append(mark)
        self._drawn = None

    def add_marks(self, marks: Iterable[Mark]) -> None:
        """Adds the marks of a recording."""
        self._marks.extend(marks)
        self._drawn = None

    def reset(self) -> None:
        """Removes all marks and goes back to live, for another module."""
        self._marks.clear()
        self.back_to_live()

    def draw(self, now_s: float) -> None:
        """Draws everything as of a monotonic time."""
        self._now_s = max(self._now_s, now_s)
        self._redraw()

    def is_due(self, now_s: float) -> bool:
        """Whether `draw` would change the picture: it moved by a pixel, or something else changed."""
        return self._appearance_key(max(self._now_s, now_s)) != self._drawn

    def show_age(self, now_s: float) -> None:
        """Updates how far a paused picture is behind, without drawing."""
        self._now_s = max(self._now_s, now_s)
        self._head.show_view(self._now_s)

    def toggle_pause(self) -> None:
        """Pauses, or goes back to live; no effect on a recording."""
        if self._view.is_recorded:
            return
        if self._view.is_live:
            self._view.hold(self._now_s)
            self._redraw()
        else:
            self.back_to_live()

    def back_to_live(self) -> None:
        """Follows the newest samples in the chosen length, or shows all of a recording."""
        self._view.follow_live()
        self._canvas.fit_scales()
        self._redraw()

    def show_instant(self, time_s: float) -> None:
        """Pauses with `time_s` and the cursor in the middle."""
        self._view.show_instant(time_s, now_s=self._now_s)
        self.point_at(time_s)
        self._redraw()

    def point_at(self, time_s: float) -> None:
        """Puts the cursor at a time in sight."""
        span = self.span
        self._canvas.set_cursor((time_s - span.start_s) / span.length_s)

    def choose_window(self, window_s: float) -> None:
        """Sets the length of the time line."""
        self._view.choose(window_s, now_s=self._now_s)
        self._canvas.fit_scales()
        self._redraw()

    def show_clock_time(self, shows_clock: bool, /) -> None:
        """Labels the time line with the time of day, or with seconds before now."""
        self._shows_clock = shows_clock
        self._head.clock.setChecked(shows_clock)
        self._redraw()

    def picture(self) -> QPixmap:
        """The plots as a picture."""
        one: QPixmap = self._canvas.grab()
        return one

    def apply_theme(self) -> None:
        """Applies the theme in use."""
        self._canvas.apply_theme(current())
        self._canvas.arrange()
        self._redraw()

    def _pan(self, part: float) -> None:
        self._view.pan(part * self.span.length_s, now_s=self._now_s)
        self._redraw()

    def _zoom(self, factor: float, part: float) -> None:
        span = self.span
        self._view.zoom(factor, at_s=span.start_s + part * span.length_s, now_s=self._now_s)
        self._canvas.fit_scales()
        self._redraw()

    def _appearance_key(self, now_s: float) -> Hashable:
        """What the picture depends on and may change by itself."""
        span = self._pixel_aligned(self._view.span(now_s))
        lanes = [lane.lane for lane in self._canvas.all_lanes]
        limits = tuple(
            (limit.steps.value, None if limit.stale is None else limit.stale.value)
            for lane in lanes
            for limit in lane.limits
        )
        if self._view.is_live:  # new samples are within the last pixel
            return span, limits
        newest = (lane.series.last for lane in lanes)
        return span, limits, tuple(None if one is None else min(one.time_s, span.end_s) for one in newest)

    def _redraw(self) -> None:
        self._drawn = self._appearance_key(self._now_s)
        span = self._pixel_aligned(self.span)
        self._canvas.draw_curves(span)
        most = max(2, int(self._canvas.axis.width() / _TICK_PX))
        # A paused picture is labelled by the clock: "10 s before now" would soon be wrong.
        if self._view.is_live and not self._shows_clock:
            ticks = before_now(span, most=most)
        else:
            ticks = clock_times(span, most=most, wall_offset_s=self._wall_offset_s)
        part = self._canvas.cursor_part
        cursor_s = None if part is None else span.start_s + part * span.length_s
        picture = Picture(
            theme=current(),
            lanes=self._canvas.lanes,
            span=span,
            now_s=self._now_s,
            ticks=ticks,
            marks=[mark for mark in self._marks if span.start_s <= mark.time_s <= span.end_s],
            cursor_s=cursor_s,
            is_live=self._view.is_live,
            wall_offset_s=self._wall_offset_s,
            marks_row=self._canvas.marks,
            axis=self._canvas.axis,
            has_focus=self._canvas.hasFocus(),
            limits=limit_picture(self._canvas.lanes, span, current()),
        )
        self._canvas.show_picture(picture)
        self._read_off(picture)
        self._head.show_view(self._now_s)
        if cursor_s != self.cursor_s:
            self.cursor_s = cursor_s
            self.cursor_moved.emit()

    def _pixel_aligned(self, span: Span) -> Span:
        """A live span moves by whole pixels, so that lines do not flicker."""
        if not self._view.is_live:
            return span
        pixel_s = self.pixel_s
        end_s = math.ceil(span.end_s / pixel_s) * pixel_s
        return Span(end_s - span.length_s, end_s)

    def _read_off(self, picture: Picture) -> None:
        if picture.cursor_s is None:
            self.reading = ""
            return
        # All lanes, also those that a low window does not show.
        lanes = self._canvas.all_lanes
        values = (f"{tr(lane.lane.title)} {reading(lane, picture.cursor_s, picture.span)}" for lane in lanes)
        self.reading = ", ".join((cursor_time(picture, picture.cursor_s), *values))
        if self._canvas.hasFocus():
            self._canvas.setAccessibleDescription(self.reading)
