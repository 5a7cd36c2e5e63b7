"""A trigger record beside a flight log: the moments at which the log meets its cause, for a person to confirm."""

from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QToolButton, QWidget

from app.flight_analysis.record_match import (
    Moment,
    RecordMatch,
    match_record,
    measured_text,
    moment_message,
    record_limits,
)
from app.flight_analysis.summary import moment_text
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import capitalised, with_units
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, sentence
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.triggers.controller import TriggerRow
from ui.plots.flight_plot import FlightPlot
from ui.plots.lanes import Mark
from ui.services.page import HEIGHT_PX
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import FlowRow, in_column, in_row
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

CONFIRMED: Final = (Judgement.REAL, Judgement.FALSE, Judgement.BENCH_TEST)
"""What a person can say of a record whose moment is found."""
_ICON_PX: Final = 20
_WITH_PLOTS_LINES: Final = 16
"""Height of the page, in lines of text, from which the plots are shown."""


class RecordBesideLog(QWidget):
    """`judged`: the row, the judgement, and what is to be noted. `closed`: back to the list."""

    judged = Signal(object, object, str)
    closed = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("beside_log")
        self.row: TriggerRow | None = None
        self.match: RecordMatch | None = None
        """None while the log is read."""
        self._path = Path()
        self._has_room = True
        self.back = control(QPushButton(), texts, "beside_back", "All records", key="Esc", picture=Icon.CHEVRON_LEFT,
                            slot=self.close_log)  # fmt: skip
        self.name = named(ElidedLabel(), "beside_name", "title")
        self.record = text_label("beside_record", "strong", is_selectable=True)
        self.picture = IconLabel("beside_icon", _ICON_PX)
        self.explanation = text_label("beside_said", is_selectable=True)
        self.moments = control(QComboBox(), texts, "beside_moments", says="Moment")
        WheelGuard(self.moments)
        self.moments.currentIndexChanged.connect(self._show_moment)
        self.question = control(QLabel(), texts, "beside_question", "Confirm this moment as:")
        self.buttons = {
            judgement: control(QToolButton(), texts, f"beside_{judgement.name.lower()}", JUDGEMENT_WORDS[judgement],
                               role="choice", slot=partial(self._confirm, judgement))
            for judgement in CONFIRMED
        }  # fmt: skip
        self.chart = FlightPlot("beside", texts)
        self.chart.shown.connect(self._show_match)
        head = in_row((self.name, 1), self.back, spacing=Space.M)
        head.addStrut(HEIGHT_PX)
        proposal = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.explanation, 1), spacing=Space.S)
        confirming = FlowRow(self.moments, right=(self.question, *self.buttons.values()))
        in_column(head, self.record, proposal, confirming, (self.chart, 1), of=self, spacing=Space.XS, margins=0)
        VisibilityTimer(self, retranslate=self._write)

    def open(self, row: TriggerRow, path: Path) -> None:
        """Reads the log and looks for the record in it."""
        self.row, self.match, self._path = row, None, path
        self.chart.open(path, record_limits(row.record), partial(match_record, row.record))
        self._write()

    def close_log(self) -> None:
        self.chart.close_log()
        self.row = self.match = None
        self.closed.emit()

    def fit_height(self, page_px: int) -> None:
        """Hides the plots on a low page, where they would cover what a person decides by."""
        self._has_room = page_px >= _WITH_PLOTS_LINES * QFontMetrics(font()).height()
        self._say()

    @property
    def moment(self) -> Moment | None:
        row = self.moments.currentIndex()
        return self.match.moments[row] if self.match is not None and 0 <= row < len(self.match.moments) else None

    def _write(self) -> None:
        if self.row is None:
            return
        self.name.setText(tr("Trigger record beside {log}", log=clean(self._path.name)))
        self.record.setText(with_units(capitalised(sentence(self.row.record).translated())))
        chosen = self.moment
        moments = () if self.match is None else self.match.moments
        with QSignalBlocker(self.moments):
            self.moments.clear()
            for moment in moments:
                self.moments.addItem(f"{moment_text(moment.firing.at_s)} · {measured_text(moment.firing)}")
            self.moments.setCurrentIndex(moments.index(chosen) if chosen in moments else -1)
        self.chart.retranslate()
        self._say()

    def _show_match(self, match: RecordMatch) -> None:
        self.match = match
        if self.chart.plot is not None:
            self.chart.plot.add_marks([
                Mark(moment.firing.at_s, marked("trigger record?"), Icon.HISTORY, Meaning.INFORMATION)
                for moment in match.moments
            ])  # fmt: skip
        self._write()
        if match.likeliest is not None:
            self.moments.setCurrentIndex(match.moments.index(match.likeliest))

    def _show_moment(self) -> None:
        moment = self.moment
        if moment is not None:
            self.chart.look_at(moment.firing.at_s)
        self._say()

    def _say(self) -> None:
        match, moment, row = self.match, self.moment, self.row
        for widget in (self.question, *self.buttons.values()):
            widget.setVisible(moment is not None)
        self.moments.setVisible(self.moments.count() > 1)
        self.chart.setVisible(self._has_room or moment is None)
        self.picture.setVisible(match is not None)
        if row is None or match is None:
            self.explanation.setText("")
        elif match.why_none is not None:
            self.picture.show_icon(Icon.WARNING, Meaning.ATTENTION)
            self.explanation.setText(match.why_none.translated())
        elif moment is not None:
            self.picture.show_icon(Icon.INFORMATION, Meaning.INFORMATION)
            count = len(match.moments)
            lines = [moment_message(moment, row.record).translated()]
            if match.has_more:
                lines.append(tr("Moments that match: over {count}, the first are listed.", count=count))
            elif count > 1:
                lines.append(tr("Moments that match: {count}.", count=count))
            if not self._has_room:
                lines.append(tr("A higher window also shows: {plots}", plots=tr("Plots")))
            self.explanation.setText("\n".join(lines))

    def _confirm(self, judgement: Judgement, _is_checked: bool = False) -> None:
        moment, row = self.moment, self.row
        if moment is not None and row is not None:
            note = tr("{log} at {time}: {what}", log=clean(self._path.name), time=moment_text(moment.firing.at_s),
                      what=measured_text(moment.firing))  # fmt: skip
            self.judged.emit(row, judgement, note)
            self.close_log()
