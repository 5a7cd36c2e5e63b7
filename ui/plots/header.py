"""Header of the plots: state, time span, pause."""

from typing import Final

from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QPushButton, QToolButton, QWidget

from app.text.durations import duration
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.plots.sight import Sight
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import ChoiceButton, control, named
from ui.widgets.layouts import FlowRow
from ui.widgets.readout import StateChip

_LENGTHS_S: Final = {10.0: marked("10 s"), 60.0: marked("60 s"), 600.0: marked("10 min")}


class PlotHeader(QWidget):
    """Shows what is in sight, and changes it. `row` takes more controls at its right."""

    def __init__(self, texts: Texts, sight: Sight) -> None:
        super().__init__()
        self.setObjectName("time-plot-header")
        self._sight, self._texts = sight, texts
        self._shown: object = None
        self._offers_pause: bool | None = None
        self.chip = named(StateChip(tr("Plots")), "time-plot-state")
        texts.bind(self.chip.set_caption, "Plots")
        self.clock = control(QToolButton(), texts, "time-plot-clock", says="Time of day", picture=Icon.CLOCK,
                             role="segment", is_checkable=True)  # fmt: skip
        self._lengths = {length_s: self._segment(length_s) for length_s in _LENGTHS_S}
        self._whole = control(QToolButton(), texts, "time-plot-whole", "All", key="End", role="segment",
                              is_checkable=True, slot=sight.back_to_live)  # fmt: skip
        self.pause = control(QPushButton(), texts, "time-plot-pause", slot=sight.toggle_pause)
        self.pause.setAutoDefault(False)
        self.row = FlowRow(self, spacing_px=Space.XS)
        self.row.add(self.chip)
        self.row.add_right(self.clock, *self._lengths.values(), self._whole, self.pause)
        self._whole.setVisible(sight.is_recorded)
        for button in (self.pause, self.clock):
            button.setVisible(not sight.is_recorded)

    def _segment(self, length_s: float) -> QToolButton:
        return control(ChoiceButton(), self._texts, f"time-plot-window-{length_s:g}", _LENGTHS_S[length_s],
                       says="Length of the time line", tip="Length of the time line", role="segment",
                       slot=lambda: self._sight.choose_length(length_s))  # fmt: skip

    def refresh(self) -> None:
        """Shows the length in sight and how far it is behind now."""
        sight = self._sight
        for length_s, segment in self._lengths.items():
            segment.setChecked(not sight.is_whole and abs(sight.span.length_s - length_s) < 1e-6)
        self._whole.setChecked(sight.is_whole)
        if sight.is_live != self._offers_pause:
            self._offers_pause = sight.is_live
            if sight.is_live:
                control(self.pause, self._texts, "time-plot-pause", "Pause", tip="Pause; recording continues",
                        key="Space", picture=Icon.PAUSE)  # fmt: skip
            else:
                control(self.pause, self._texts, "time-plot-pause", "Live", key="End", picture=Icon.TO_LIVE)
        if sight.is_recorded:
            self._show_state(tr("recorded"), tr("recorded"), Icon.HISTORY, Meaning.INFORMATION)
            return
        self.chip.setVisible(not sight.is_live)  # the title of the page says it
        if sight.is_live:
            self._show_state(tr("live"), tr("live"), Icon.LIVE, None)
        else:
            behind = tr("paused, {time} behind", time=duration(max(0.0, sight.now_s - sight.span.end_s)))
            self._show_state(behind, tr("paused"), Icon.PAUSE, Meaning.ATTENTION)

    def _show_state(self, whole: str, short: str, picture: Icon, meaning: Meaning | None) -> None:
        """Shows the whole text if the row has room for it, else the short one, else only the icon."""
        if (whole, self.width()) == self._shown:
            return
        self._shown = whole, self.width()
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
        self._shown = None  # the text may fit now, or no longer
