"""One log in place of the list: its verdict, its plots with the thresholds and marks; or why it could not be read."""

import shlex
import time
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLineEdit, QPushButton, QWidget

from app.flights.flight_log import FlightLog, Floats
from app.flights.judge import MAX_GAP_S, TriggerLimits
from app.flights.judging import FlightGroup, FlightSummary
from app.flights.read_log import flight_of_recording, read_flight_log
from app.flights.table import CsvColumns, parse_line, role_words
from app.limits.limits import LimitsInUse
from app.recordings.excerpt import LimitSteps
from app.recordings.library import entry_of, entry_text
from app.recordings.markers import ModuleLimits
from app.recordings.recording import open_recording
from app.samples.samples import Readable
from app.text.i18n import tr
from app.text.messages import UserError, clean, error_text
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.pages.logs.rows import LogRow, outcome_text, short_name, verdict_of
from ui.plots.lanes import Lane, Mark, Scale, Span, acceleration_lane, mark_of, measured_lanes, tilt_lane
from ui.plots.time_plot import TimePlot
from ui.style.icons import Icon
from ui.style.theme import IconSize, Meaning, Space
from ui.widgets.controls import ElidedLabel, IconLabel, control, in_column, in_row, named, text_label

_WINDOW_S: Final = 10.0
# Makes the plots, which show the time of day, show the time since the log began.
_MIDNIGHT_S: Final = time.mktime((2001, 1, 1, 0, 0, 0, 0, 0, -1))


class Opened(NamedTuple):
    """A log that was opened, as it is shown."""

    lanes: tuple[Lane, ...]
    bounds: Span
    wall_offset_s: float
    marks: list[Mark]
    # What stands in the file.
    details: list[str]
    # None: a recording holds nothing to judge.
    flight: FlightSummary | None
    # Its beginning on the clock of the plots.
    start_s: float


def read(path: Path, columns: CsvColumns | None, limits: TriggerLimits, in_use: LimitsInUse) -> Opened:
    """With the thresholds that are tried. Raises `UserError`."""
    if path.suffix.lower() != ".mcap":
        return _of_flight(read_flight_log(path, columns), limits)
    recording = open_recording(entry_of(path))
    # The module's own thresholds are in the text above.
    tried, held = _chosen(limits, recording.start_s), recording.last()
    tried.lights = recording.lights
    had = (
        "" if held.fires_deg is None else f"{held.fires_deg:g}°",
        "" if held.free_fall_g is None else f"{held.free_fall_g:g} g",
        "" if held.free_fall_s is None else f"{held.free_fall_s:.2f} s",
    )
    details = [tr("On the module: {value}", value=" · ".join(filter(None, had)))] if any(had) else []
    if recording.damage is not None:
        details.append(recording.damage.translated())
    lanes = measured_lanes(recording, in_use, tried, LimitSteps())
    marks = [mark_of(marker) for marker in recording.markers]
    opened = Opened(lanes, Span(recording.start_s, recording.end_s), recording.wall_offset_s, marks, details, None, 0.0)
    with suppress(UserError):
        log = flight_of_recording(recording)
        return opened._replace(flight=FlightSummary(log), start_s=log.start_s)
    return opened


def _of_flight(log: FlightLog, limits: TriggerLimits) -> Opened:
    def series(values: Floats) -> Readable:
        is_known = np.isfinite(values)
        return Readable(log.time_s[is_known], values[is_known].astype(np.float32))

    first_s, last_s = float(log.time_s[0]), float(log.time_s[-1])
    chosen = _chosen(limits, first_s)
    lanes = [
        tilt_lane(series(log.tilt_deg), (chosen.fires, None), (chosen.rearms, None), gap_s=MAX_GAP_S),
        acceleration_lane(series(log.specific_force_g), (chosen.falls, None), gap_s=MAX_GAP_S),
    ]
    if np.isfinite(log.altitude_m).any():
        low, high = float(np.nanmin(log.altitude_m)), float(np.nanmax(log.altitude_m))
        room = max(0.5, (high - low) * 0.1)
        scales = (Scale(low - room, high + room, 0.0),)
        lanes.append(Lane(marked("Altitude"), "m", series(log.altitude_m), scales, weight=1.2, gap_s=1.0))
    return Opened(tuple(lanes), Span(0.0, max(log.duration_s, last_s)), _MIDNIGHT_S, [], [], FlightSummary(log), 0.0)


def _chosen(limits: TriggerLimits, start_s: float) -> LimitSteps:
    """The thresholds that are tried, all the time."""
    tilt_deg, force_g, time_s = limits[:3]
    steps = LimitSteps()
    steps.put(start_s, ModuleLimits(tilt_deg, limits.reset_angle_deg, force_g, time_s))
    return steps


class LogView(QWidget):
    """`columns_chosen` has the name of a table and its `CsvColumns`."""

    closed = Signal()
    columns_chosen = Signal(str, object)

    def __init__(self, in_use: LimitsInUse) -> None:
        super().__init__()
        self.setObjectName("log_view")
        self._in_use = in_use
        self._row: LogRow | None = None
        self._limits = TriggerLimits()
        self.plot: TimePlot | None = None
        self._reading: BackgroundTask[Opened] = BackgroundTask("dps-s log", self)
        back = QPushButton(tr("All logs"))
        self.back = control(back, "log_back", tip="Esc", picture=Icon.CHEVRON_LEFT, slot=self.close_log)
        self.name = named(ElidedLabel(), "log_name", "title")
        self.picture = IconLabel("log_icon", IconSize.NOTICE)
        self.verdict = text_label("log_verdict", "strong", is_selectable=True)
        self.details = text_label("log_details", "small", is_selectable=True)
        self.columns = QWidget()
        self.line = named(QLineEdit(), "log_columns", says=tr("Columns"))
        self.line.returnPressed.connect(self._choose_columns)
        self.read = control(QPushButton(tr("Read")), "log_read", picture=Icon.CHECK, role="primary")
        self.read.clicked.connect(self._choose_columns)
        self.fault = text_label("log_fault", "danger")
        verdict = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.verdict, 1))
        in_row((self.line, 1), self.read, of=self.columns, margins=0)
        self._card = named(QFrame(), "log_card", "card")
        self._room = in_column(of=self._card, margins=Space.S)
        parts = in_row((self.name, 1), self.back), verdict, self.details, self.columns, self.fault, (self._card, 1)
        in_column(*parts, of=self, margins=(0, Space.S, 0, 0)).addStretch()

    def show_log(self, row: LogRow, limits: TriggerLimits) -> None:
        """Reads the file in the background; of one that could not be read, says why, and asks for columns."""
        self.clear()
        self._row, self._limits = row, limits
        self.name.setText(short_name(row.name) if row.entry is None else row.label)
        self._show_details("" if row.entry is None else clean(entry_text(row.entry), longest=1000))
        log = row.log
        if log.why_not is not None:
            self._say(Icon.WARNING, clean(log.why_not.translated(), longest=2000), Meaning.ATTENTION)
            if log.head:
                # What was said before and what is proposed stand in the line already.
                words = [*map(shlex.quote, role_words(log.columns or {}))]
                cure = str(dict(log.why_not.values).get("cure", "")).replace("--column ", "")
                self.line.setText(" ".join([*words, cure]).strip())
                self.columns.show()
                self.line.setFocus()
            return
        self._say(Icon.CLOCK, tr("Reading logs…"))

        def fail(error: Exception) -> None:
            self._say(Icon.WARNING, clean(error_text(error), longest=2000), Meaning.ATTENTION)
            if not isinstance(error, UserError):
                raise error

        self._reading.run(lambda _: read(Path(row.name), log.columns, limits, self._in_use), self._show, fail)

    def clear(self) -> None:
        self._reading.cancel()
        self._row = None
        self.fault.clear()
        for widget in (self.columns, self.fault, self._card):
            widget.hide()
        if self.plot is not None:
            self._room.removeWidget(self.plot)
            self.plot.deleteLater()
            self.plot = None

    def close_log(self) -> None:
        self.clear()
        self.closed.emit()

    def _say(self, picture: Icon, text: str, meaning: Meaning | None = None) -> None:
        self.picture.show_icon(picture, meaning, is_muted=meaning is None)
        self.verdict.setText(text)

    def _show_details(self, *lines: str) -> None:
        self.details.setText("\n".join(dict.fromkeys(filter(None, lines))))
        self.details.setVisible(bool(self.details.text()))

    def _show(self, opened: Opened) -> None:
        """The verdict is what the list would say now, with the thresholds that are tried."""
        row, flight, start_s = self._row, opened.flight, opened.start_s
        if row is None:
            return
        details, marks = [self.details.text(), *opened.details], opened.marks
        moments_s: list[float] = []
        if flight is None:
            self._say(Icon.UNKNOWN, tr("no status reports"), Meaning.ATTENTION)
        else:
            outcome = flight.outcome(self._limits)
            verdict = verdict_of(outcome, row.log.group)
            group = "" if row.log.group is FlightGroup.UNSORTED else f" · {tr(row.log.group.value)}"
            self._say(verdict.icon, outcome_text(flight, outcome) + group, verdict.meaning)
            details += [clean(problem.translated()) for problem in flight.problems]
            if outcome.sources:
                moments_s.append(outcome.at_s)
                marks.append(Mark(outcome.at_s + start_s, marked("fires"), Icon.PARACHUTE, verdict.meaning))
            if flight.loss_s is not None:
                moments_s.append(flight.loss_s)
                word = marked("control lost (estimate)")
                marks.append(Mark(flight.loss_s + start_s, word, Icon.WARNING, Meaning.ATTENTION))
            if flight.impact_s is not None:
                marks.append(Mark(flight.impact_s + start_s, marked("impact"), Icon.DROP))
        self._show_details(*details)
        plot = self.plot = TimePlot(opened.lanes, wall_offset_s=opened.wall_offset_s, bounds=opened.bounds)
        # A plot keeps a thousand: of more the most important, which are those that it is given last.
        plot.add_marks(sorted(marks, key=lambda mark: -mark.rank))
        self._room.addWidget(plot)
        self._card.show()
        for moment_s in moments_s[:1]:
            plot.time_range.choose_length(_WINDOW_S)
            plot.time_range.show_instant(moment_s + start_s)
        plot.draw(opened.bounds.end_s)

    def _choose_columns(self) -> None:
        try:
            columns = parse_line(self.line.text())
        except UserError as error:
            self.fault.setText(error.sentence)
            self.fault.show()
            return
        if self._row is not None:
            self.columns_chosen.emit(self._row.name, columns)
