"""Header of the plots: state, time span, pause."""

from typing import Final

from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QPushButton, QToolButton, QWidget

from app.text.durations import duration
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import ChoiceButton, control, named
from ui.widgets.layouts import FlowRow
from ui.widgets.readout import StateChip

WINDOWS_S: Final = {10.0: marked("10 s"), 60.0: marked("60 s"), 600.0: marked("10 min")}
"""Selectable lengths of the time line."""


class PlotHeader(QWidget):
    """Shows what is in sight; the signals are what the user wants. `row` takes more controls at its right."""

    toggle_wanted = Signal()
    """Pause, or go back to live."""
    whole_wanted = Signal()
    window_chosen = Signal(float)

    def __init__(self, texts: Texts, *, is_recorded: bool) -> None:
        super().__init__()
        self.setObjectName("time-plot-header")
        self._is_recorded = is_recorded
        self._announced: tuple[str, int] | None = None
        """The state and the width of the header when it was last shown."""
        self._is_live: bool | None = None
        self._texts = texts
        self.chip = named(StateChip(tr("Plots")), "time-plot-state")
        texts.bind(self.chip.set_caption, "Plots")
        self.pause = control(QPushButton(), texts, "time-plot-pause", slot=self.toggle_wanted)
        self.pause.setAutoDefault(False)
        self.whole = control(QToolButton(), texts, "time-plot-whole", "All", key="End", role="segment",
                             is_checkable=True, slot=self.whole_wanted)  # fmt: skip
        self.clock = control(QToolButton(), texts, "time-plot-clock", says="Time of day", picture=Icon.CLOCK,
                             role="segment", is_checkable=True)  # fmt: skip
        self.row = FlowRow(self, spacing_px=Space.XS)
        self.row.add(self.chip)
        self.row.add_right(self.clock)
        self._windows = QButtonGroup(self)
        # The span in sight decides which one is checked; in a recording it may be none.
        self._windows.setExclusive(False)
        for number, window_s in enumerate(WINDOWS_S):
            segment = self._segment(texts, window_s)
            self._windows.addButton(segment, number)
            self.row.add_right(segment)
        self.row.add_right(self.whole, self.pause)
        self.whole.setVisible(is_recorded)
        self.pause.setVisible(not is_recorded)
        self.clock.setVisible(not is_recorded)
        self._windows.idClicked.connect(lambda number: self.window_chosen.emit(list(WINDOWS_S)[number]))

    def _segment(self, texts: Texts, window_s: float) -> QToolButton:
        segment = control(ChoiceButton(), texts, f"time-plot-window-{window_s:g}", WINDOWS_S[window_s], role="segment")
        for setter in (segment.setAccessibleDescription, segment.setToolTip):
            texts.bind(setter, "Length of the time line")
        return segment

    def show_view(self, length_s: float, behind_s: float | None, *, is_whole: bool = False) -> None:
        """The length in sight; `behind_s`: how far it is behind now, None while it is live."""
        for number, window_s in enumerate(WINDOWS_S):
            self._windows.button(number).setChecked(not is_whole and abs(length_s - window_s) < 1e-6)
        self.whole.setChecked(is_whole)
        is_live = behind_s is None
        if is_live != self._is_live:
            self._is_live = is_live
            if is_live:
                control(self.pause, self._texts, "time-plot-pause", "Pause", tip="Pause; recording continues",
                        key="Space", picture=Icon.PAUSE)  # fmt: skip
            else:
                control(self.pause, self._texts, "time-plot-pause", "Live", key="End", picture=Icon.TO_LIVE)
        if self._is_recorded:
            self._show_state(tr("recorded"), tr("recorded"), Icon.HISTORY, Meaning.INFORMATION)
            return
        self.chip.setVisible(not is_live)  # the title of the page says it
        if behind_s is None:
            self._show_state(tr("live"), tr("live"), Icon.LIVE, None)
        else:
            behind = tr("paused, {time} behind", time=duration(behind_s))
            self._show_state(behind, tr("paused"), Icon.PAUSE, Meaning.ATTENTION)

    def _show_state(self, whole: str, short: str, picture: Icon, meaning: Meaning | None) -> None:
        """Shows the whole text if the row has room for it, else the short one, else only the icon."""
        if (whole, self.width()) == self._announced:
            return
        self._announced = whole, self.width()
        self.chip.show_state(whole, picture, meaning)
        spoken = self.chip.accessibleName()
        for word in (short, ""):
            if not self.isVisible() or self.row.sizeHint().width() <= self.width():
                break
            self.chip.show_state(word, picture, meaning)
        self.chip.announce(spoken, name=f"{tr('Plots')}: {short}")  # without the delay, which changes all the time
        self.chip.setToolTip(spoken)

    def minimumSizeHint(self) -> QSize:
        """No minimum width: the text of the state never makes the page wider."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._announced = None  # the text may fit now, or no longer
