"""Plots several quantities over time, with limits, markers and a cursor.

The page fills the series, adds marks, and calls `draw`. Importing this module loads numpy and pyqtgraph, so import it
after the window's first paint.
"""

import math
import time
from collections import deque
from collections.abc import Hashable, Sequence
from typing import Final

from PySide6.QtCore import QBuffer, QByteArray, QPoint, Qt, Signal
from PySide6.QtGui import QFontMetricsF, QGuiApplication, QKeySequence, QPixmap
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QMenu, QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.plots.axis import ago_text, before_now, clock_text, clock_times
from ui.plots.header import PlotHeader
from ui.plots.lanes import Frame, Lane, Mark, Span, value_text
from ui.plots.plot_view import SHORTEST_S, PlotView
from ui.style.theme import Size, Space, font
from ui.widgets.controls import named
from ui.widgets.layouts import in_column
from ui.widgets.visibility_timer import VisibilityTimer

_WINDOW_S: Final = 60.0
"""At first."""
# Limit of panning back: what a series keeps.
MAX_S: Final = 10 * 3600.0
# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
_NEAR_PX: Final = 6
"""A mark as near to the cursor is named there."""


class TimePlot(QWidget):
    """The stack of plots with its controls.

    It shows the last `window_s` while it is live, else a span that pausing, zooming and panning hold until
    `back_to_live`. `lanes` from top to bottom. `wall_offset_s` added to the samples' monotonic time gives seconds since
    1970. `bounds` are those of a recording, which has no live end to follow; at first all of it is in sight. The page
    may add controls to `header`.
    """

    cursor_moved = Signal()
    """`cursor_s` changed."""
    save_values_wanted = Signal()
    """All samples of `span`, as a table."""
    save_picture_wanted = Signal()

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
        self._lanes = lanes
        self._bounds = None if bounds is None else _at_least(bounds, SHORTEST_S)
        self._window_s = _WINDOW_S
        self._held: Span | None = None
        self._marks: deque[Mark] = deque(maxlen=_MAX_MARKS)
        self._wall_offset_s = time.time() - time.monotonic() if wall_offset_s is None else wall_offset_s
        self._now_s = 0.0
        self._cursor_part: float | None = None
        self.reading = ""
        """The values at the cursor in words."""
        self.cursor_s: float | None = None
        self.menu = named(QMenu(self), "time_plot_menu")
        self._drawn: Hashable = None
        """What the last picture depended on; None: it has to be drawn again."""
        self._view = PlotView(lanes)
        self._head = PlotHeader(texts, is_recorded=bounds is not None)
        self.header, self.pause = self._head.row, self._head.pause
        in_column(self._head, (self._view, 1), of=self, spacing=Space.XS, margins=0)
        self.setMinimumHeight(144)
        self._connect(texts)
        self.apply_theme()
        VisibilityTimer(self, self._redraw, retranslate=self._retranslate, restyle=self.apply_theme)

    def be_at(self, wall_offset_s: float) -> None:
        """Sets the offset of wall time for new samples; see the class."""
        self._wall_offset_s = wall_offset_s
        self._drawn = None

    def _connect(self, texts: Texts) -> None:
        view, head = self._view, self._head
        texts.bind(view.setAccessibleName, "Plots")
        texts.bind(view.setWhatsThis, "Arrow keys move, + and − zoom, Shift with arrow keys reads off")
        view.moved.connect(self._move)
        view.cursor_wanted.connect(self._point)
        view.pause_wanted.connect(self.toggle_pause)
        view.live_wanted.connect(self.back_to_live)
        view.fit_wanted.connect(self.fit)
        view.changed.connect(self._redraw)
        view.customContextMenuRequested.connect(self._show_menu)
        head.toggle_wanted.connect(self.toggle_pause)
        head.whole_wanted.connect(self.back_to_live)
        head.clock.toggled.connect(self._redraw)
        head.window_chosen.connect(self.choose_window)

    def _retranslate(self) -> None:
        self._view.arrange()
        self._redraw()

    @property
    def is_live(self) -> bool:
        """Whether it follows the newest samples."""
        return self._held is None and self._bounds is None

    @property
    def is_recorded(self) -> bool:
        """Whether it shows a recording."""
        return self._bounds is not None

    @property
    def span(self) -> Span:
        """The time span in sight."""
        return self._held or self._bounds or Span(self._now_s - self._window_s, self._now_s)

    @property
    def is_whole(self) -> bool:
        """Whether all of a recording is in sight."""
        return self._bounds is not None and self.span.length_s >= self._bounds.length_s * (1 - 1e-9)

    @property
    def pixel_s(self) -> float:
        """Seconds per device pixel."""
        return self.span.length_s / max(1.0, self._view.width_px * self._view.devicePixelRatio())

    def add_marks(self, marks: Sequence[Mark]) -> None:
        """Adds marks, drawn with the next `draw`."""
        if marks:
            self._marks.extend(marks)
            self._drawn = None

    def reset(self) -> None:
        """Removes all marks and goes back to live, for another module."""
        self._marks.clear()
        self._view.fit_scales(is_manual_too=True)
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
        behind_s = None if self.is_live else max(0.0, self._now_s - self.span.end_s)
        self._head.show_view(self.span.length_s, behind_s, is_whole=self.is_whole)

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
        self._view.fit_scales()
        self._redraw()

    def show_instant(self, time_s: float) -> None:
        """Pauses with `time_s` and the cursor in the middle."""
        length_s = min(self.span.length_s, self._window_s) if self.is_whole else self.span.length_s
        self._hold(Span(time_s - length_s / 2, time_s + length_s / 2))
        self.point_at(time_s)

    def point_at(self, time_s: float) -> None:
        """Puts the cursor at a time in sight."""
        self._set_cursor((time_s - self.span.start_s) / self.span.length_s)

    def choose_window(self, window_s: float) -> None:
        """Sets the length of the time line; a held span keeps its end, that of a recording its middle."""
        span, self._window_s = self.span, window_s
        self._view.fit_scales()
        if self.is_recorded:
            middle_s = (span.start_s + span.end_s) / 2
            self._hold(Span(middle_s - window_s / 2, middle_s + window_s / 2))
        elif self._held is not None:
            self._hold(Span(span.end_s - window_s, span.end_s))
        else:
            self._redraw()

    def show_clock_time(self, shows_clock: bool, /) -> None:
        """Labels the time line with the time of day, or with seconds before now."""
        self._head.clock.setChecked(shows_clock)

    def fit(self) -> None:
        """Shows all values vertically."""
        self._view.fit_scales(is_manual_too=True)
        self._redraw()

    def picture(self) -> QPixmap:
        """The plots as a picture."""
        picture: QPixmap = self._view.grab()
        return picture

    def svg(self) -> bytes:
        """The plots as a drawing."""
        data = QByteArray()
        drawing = QSvgGenerator()
        drawing.setOutputDevice(QBuffer(data))
        drawing.setViewBox(self._view.rect())
        self._view.draw_on(drawing)
        return bytes(data.data())

    def _show_menu(self, place: QPoint) -> None:
        """Made anew each time, in the language in use."""
        menu = self.menu
        menu.clear()
        menu.addAction(tr("Save picture…"), self.save_picture_wanted.emit)
        menu.addAction(tr("Save values…"), self.save_values_wanted.emit)
        menu.addAction(tr("Copy picture"), lambda: QGuiApplication.clipboard().setPixmap(self.picture()))
        menu.addSeparator()
        fit = menu.addAction(tr("Fit vertically"), self.fit)
        fit.setShortcut(QKeySequence(Qt.Key.Key_Home))
        live = menu.addAction(tr("All") if self.is_recorded else tr("Live"), self.back_to_live)
        live.setShortcut(QKeySequence(Qt.Key.Key_End))
        live.setEnabled(not (self.is_live or self.is_whole))
        if not self.is_recorded:
            clock = menu.addAction(tr("Time of day"), self._head.clock.toggle)
            clock.setCheckable(True)
            clock.setChecked(self._head.clock.isChecked())
        menu.popup(self._view.viewport().mapToGlobal(place))

    def _hold(self, span: Span) -> None:
        """Shows `span`, as far as there are data."""
        first_s, last_s = self._bounds or (self._now_s - MAX_S, self._now_s)
        length_s = min(max(span.length_s, SHORTEST_S), last_s - first_s)
        end_s = max(min(span.end_s, last_s), first_s + length_s)
        self._held = Span(end_s - length_s, end_s)
        self._redraw()

    def _move(self, start: float, end: float, cursor_part: float | None) -> None:
        span, self._cursor_part = self.span, cursor_part
        self._hold(Span(span.start_s + start * span.length_s, span.start_s + end * span.length_s))

    def _point(self, part: float | None) -> None:
        # The numbers of a recording stay where the pointer left it.
        if part is not None or not self.is_recorded:
            self._set_cursor(part)

    def _set_cursor(self, part: float | None) -> None:
        part = None if part is None else min(1.0, max(0.0, part))
        if part != self._cursor_part:
            self._cursor_part = part
            self._redraw()

    # Drawing

    def apply_theme(self) -> None:
        """Applies the theme in use."""
        self._view.apply_theme()
        self._redraw()

    def _appearance_key(self, now_s: float) -> Hashable:
        """What the picture depends on and may change by itself."""
        span = self._pixel_aligned(now_s)
        limits = tuple(
            (limit.steps.value, None if limit.stale is None else limit.stale.value)
            for lane in self._lanes
            for limit in lane.limits
        )
        if self.is_live:  # new samples are within the last pixel
            return span, limits
        newest = (lane.series.last for lane in self._lanes)
        return span, limits, tuple(None if sample is None else min(sample.time_s, span.end_s) for sample in newest)

    def _pixel_aligned(self, now_s: float) -> Span:
        """A live span moves by whole pixels, so that lines do not flicker."""
        if not self.is_live:
            return self.span
        pixel_s = self.pixel_s
        end_s = math.ceil(now_s / pixel_s) * pixel_s
        return Span(end_s - self._window_s, end_s)

    def _redraw(self) -> None:
        span = self._pixel_aligned(self._now_s)
        cursor_s = None if self._cursor_part is None else span.start_s + self._cursor_part * span.length_s
        marks = [mark for mark in self._marks if span.start_s <= mark.time_s <= span.end_s]
        cursor_time = "" if cursor_s is None else self._time_text(cursor_s, marks)
        readings = [] if cursor_s is None else [reading(lane, cursor_s, span) for lane in self._lanes]
        if self._view.isVisible():
            self._drawn = self._appearance_key(self._now_s)
            most = max(2, int(self._view.width_px / QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000")))
            # A paused picture is labelled by the clock: "10 s before now" would soon be wrong.
            if self.is_live and not self._head.clock.isChecked():
                ticks = before_now(span.length_s, most=most)
            else:
                ticks = clock_times(span, most=most, wall_offset_s=self._wall_offset_s)
            self._view.draw(Frame(span, ticks, marks, cursor_s, cursor_time, readings))
        else:
            self._drawn = None
        # All lanes, also those that a low window does not show.
        values = (f"{tr(lane.title)} {value}" for lane, value in zip(self._lanes, readings, strict=bool(readings)))
        self.reading = ", ".join((cursor_time, *values)) if cursor_s is not None else ""
        if self._view.hasFocus():
            self._view.setAccessibleDescription(self.reading)
        self.show_age(self._now_s)
        if cursor_s != self.cursor_s:
            self.cursor_s = cursor_s
            self.cursor_moved.emit()

    def _time_text(self, cursor_s: float, marks: Sequence[Mark]) -> str:
        """The age and the time of day at the cursor, and the events there."""
        decimals = 1 if self.span.length_s > 3 else 3
        text = clock_text(cursor_s + self._wall_offset_s, decimals)
        if self.is_live:
            text = f"{ago_text(max(0.0, self._now_s - cursor_s), decimals)} · {text}"
        near_s = _NEAR_PX * self.span.length_s / max(1.0, self._view.width_px)
        return " · ".join((text, *(tr(mark.word) for mark in marks if abs(mark.time_s - cursor_s) < near_s)))


def reading(lane: Lane, at_s: float, span: Span) -> str:
    """The value at a time with its unit, a range where only that was kept, or "no data"."""
    near = lane.series.around(at_s, within_s=min(lane.gap_s, max(0.002, span.length_s / 50)))
    if near is None:
        return tr("no data")
    low, high = value_text(near.low, lane.decimals), value_text(near.high, lane.decimals)
    gap = "" if lane.unit == "°" else " "
    text = f"{low}{gap}{lane.unit}" if low == high else f"{low} … {high}{gap}{lane.unit}"
    outside = None if lane.outside is None else lane.outside(near.low, at_s) or lane.outside(near.high, at_s)
    return text if outside is None else outside.beside(text)


def _at_least(span: Span, length_s: float) -> Span:
    """`span`, extended around its middle to at least `length_s`."""
    middle_s = (span.start_s + span.end_s) / 2
    return span if span.length_s >= length_s else Span(middle_s - length_s / 2, middle_s + length_s / 2)
