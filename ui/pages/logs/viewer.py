"""One log in place of the list: its verdict, its plots with the thresholds and marks; or why it could not be read."""

import shlex
import time
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLineEdit, QWidget

from app.flights.flight_log import FlightLog, Floats
from app.flights.judge import MAX_GAP_S, TriggerLimits
from app.flights.judging import FlightGroup, summarise
from app.flights.read_log import flight_of_recording, read_flight_log
from app.flights.table import CsvColumns, parse_line, role_words
from app.limits.limits import LimitsInUse
from app.recordings.excerpt import LimitSteps
from app.recordings.library import entry_of, entry_text
from app.recordings.markers import ModuleLimits
from app.recordings.recording import Recording, open_recording
from app.samples.samples import Readable
from app.text.i18n import tr
from app.text.messages import UserError, clean, error_text
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.pages.logs.rows import LogRow, button, outcome_text, row_text, short_name, verdict_of
from ui.plots.lanes import Lane, Mark, Scale, Span, acceleration_lane, mark_of, measured_lanes, tilt_lane
from ui.plots.time_plot import TimePlot
from ui.style.icons import Icon
from ui.style.theme import IconSize, Meaning, Space
from ui.widgets.controls import ElidedLabel, IconLabel, in_column, in_row, named, text_label

_WINDOW_S: Final = 10.0
# Makes the plots, which show the time of day, show the time since the log began.
_MIDNIGHT_S: Final = time.mktime((2001, 1, 1, 0, 0, 0, 0, 0, -1))
# What was read of a log; one of the two may be missing.
Opened = tuple[Recording | None, FlightLog | None]


def read(path: Path, columns: CsvColumns | None) -> Opened:
    """Raises `UserError`."""
    if path.suffix.lower() != ".mcap":
        return None, read_flight_log(path, columns)
    recording = open_recording(entry_of(path))
    try:
        return recording, flight_of_recording(recording)
    except UserError:  # it holds nothing to judge
        return recording, None


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
        self.back = button("log_back", tr("All logs"), Icon.CHEVRON_LEFT, self.close_log)
        self.back.setToolTip("Esc")
        self.name = named(ElidedLabel(), "log_name", "title")
        self.picture = IconLabel("log_icon", IconSize.NOTICE)
        self.verdict = text_label("log_verdict", "strong", is_selectable=True)
        self.details = text_label("log_details", "small", is_selectable=True)
        self.columns = QWidget()
        self.line = named(QLineEdit(), "log_columns")
        self.line.setAccessibleName(tr("Columns"))
        self.line.returnPressed.connect(self._choose_columns)
        self.read = button("log_read", tr("Read"), Icon.CHECK, self._choose_columns, "primary")
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

        self._reading.run(lambda _running: read(Path(row.name), log.columns), self._show, fail)

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
        row, (recording, log) = self._row, opened
        if row is None:
            return
        details, marks, moment_s = [self.details.text()], list[Mark](), None
        start_s = 0.0 if recording is None or log is None else log.start_s
        if recording is not None:
            bounds, offset_s = Span(recording.start_s, recording.end_s), recording.wall_offset_s
            # The thresholds that are tried; the module's own ones are in the text above.
            tried, held = _chosen(self._limits, recording.start_s), recording.last()
            tried.lights = recording.lights
            lanes = measured_lanes(recording, self._in_use, tried, LimitSteps())
            marks += map(mark_of, recording.markers)
            had = (
                "" if held.fires_deg is None else f"{held.fires_deg:g}°",
                "" if held.free_fall_g is None else f"{held.free_fall_g:g} g",
                "" if held.free_fall_s is None else f"{held.free_fall_s:.2f} s",
            )
            if any(had):
                details.append(tr("On the module: {value}", value=" · ".join(filter(None, had))))
            details.append("" if recording.damage is None else recording.damage.translated())
        elif log is not None:
            bounds, offset_s = Span(0.0, max(log.duration_s, float(log.time_s[-1]))), _MIDNIGHT_S
            lanes = _flight_lanes(log, self._limits)
            marks += map(mark_of, log.resets)
        if log is None:
            self._say(Icon.UNKNOWN, tr("no status reports"), Meaning.ATTENTION)
        else:
            flight = summarise(log)
            outcome = flight.outcome(self._limits)
            verdict = verdict_of(outcome, row.log.group)
            group = "" if row.log.group is FlightGroup.UNSORTED else f" · {tr(row.log.group.value)}"
            self._say(verdict.icon, outcome_text(flight, outcome) + group, verdict.meaning)
            details += [clean(problem.translated()) for problem in log.problems]
            if outcome.sources:
                moment_s = outcome.at_s
                marks.append(Mark(outcome.at_s + start_s, marked("fires"), Icon.PARACHUTE, verdict.meaning))
            if flight.loss_s is not None:
                moment_s = flight.loss_s if moment_s is None else moment_s
                word = marked("control lost (estimate)")
                marks.append(Mark(flight.loss_s + start_s, word, Icon.WARNING, Meaning.ATTENTION))
            if flight.impact_s is not None:
                marks.append(Mark(flight.impact_s + start_s, marked("impact"), Icon.DROP, None))
        self._show_details(*details)
        self.details.setToolTip(row_text(row))
        plot = self.plot = TimePlot(lanes, wall_offset_s=offset_s, bounds=bounds)
        plot.add_marks(marks)
        self._room.addWidget(plot)
        self._card.show()
        if moment_s is not None:
            plot.time_range.choose_length(_WINDOW_S)
            plot.time_range.show_instant(moment_s + start_s)
        plot.draw(bounds.end_s)

    def _choose_columns(self) -> None:
        try:
            columns = parse_line(self.line.text())
        except UserError as error:
            self.fault.setText(error.sentence)
            self.fault.show()
            return
        if self._row is not None:
            self.columns_chosen.emit(self._row.name, columns)


def _chosen(limits: TriggerLimits, start_s: float) -> LimitSteps:
    """The thresholds that are tried, all the time."""
    tilt_deg, force_g, time_s = limits[:3]
    steps = LimitSteps()
    steps.put(start_s, ModuleLimits(tilt_deg, limits.reset_angle_deg, force_g, time_s))
    return steps


def _flight_lanes(log: FlightLog, limits: TriggerLimits) -> tuple[Lane, ...]:
    def series(values: Floats) -> Readable:
        is_known = np.isfinite(values)
        return Readable(log.time_s[is_known], values[is_known].astype(np.float32))

    chosen = _chosen(limits, float(log.time_s[0]))
    tilt = tilt_lane(series(log.tilt_deg), (chosen.fires, None), (chosen.rearms, None), gap_s=MAX_GAP_S)
    force = acceleration_lane(series(log.specific_force_g), (chosen.falls, None), gap_s=MAX_GAP_S)
    if log.altitude_m is None or not np.isfinite(log.altitude_m).any():
        return tilt, force
    low, high = float(np.nanmin(log.altitude_m)), float(np.nanmax(log.altitude_m))
    room = max(0.5, (high - low) * 0.1)
    scales = (Scale(low - room, high + room, 0.0),)
    return tilt, force, Lane(marked("Altitude"), "m", series(log.altitude_m), scales, weight=1.2, gap_s=1.0)
