"""Header of the plots: following, time span, back to live."""

from typing import Final

from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QPushButton, QToolButton, QWidget

from app.diagnosis.link_state import duration
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.plots.view import WINDOWS_S, TimeView
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import TEXT_GAP_PX, ChoiceButton, control
from ui.widgets.layouts import FlowRow
from ui.widgets.naming import named
from ui.widgets.readout import StateChip

_WINDOW_WORDS: Final = {10.0: marked("10 s"), 60.0: marked("60 s"), 600.0: marked("10 min")}


class PlotHeader(QWidget):
    """Shows what a `TimeView` does and says what a person wants; `row` takes further controls at its right."""

    toggle_wanted = Signal()
    """Hold the picture still, or go on."""
    whole_wanted = Signal()
    clock_toggled = Signal(bool)
    window_chosen = Signal(float)

    def __init__(self, texts: Texts, view: TimeView) -> None:
        super().__init__()
        self.setObjectName("time-plot-header")
        self._view = view
        self._said = ""
        self._said_width = 0
        self.chip = named(StateChip(tr("Plots")), "time-plot-state")
        texts.bind(self.chip.set_caption, "Plots")
        self.pause = named(QPushButton(), "time-plot-pause")
        self.pause.setIconSize(QSize(16 + TEXT_GAP_PX, 16))
        self.pause.setAutoDefault(False)
        self.whole = control(QToolButton(), texts, "time-plot-whole", "All", tip="All (End)", role="segment",
                             slot=self.whole_wanted)  # fmt: skip
        self.whole.setCheckable(True)
        self.clock = control(QToolButton(), texts, "time-plot-clock", says="Time of day", picture=Icon.CLOCK,
                             role="segment")  # fmt: skip
        self.clock.setCheckable(True)
        self.row = FlowRow(self, spacing_px=Space.XS)
        self.row.add(self.chip)
        self.row.add_right(self.clock)
        self._windows = QButtonGroup(self)
        # Which is pressed follows the span in sight: in a recording that may be none of them.
        self._windows.setExclusive(False)
        for number, window_s in enumerate(WINDOWS_S):
            segment = self._segment(texts, window_s)
            self._windows.addButton(segment, number)
            self.row.add_right(segment)
        self.row.add_right(self.whole, self.pause)
        self.whole.setVisible(view.is_recorded)
        self.pause.setVisible(not view.is_recorded)
        self.clock.setVisible(not view.is_recorded)
        self.pause.clicked.connect(self.toggle_wanted)
        self.clock.toggled.connect(self.clock_toggled)
        self._windows.idClicked.connect(lambda number: self.window_chosen.emit(WINDOWS_S[number]))

    def _segment(self, texts: Texts, window_s: float) -> QToolButton:
        segment = control(
            ChoiceButton(), texts, f"time-plot-window-{window_s:g}", _WINDOW_WORDS[window_s], role="segment"
        )
        texts.bind(segment.setAccessibleDescription, "Length of the time line")
        texts.bind(segment.setToolTip, "Length of the time line: {length}", length=f"{window_s:g} s")
        return segment

    def show_view(self, now_s: float) -> None:
        """Bring everything up to date."""
        view = self._view
        length_s = view.span(now_s).length_s if view.is_recorded else view.window_s
        for number, window_s in enumerate(WINDOWS_S):
            self._windows.button(number).setChecked(not view.is_whole and abs(length_s - window_s) < 1e-6)
        self.whole.setChecked(view.is_whole)
        word = tr("Pause") if view.is_live else tr("Live")
        if self.pause.text() != word:
            self.pause.setText(word)
            self.pause.setAccessibleName(tr("Pause") if view.is_live else tr("Back to live"))
            self.pause.setIcon(icon(Icon.PAUSE if view.is_live else Icon.TO_LIVE))
            self.pause.setToolTip(
                tr("Pause; recording continues (Space)") if view.is_live else tr("Newest samples (End)")
            )
        if view.is_recorded:
            self._say(tr("recorded"), tr("recorded"), Icon.HISTORY, Meaning.INFORMATION)
            return
        if view.is_live:
            self._say(tr("live"), tr("live"), Icon.LIVE, None)
        else:
            behind = tr("paused, {time} behind", time=duration(view.behind_s(now_s)))
            self._say(behind, tr("paused"), Icon.PAUSE, Meaning.ATTENTION)

    def _say(self, whole: str, short: str, picture: Icon, meaning: Meaning | None) -> None:
        """The whole text where the row has room for it, else the short one, else the icon; the tooltip has the whole
        in any case."""
        if (whole, self.width()) == (self._said, self._said_width):
            return
        self._said, self._said_width = whole, self.width()
        self.chip.show_state(whole, picture, meaning)
        spoken = self.chip.accessibleName()
        for word in (short, ""):
            if not self.isVisible() or self.row.sizeHint().width() <= self.width():
                break
            self.chip.show_state(word, picture, meaning)
        self.chip.announce(spoken, name=f"{tr('Plots')}: {short}")  # how far behind changes all the time
        self.chip.setToolTip(spoken)

    def minimumSizeHint(self) -> QSize:
        """Whatever the state is called, it never makes the page wider."""
        hint = super().minimumSizeHint()
        return QSize(0, hint.height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._said = ""  # it may fit now, or no longer
