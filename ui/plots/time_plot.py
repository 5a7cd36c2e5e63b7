"""Plots several quantities on one time line, with limits, markers and a cursor.

The page puts samples into the series, notes what happened as marks, and calls ``draw`` from its one timer.
Importing this module loads numpy: do it after the window's first paint.
"""

import math
import time
from collections import deque
from collections.abc import Hashable, Iterable, Sequence
from typing import Final

from PySide6.QtCore import QEvent, Signal
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

# Marks that are kept; at ten hours one every 36 s.
_MARKS_KEPT: Final = 1000
# Pixels that the label of a tick wants.
_TICK_PX: Final = 84


class TimePlot(QWidget):
    """The stack of plots with its controls.

    ``lanes`` from the top down.  ``wall_offset_s`` added to the samples' monotonic time gives seconds since
    1970.  ``bounds`` are those of a recording, which has no newest samples to follow.  ``header`` is the row of
    controls, to which the page may add its own at the right.
    """

    cursor_moved = Signal()
    """The read-off cursor is at another time, or gone: ``cursor_s`` tells."""

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
        self._marks: deque[Mark] = deque(maxlen=_MARKS_KEPT)
        self._wall_offset_s = time.time() - time.monotonic() if wall_offset_s is None else wall_offset_s
        self._now_s = 0.0
        self._shows_clock = False
        self._reading = ""
        self._cursor_s: float | None = None
        self._drawn: Hashable = None
        """What the picture of the last draw depended on, None when it has to be drawn again."""
        self._canvas = Canvas(lanes)
        self._canvas.keeps_cursor = bounds is not None
        self._head = PlotHeader(texts, self._view)
        self.header, self.pause = self._head.row, self._head.pause
        in_column(self._head, (self._canvas, 1), of=self, spacing=Space.XS, margins=0)
        self.setMinimumHeight(160)
        self._connect(texts)
        self.apply_theme()

    def be_at(self, wall_offset_s: float) -> None:
        """The time of day of what comes from now on; see the class."""
        self._wall_offset_s = wall_offset_s
        self._drawn = None

    def _connect(self, texts: Texts) -> None:
        texts.bind(self._canvas.setAccessibleName, "Plots")
        texts.bind(self._canvas.setToolTip, "Arrow keys move, + and − zoom, Shift with arrow keys reads off")
        self._canvas.setToolTipDuration(4000)
        texts.bind(self._language_changed, "Pause")
        self._canvas.panned.connect(self._pan)
        self._canvas.zoomed.connect(self._zoom)
        self._canvas.pause_wanted.connect(self.toggle_pause)
        self._canvas.live_wanted.connect(self.back_to_live)
        self._canvas.cursor_moved.connect(self._redraw)
        self._head.toggle_wanted.connect(self.toggle_pause)
        self._head.whole_wanted.connect(self.back_to_live)
        self._head.clock_toggled.connect(self.show_clock_time)
        self._head.window_chosen.connect(self.choose_window)

    def _language_changed(self, _text: str) -> None:
        """Whatever depends on the language and on the state."""
        self._canvas.arrange()
        self._redraw()

    @property
    def is_live(self) -> bool:
        """It follows the newest samples."""
        return self._view.is_live

    @property
    def span(self) -> Span:
        """The time in sight, for an export of what is seen."""
        return self._view.span(self._now_s)

    @property
    def pixel_s(self) -> float:
        """How long the picture takes to move on by one pixel of the screen."""
        return self.span.length_s / max(1.0, self._canvas.strip.width() * self._canvas.devicePixelRatio())

    @property
    def is_recorded(self) -> bool:
        """It shows a recording: nothing of it is how the module is now."""
        return self._view.is_recorded

    @property
    def cursor_s(self) -> float | None:
        """The time under the read-off cursor, None without one."""
        return self._cursor_s

    @property
    def reading(self) -> str:
        """What the read-off cursor says, empty without one."""
        return self._reading

    def add_mark(self, mark: Mark) -> None:
        """Note what happened; drawn with the next ``draw``."""
        self._marks.append(mark)
        self._drawn = None

    def add_marks(self, marks: Iterable[Mark]) -> None:
        """Note all that happened in a recording; of more than are kept, the last ones."""
        self._marks.extend(marks)
        self._drawn = None

    def reset(self) -> None:
        """What comes from now on is another module's: no mark of the old one stays, and the newest is followed."""
        self._marks.clear()
        self.back_to_live()

    def draw(self, now_s: float) -> None:
        """Show the state of affairs at a monotonic time."""
        self._now_s = max(self._now_s, now_s)
        self._redraw()

    def is_due(self, now_s: float) -> bool:
        """Whether `draw` would show another picture: time has moved it by a pixel, or something else has changed."""
        return self._looks(max(self._now_s, now_s)) != self._drawn

    def show_age(self, now_s: float) -> None:
        """Say how far what is held still lies behind; the picture stays."""
        self._now_s = max(self._now_s, now_s)
        self._head.show_view(self._now_s)

    def toggle_pause(self) -> None:
        """Hold the picture still, or go on with the newest samples; a recording stands still anyway."""
        if self._view.is_recorded:
            return
        if self._view.is_live:
            self._view.hold(self._now_s)
            self._redraw()
        else:
            self.back_to_live()

    def back_to_live(self) -> None:
        """Follow the newest samples, in the length that was chosen; show all of a recording."""
        self._view.follow()
        self._canvas.fit_scales()
        self._redraw()

    def look_at(self, time_s: float) -> None:
        """Bring an instant into the middle and put the read-off cursor there; the picture is held still."""
        self._view.look_at(time_s, now_s=self._now_s)
        self.point_at(time_s)
        self._redraw()

    def point_at(self, time_s: float) -> None:
        """Put the read-off cursor at an instant that is in sight."""
        span = self.span
        self._canvas.set_cursor((time_s - span.start_s) / span.length_s)

    def choose_window(self, window_s: float) -> None:
        """Choose the length of the time line, in seconds."""
        self._view.choose(window_s, now_s=self._now_s)
        self._canvas.fit_scales()
        self._redraw()

    def show_clock_time(self, shows_clock: bool, /) -> None:
        """Label the time line with the time of day, or with seconds before now."""
        self._shows_clock = shows_clock
        self._head.clock.setChecked(shows_clock)
        self._redraw()

    def picture(self) -> QPixmap:
        """The plots as they are, for a file."""
        one: QPixmap = self._canvas.grab()
        return one

    def apply_theme(self) -> None:
        """Take the colours of the theme in use."""
        self._canvas.apply_theme(current())
        self._canvas.arrange()
        self._redraw()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.FontChange) and hasattr(self, "_head"):
            self.apply_theme()

    def _pan(self, part: float) -> None:
        self._view.pan(part * self.span.length_s, now_s=self._now_s)
        self._redraw()

    def _zoom(self, factor: float, part: float) -> None:
        span = self.span
        self._view.zoom(factor, at_s=span.start_s + part * span.length_s, now_s=self._now_s)
        self._canvas.fit_scales()
        self._redraw()

    def _looks(self, now_s: float) -> Hashable:
        """What the picture depends on that may change by itself."""
        span = self._pixel_aligned(self._view.span(now_s))
        lanes = [lane.lane for lane in self._canvas.all_lanes]
        limits = tuple(
            (limit.steps.value, None if limit.stale is None else limit.stale.value)
            for lane in lanes
            for limit in lane.limits
        )
        if self._view.is_live:  # a sample belongs to the pixel that is not over yet
            return span, limits
        newest = (lane.series.last for lane in lanes)
        return span, limits, tuple(None if one is None else min(one.time_s, span.end_s) for one in newest)

    def _redraw(self) -> None:
        self._drawn = self._looks(self._now_s)
        span = self._pixel_aligned(self.span)
        self._canvas.draw_curves(span)
        most = max(2, int(self._canvas.strip.width() / _TICK_PX))
        # What is held still is labelled by the clock: "10 s before now" would be wrong a moment later.
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
            strip=self._canvas.strip,
            has_focus=self._canvas.hasFocus(),
            limits=limit_picture(self._canvas.lanes, span, current()),
        )
        self._canvas.show_picture(picture)
        self._read_off(picture)
        self._head.show_view(self._now_s)
        if cursor_s != self._cursor_s:
            self._cursor_s = cursor_s
            self.cursor_moved.emit()

    def _pixel_aligned(self, span: Span) -> Span:
        """While it follows, move by whole pixels, so that no line trembles between two."""
        if not self._view.is_live:
            return span
        pixel_s = self.pixel_s
        end_s = math.ceil(span.end_s / pixel_s) * pixel_s
        return Span(end_s - span.length_s, end_s)

    def _read_off(self, picture: Picture) -> None:
        if picture.cursor_s is None:
            self._reading = ""
            return
        # Those that a low window has no room to draw as well.
        lanes = self._canvas.all_lanes
        values = (f"{tr(lane.lane.title)} {reading(lane, picture.cursor_s, picture.span)}" for lane in lanes)
        self._reading = ", ".join((cursor_time(picture, picture.cursor_s), *values))
        if self._canvas.hasFocus():
            self._canvas.setAccessibleDescription(self._reading)
