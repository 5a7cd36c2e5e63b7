"""Plots of one flight log: tilt, acceleration, altitude and the thresholds, read from its file in the background."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QWidget

from app.flights.columns import CsvColumns
from app.flights.flight_log import FlightLog
from app.flights.judge import MAX_GAP_S, TriggerLimits
from app.flights.raw_log import Floats
from app.flights.read_log import read_flight_log
from app.samples.ring_buffers import Readable
from app.samples.step_function import StepFunction
from app.text.csv_cells import BYTE_ORDER_MARK, csv_text
from app.text.i18n import tr
from app.text.sentences import labelled
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.files.save_bar import SaveNote
from ui.plots.lanes import Lane, Scale, Span, Steps, acceleration_lane, tilt_lane
from ui.plots.time_plot import TimePlot
from ui.style.theme import Space
from ui.widgets.controls import named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column

_WINDOW_S: Final = 10.0
_MIDNIGHT_S: Final = time.mktime((2001, 1, 1, 0, 0, 0, 0, 0, -1))
"""Makes the plots, which show the time of day, show the time since the log began."""


class FlightPlot(QWidget):
    """`shown`: the plot is there, with what `judge` answered for the log."""

    shown = Signal(object)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_plot")
        self.plot: TimePlot | None = None
        self._path: Path | None = None
        self._trouble: UserError | None = None
        """Why the file could not be read."""
        self._reading: BackgroundTask[tuple[FlightLog, object]] = BackgroundTask("dps-s flight", self)
        self.saved = SaveNote(f"{name}_saved", is_of_module=False)
        self.waiting = text_label(f"{name}_waiting", "muted")
        self.waiting.setAlignment(Qt.AlignmentFlag.AlignCenter)
        card = named(QFrame(), f"{name}_card", "card")
        self._room = in_column((self.waiting, 1), of=card, margins=Space.S)
        in_column(self.saved, (card, 1), of=self, spacing=Space.XS, margins=0)

    def open(
        self, path: Path, limits: TriggerLimits, judge: Callable[[FlightLog], object], columns: CsvColumns | None = None
    ) -> None:
        """Reads the file and judges it in the background."""
        self.close_log()
        self._path = path
        self.waiting.setText(tr("Reading logs…"))
        self.waiting.show()

        def read(_running: object) -> tuple[FlightLog, object]:
            log = read_flight_log(path, columns)
            return log, judge(log)

        self._reading.run(read, partial(self._show, path, limits), self._fail)

    def close_log(self) -> None:
        self._reading.cancel()
        self.saved.job.end(is_page_left=True)
        self._path = None
        if self.plot is not None:
            self._room.removeWidget(self.plot)
            self.plot.hide()
            self.plot.deleteLater()
            self.plot = None

    def look_at(self, moment_s: float) -> None:
        if self.plot is not None:
            self.plot.time_range.choose_length(_WINDOW_S)
            self.plot.time_range.show_instant(moment_s)

    def _show(self, path: Path, limits: TriggerLimits, read: tuple[FlightLog, object]) -> None:
        log, judged = read
        self.waiting.hide()
        end_s = max(log.duration_s, float(log.time_s[-1]))
        plot = self.plot = TimePlot(lanes_of(log, limits), wall_offset_s=_MIDNIGHT_S, bounds=Span(0.0, end_s))
        note, place = self.saved, path.with_name(f"{path.stem}-plot.png")
        plot.save_picture_wanted.connect(
            lambda: note.save_picture(place, plot.canvas.grab().toImage(), plot.canvas.svg())
        )
        plot.save_values_wanted.connect(
            lambda: note.save_values(place.with_suffix(".csv"), values_csv(log, plot.time_range.span))
        )
        self._room.addWidget(plot, 1)
        self.shown.emit(judged)
        plot.draw(end_s)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        if self._path is not None:
            self.waiting.setText(labelled(self._path.name, error.sentence))


def values_csv(log: FlightLog, span: Span) -> Iterator[bytes]:
    """All samples of a span as a table; empty cells are unknown."""
    in_sight = (log.time_s >= span.start_s) & (log.time_s <= span.end_s)
    columns = [("time_s", log.time_s), ("tilt_deg", log.tilt_deg), ("acceleration_g", log.specific_force_g)]
    if log.altitude_m is not None:
        columns.append(("altitude_m", log.altitude_m))
    rows = zip(*(values[in_sight].tolist() for _, values in columns), strict=True)
    cells = ([round(value, 6) if math.isfinite(value) else None for value in row] for row in rows)
    yield BYTE_ORDER_MARK + csv_text([name for name, _ in columns], cells).encode()


def lanes_of(log: FlightLog, limits: TriggerLimits) -> Sequence[Lane]:
    def steps(value: float) -> Steps:
        constant = StepFunction()
        constant.put(float(log.time_s[0]), value)
        return constant, None

    fires, rearms = steps(limits.attitude_threshold_deg), steps(limits.reset_angle_deg)
    falls = steps(limits.freefall_acceleration_g)
    lanes = [
        tilt_lane(_series(log.time_s, log.tilt_deg), fires, rearms, gap_s=MAX_GAP_S),
        acceleration_lane(_series(log.time_s, log.specific_force_g), falls, gap_s=MAX_GAP_S),
    ]
    if log.altitude_m is not None and np.isfinite(log.altitude_m).any():
        known = log.altitude_m[np.isfinite(log.altitude_m)]
        series = _series(log.time_s, log.altitude_m)
        lanes.append(Lane(marked("Altitude"), "m", series, (_scale_of(known),), weight=1.2, gap_s=1.0))
    return lanes


def _series(time_s: Floats, values: Floats) -> Readable:
    is_known = np.isfinite(values)
    times, known = time_s[is_known], values[is_known].astype(np.float32)
    return Readable(times, known)


def _scale_of(values: Floats) -> Scale:
    """With some room around all values."""
    low, high = float(values.min()), float(values.max())
    room = max(0.5, (high - low) * 0.1)
    return Scale(low - room, high + room, 0.0)
