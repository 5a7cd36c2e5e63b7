"""Plots several quantities over time, with limits, markers and a cursor.

The page fills the series, adds marks, and calls `draw`. Importing this module loads numpy and pyqtgraph, so import it
after the window's first paint.
"""

import time
from collections.abc import Sequence

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QGuiApplication, QKeySequence, QPixmap
from PySide6.QtWidgets import QMenu, QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.plots.header import PlotHeader
from ui.plots.lanes import Lane, Mark, Span
from ui.plots.plot_view import PlotView
from ui.plots.sight import Sight
from ui.style.theme import Space
from ui.widgets.controls import named
from ui.widgets.layouts import in_column
from ui.widgets.visibility_timer import VisibilityTimer


class TimePlot(QWidget):
    """The stack of plots with its controls.

    `lanes` from top to bottom. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970. `bounds`
    are those of a recording; see `Sight`. The page may add controls to `header`.
    """

    save_values_wanted = Signal()
    """All samples in sight, as a table."""
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
        self.sight = Sight(bounds)
        self.reading = ""
        """The values at the cursor in words."""
        self.menu = named(QMenu(self), "time_plot_menu")
        offset_s = time.time() - time.monotonic() if wall_offset_s is None else wall_offset_s
        self._view = PlotView(lanes, self.sight, offset_s)
        self._head = PlotHeader(texts, self.sight)
        self.header, self.pause = self._head.row, self._head.pause
        in_column(self._head, (self._view, 1), of=self, spacing=Space.XS, margins=0)
        self.setMinimumHeight(144)
        texts.bind(self._view.setAccessibleName, "Plots")
        texts.bind(self._view.setWhatsThis, "Arrow keys move, + and − zoom, Shift with arrow keys reads off")
        self._view.customContextMenuRequested.connect(self._show_menu)
        self._head.clock.toggled.connect(self._show_clock_time)
        self.sight.changed.connect(self._redraw)
        self.apply_theme()
        VisibilityTimer(self, self._redraw, retranslate=self._retranslate, restyle=self.apply_theme)

    def be_at(self, wall_offset_s: float) -> None:
        """Sets the offset of wall time for new samples; see the class."""
        self._view.wall_offset_s = wall_offset_s
        self._view.forget()

    def add_marks(self, marks: Sequence[Mark]) -> None:
        """Adds marks, drawn with the next `draw`."""
        if marks:
            self._view.marks.extend(marks)
            self._view.forget()

    def reset(self) -> None:
        """Removes all marks and goes back to live, for another module."""
        self._view.marks.clear()
        self._view.fit(is_chosen_too=True)
        self.sight.back_to_live()

    def draw(self, now_s: float) -> None:
        """Draws everything as of a monotonic time."""
        self.sight.follow(now_s)
        self._redraw()

    def is_due(self, now_s: float) -> bool:
        """Whether `draw` would change the picture."""
        return self._view.is_due(now_s)

    def show_age(self, now_s: float) -> None:
        """Updates how far a paused picture is behind, without drawing."""
        self.sight.follow(now_s)
        self._head.refresh()

    def fit(self) -> None:
        """Shows all values vertically."""
        self._view.fit(is_chosen_too=True)
        self._redraw()

    def picture(self) -> QPixmap:
        """The plots as a picture."""
        picture: QPixmap = self._view.grab()
        return picture

    def svg(self) -> bytes:
        """The plots as a drawing."""
        return self._view.svg()

    def apply_theme(self) -> None:
        """Applies the theme in use."""
        self._view.apply_theme()
        self._redraw()

    def _retranslate(self) -> None:
        self._view.arrange()
        self._redraw()

    def _show_clock_time(self, shows_clock: bool, /) -> None:
        """Labels the time line with the time of day, or with seconds before now."""
        self._view.shows_clock = shows_clock
        self._redraw()

    def _redraw(self) -> None:
        self._view.draw()
        values = (
            f"{tr(lane.lane.title)} {value}"
            for lane, value in zip(self._view.all_lanes, self._view.readings, strict=False)
        )
        self.reading = ", ".join(filter(None, (self._view.cursor_time, *values)))
        if self._view.hasFocus():
            self._view.setAccessibleDescription(self.reading)
        self._head.refresh()

    def _show_menu(self, place: QPoint) -> None:
        """Made anew each time, in the language in use."""
        menu, sight = self.menu, self.sight
        menu.clear()
        menu.addAction(tr("Save picture…"), self.save_picture_wanted.emit)
        menu.addAction(tr("Save values…"), self.save_values_wanted.emit)
        menu.addAction(tr("Copy picture"), lambda: QGuiApplication.clipboard().setPixmap(self.picture()))
        menu.addSeparator()
        fit = menu.addAction(tr("Fit vertically"), self.fit)
        fit.setShortcut(QKeySequence(Qt.Key.Key_Home))
        live = menu.addAction(tr("All") if sight.is_recorded else tr("Live"), sight.back_to_live)
        live.setShortcut(QKeySequence(Qt.Key.Key_End))
        live.setEnabled(not (sight.is_live or sight.is_whole))
        if not sight.is_recorded:
            clock = menu.addAction(tr("Time of day"), self._head.clock.toggle)
            clock.setCheckable(True)
            clock.setChecked(self._head.clock.isChecked())
        menu.popup(self._view.viewport().mapToGlobal(place))
