"""Plots several quantities over time, with limits, markers and a cursor.

The page fills the series, adds marks, and calls `draw`. Importing this module loads numpy and pyqtgraph, so import it
after the window's first paint.
"""

from collections.abc import Sequence
from typing import Final

from PySide6.QtWidgets import QPushButton, QToolButton, QWidget

from app.text.i18n import tr
from app.text.messages import duration, in_brackets
from ui.plots.lanes import Lane, Mark, Span, TimeRange
from ui.plots.plot_view import PlotView
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import ChoiceButton, in_column, in_row, named
from ui.widgets.readout import StateChip
from ui.widgets.visibility_timer import VisibilityTimer

_LENGTHS_S: Final = (10.0, 60.0, 600.0)


class TimePlot(QWidget):
    """The stack of plots with its controls.

    `lanes` from top to bottom. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970. `bounds`
    are those of a recording; see `TimeRange`.
    """

    def __init__(self, lanes: Sequence[Lane], *, wall_offset_s: float, bounds: Span | None = None) -> None:
        super().__init__()
        self.setObjectName("time-plot")
        self.time_range = TimeRange(bounds)
        self.reading = ""
        """The values at the cursor in words."""
        self.canvas = PlotView(lanes, self.time_range, wall_offset_s)
        self._head = PlotHeader(self.time_range)
        self.pause = self._head.pause
        in_column(self._head, (self.canvas, 1), of=self, spacing=Space.XS, margins=0)
        self.canvas.setAccessibleName(tr("Plots"))
        self.time_range.changed.connect(self._redraw)
        self.apply_theme()
        VisibilityTimer(self, self._redraw, restyle=self.apply_theme)

    def be_at(self, wall_offset_s: float) -> None:
        """Sets the offset of wall time for new samples; see the class."""
        self.canvas.wall_offset_s = wall_offset_s
        self.canvas.forget()

    def add_marks(self, marks: Sequence[Mark]) -> None:
        """Adds marks, drawn with the next `draw`."""
        if marks:
            self.canvas.marks.extend(marks)
            self.canvas.forget()

    def reset(self) -> None:
        """Removes all marks and goes back to live, for another module."""
        self.canvas.marks.clear()
        self.canvas.fit()
        self.time_range.back_to_live()

    def draw(self, now_s: float) -> None:
        """Draws everything as of a monotonic time."""
        self.time_range.follow(now_s)
        self._redraw()

    def show_age(self, now_s: float) -> None:
        """Updates how far a paused picture is behind, without drawing."""
        self.time_range.follow(now_s)
        self._head.refresh()

    def apply_theme(self) -> None:
        self.canvas.apply_theme()
        self._redraw()

    def _redraw(self) -> None:
        self.canvas.draw()
        values = (
            f"{tr(lane.lane.title)} {reading.text}"
            for lane, reading in zip(self.canvas.lanes, self.canvas.readings, strict=False)
        )
        self.reading = ", ".join(filter(None, (self.canvas.cursor_time, *values)))
        if self.canvas.hasFocus():
            self.canvas.setAccessibleDescription(self.reading)
        self._head.refresh()


class PlotHeader(QWidget):
    """Above the plots: state, time span, pause."""

    def __init__(self, time_range: TimeRange) -> None:
        super().__init__()
        self.setObjectName("time-plot-header")
        self._time_range = time_range
        self.chip = named(StateChip(tr("Plots"), is_measured=True), "time-plot-state")
        self._lengths = {length_s: self._segment(length_s) for length_s in _LENGTHS_S}
        self._whole = named(QToolButton(), "time-plot-whole", "segment")
        self._whole.setText(tr("All"))
        self._whole.setCheckable(True)
        self._whole.clicked.connect(time_range.back_to_live)
        self._whole.setVisible(time_range.is_recorded)
        self.pause = named(QPushButton(), "time-plot-pause")
        self.pause.setAutoDefault(False)
        self.pause.clicked.connect(time_range.toggle_pause)
        self.pause.setVisible(not time_range.is_recorded)
        controls = in_row(1, *self._lengths.values(), self._whole, self.pause, spacing=Space.XS)
        if is_text_large():
            in_column(self.chip, controls, of=self, spacing=Space.XS, margins=0)
        else:
            in_row(self.chip, (controls, 1), of=self, margins=0)

    def _segment(self, length_s: float) -> ChoiceButton:
        button = named(ChoiceButton(), f"time-plot-window-{length_s:g}", "segment")
        button.setText(duration(length_s))
        button.setToolTip(tr("Length of the time line"))
        button.setAccessibleDescription(tr("Length of the time line"))
        button.clicked.connect(lambda: self._time_range.choose_length(length_s))
        return button

    def refresh(self) -> None:
        """Shows the length in sight and how far it is behind now."""
        time_range = self._time_range
        for length_s, segment in self._lengths.items():
            segment.setChecked(not time_range.is_whole and abs(time_range.span.length_s - length_s) < 1e-6)
        self._whole.setChecked(time_range.is_whole)
        word = tr("Pause") if time_range.is_live else tr("Live")
        if self.pause.accessibleName() != word:
            self.pause.setAccessibleName(word)
            self.pause.setText("" if is_text_large() else word)
            self.pause.setIcon(icon(Icon.PAUSE if time_range.is_live else Icon.TO_LIVE))
            tip = tr("Pause; recording continues") if time_range.is_live else word
            self.pause.setToolTip(tip + in_brackets("Space" if time_range.is_live else "End"))
        if self.chip.isHidden() is not time_range.is_live:
            self.chip.setHidden(time_range.is_live)  # the title of the page says it
        if time_range.is_recorded:
            self.chip.show_state(tr("recorded"), Icon.HISTORY, Meaning.INFORMATION)
        elif not time_range.is_live:
            behind_s = max(0.0, time_range.now_s - time_range.span.end_s)
            text = tr("paused, {time} behind", time=duration(behind_s))
            self.chip.show_state(text, Icon.PAUSE, Meaning.ATTENTION)
