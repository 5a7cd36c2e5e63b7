"""In place of the overview: one flight with its plots, or the line for the columns of a table."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLineEdit, QPushButton, QWidget

from app.flights.columns import CsvColumns, parse_line, role_words
from app.flights.judge import TriggerLimits
from app.flights.thresholds import FlightOutcome
from app.recordings.markers import Marker
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import labelled
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.pages.flights.lists import appearance_of, outcome_lines, short_name, verdict_of
from ui.plots.flight_plot import FlightPlot
from ui.plots.lanes import Mark, mark_of
from ui.services.page import HEIGHT_PX
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import in_column, in_row

_ICON_PX: Final = 20
_PROBLEMS_SHOWN: Final = 3
_SAME_S: Final = 0.05
"""Closer marks are shown as one."""


class FlightView(QWidget):
    closed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("flight_view")
        self._outcome: FlightOutcome | None = None
        self.back = control(
            QPushButton(tr("All flights")), "flight_back", key="Esc", picture=Icon.CHEVRON_LEFT, slot=self.close_flight
        )
        self.name = named(ElidedLabel(), "flight_name", "title")
        self.picture = IconLabel("flight_icon", _ICON_PX)
        self.verdict = text_label("flight_verdict", "strong", is_selectable=True)
        self.problems = text_label("flight_problems", "small", is_selectable=True)
        self.chart = FlightPlot("flight")
        self.chart.shown.connect(self._mark)
        head = in_row((self.name, 1), self.back, spacing=Space.M)
        head.addStrut(HEIGHT_PX)
        verdict = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.verdict, 1), spacing=Space.S)
        in_column(head, verdict, self.problems, (self.chart, 1), of=self, spacing=Space.XS, margins=0)

    def show_flight(self, outcome: FlightOutcome, limits: TriggerLimits, columns: CsvColumns | None) -> None:
        """The file is read again in the background."""
        self._outcome = outcome
        self._write()
        self.chart.open(Path(outcome.flight.name), limits, lambda log: log.resets, columns)

    def close_flight(self) -> None:
        self.chart.close_log()
        self._outcome = None
        self.closed.emit()

    def _write(self) -> None:
        outcome = self._outcome
        if outcome is None:
            return
        appearance = appearance_of(outcome.group, verdict_of(outcome))
        self.picture.show_icon(appearance.icon, appearance.meaning)
        self.name.setText(f"{short_name(outcome.flight.name)} · {tr(outcome.group.value)}")
        self.verdict.setText("\n".join(outcome_lines(outcome)))
        problems = [problem.translated() for problem in outcome.flight.problems]
        shown = problems[:_PROBLEMS_SHOWN]
        if len(problems) > len(shown):
            shown.append(tr("and {count} more", count=len(problems) - len(shown)))
        self.problems.setText("\n".join(clean(problem) for problem in shown))
        self.problems.setToolTip("\n".join(problems))
        self.problems.setVisible(bool(problems))

    def _mark(self, resets: Sequence[Marker]) -> None:
        if self._outcome is None or self.chart.plot is None:
            return
        self.chart.plot.add_marks(marks_of(self._outcome, resets))
        fires_s = [fire.at_s for fire in (self._outcome.direct, self._outcome.damped) if fire.sources]
        moment_s = min(fires_s, default=self._outcome.flight.loss_s)
        if moment_s is not None:
            self.chart.look_at(moment_s)


def marks_of(outcome: FlightOutcome, resets: Sequence[Marker] = ()) -> list[Mark]:
    flight = outcome.flight
    meaning = appearance_of(outcome.group, verdict_of(outcome)).meaning
    marks = [mark_of(reset) for reset in resets]
    direct_s, damped_s = outcome.direct.at_s, outcome.damped.at_s
    is_one = bool(outcome.direct.sources and outcome.damped.sources) and abs(direct_s - damped_s) < _SAME_S
    if outcome.direct.sources:
        word = marked("fires") if is_one else marked("Triggers at once")
        marks.append(Mark(direct_s, word, Icon.PARACHUTE, meaning))
    if outcome.damped.sources and not is_one:
        marks.append(Mark(damped_s, marked("Triggers after 0.2 s"), Icon.PARACHUTE, meaning))
    if flight.loss_s is not None:
        marks.append(Mark(flight.loss_s, marked("control lost (estimate)"), Icon.WARNING, Meaning.ATTENTION))
    if flight.impact_s is not None:
        marks.append(Mark(flight.impact_s, marked("impact"), Icon.DROP, None))
    return sorted(marks, key=lambda mark: mark.time_s)


class ColumnLine(QWidget):
    """Asks in one line which columns of a table hold what. `chosen` gives the name of the file and its `CsvColumns`."""

    chosen = Signal(str, object)
    closed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("csv_form")
        self._name = ""
        self._why: UserMessage | None = None
        self._fault: UserError | None = None
        self.title = named(ElidedLabel(), "csv_title", "title")
        self.why = text_label("csv_why", is_selectable=True)
        self.line = control(QLineEdit(), "csv_line", says=tr("Columns"))
        self.line.returnPressed.connect(self._choose)
        self.fault = text_label("csv_fault", "danger")
        self.read = control(QPushButton(tr("Read")), "csv_read", picture=Icon.CHECK, role="primary", slot=self._choose)
        self.cancel = control(QPushButton(tr("Cancel")), "csv_cancel", key="Esc", slot=self.closed)
        head = in_row((self.title, 1), self.cancel, self.read, spacing=Space.S)
        head.addStrut(HEIGHT_PX)
        in_column(head, self.why, self.line, self.fault, 1, of=self, spacing=Space.S, margins=0)

    def show_file(self, name: str, why: UserMessage | None, columns: CsvColumns | None) -> None:
        """`why`: it cannot be read without. What was said before and what is proposed stand in the line already."""
        self._name, self._why, self._fault = name, why, None
        cure = "" if why is None else str(dict(why.values).get("cure", ""))
        words = map(shlex.quote, role_words(columns or {}))
        self.line.setText(" ".join([*words, cure.replace("--column ", "")]).strip())
        self._write()
        self.line.setFocus()

    def _write(self) -> None:
        self.title.setText(labelled(tr("Columns"), short_name(self._name)))
        self.why.setText("" if self._why is None else clean(self._why.translated(), longest=2000))
        self.fault.setText("" if self._fault is None else self._fault.sentence)
        self.fault.setVisible(self._fault is not None)

    def _choose(self) -> None:
        try:
            columns = parse_line(self.line.text())
        except UserError as error:
            self._fault = error
            self._write()
            return
        self.chosen.emit(self._name, columns)
