"""Plots of one flight: tilt, acceleration and altitude with thresholds, firings and loss of control."""

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QPushButton, QWidget

from app.firing.judge import MAX_GAP_S, TriggerLimits
from app.flight_analysis.flight_set import FlightOutcome
from app.flight_logs.csv_columns import CsvColumns
from app.flight_logs.flight_log import FlightLog, Floats
from app.flight_logs.read_log import read_flight_log
from app.recordings.export import not_saved_text, write_parts
from app.samples.ring_buffers import RecordedSeries, bucket_firsts
from app.samples.step_function import StepFunction
from app.text.csv_cells import BYTE_ORDER_MARK, csv_text
from app.text.i18n import tr
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.core.texts import Texts
from ui.files.file_dialogs import AskPath, ThenPath, ask_path
from ui.files.save_bar import png_parts
from ui.pages.flights.texts import appearance_of, outcome_lines, short_name, verdict_of
from ui.plots.lanes import Lane, Limit, Mark, Scale, Span
from ui.plots.time_plot import TimePlot
from ui.services.page import HEIGHT_PX
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import in_column, in_row

_ICON_PX: Final = 20
_PROBLEMS_SHOWN: Final = 3
_WINDOW_S: Final = 10.0
_SAME_S: Final = 0.05
"""Closer marks are shown as one."""
_MIDNIGHT_S: Final = time.mktime((2001, 1, 1, 0, 0, 0, 0, 0, -1))
"""Makes the plots, which show the time of day, show the time since the log began."""


class FlightView(QWidget):
    closed = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("flight_view")
        self._texts = texts
        self.plot: TimePlot | None = None
        self._outcome: FlightOutcome | None = None
        self._limits = TriggerLimits()
        self._trouble: UserError | None = None
        """Why the file could not be read again."""
        self._reading: BackgroundTask[FlightLog] = BackgroundTask("dps-s flight", self)
        self._saving: BackgroundTask[None] = BackgroundTask("dps-s flight save", self, finished_at_close=True)
        self.ask_path: AskPath = ask_path
        self.back = control(QPushButton(), texts, "flight_back", "All flights", key="Esc", picture=Icon.CHEVRON_LEFT,
                            slot=self.close_flight)  # fmt: skip
        self.name = named(ElidedLabel(), "flight_name", "title")
        self.picture = IconLabel("flight_icon", _ICON_PX)
        self.verdict = text_label("flight_verdict", "strong", is_selectable=True)
        self.problems = text_label("flight_problems", "small", is_selectable=True)
        self.saved = text_label("flight_saved", "small")
        """The outcome of saving."""
        self.saved.hide()
        self.waiting = text_label("flight_waiting", "muted")
        self.waiting.setAlignment(Qt.AlignmentFlag.AlignCenter)
        head = in_row((self.name, 1), self.back, spacing=Space.M)
        head.addStrut(HEIGHT_PX)
        said = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.verdict, 1), spacing=Space.S)
        card = named(QFrame(), "flight_card", "card")
        self._room = in_column((self.waiting, 1), of=card, margins=Space.S)
        in_column(head, said, self.problems, self.saved, (card, 1), of=self, spacing=Space.XS, margins=0)

    def show_flight(self, outcome: FlightOutcome, limits: TriggerLimits, columns: CsvColumns | None) -> None:
        """The file is read again in the background."""
        self._outcome, self._limits, self._trouble = outcome, limits, None
        self._remove_plot()
        self.retranslate()
        self.waiting.show()
        path = Path(outcome.flight.name)
        self._reading.run(lambda _running: read_flight_log(path, columns), self._show_log, self._fail)

    def close_flight(self) -> None:
        self._reading.cancel()
        self._remove_plot()
        self._outcome = None
        self.closed.emit()

    def retranslate(self) -> None:
        outcome = self._outcome
        if outcome is None:
            return
        look = appearance_of(outcome.group, verdict_of(outcome))
        self.picture.show_icon(look.icon, look.meaning)
        self.name.setText(f"{short_name(outcome.flight.name)} · {tr(outcome.group.value)}")
        self.verdict.setText("\n".join(outcome_lines(outcome)))
        problems = [one.translated() for one in outcome.flight.problems]
        shown = problems[:_PROBLEMS_SHOWN]
        if len(problems) > len(shown):
            shown.append(tr("and {count} more", count=len(problems) - len(shown)))
        self.problems.setText("\n".join(clean(one) for one in shown))
        self.problems.setToolTip("\n".join(problems))
        self.problems.setVisible(bool(problems))
        trouble = self._trouble
        self.waiting.setText(
            tr("Reading logs…") if trouble is None else tr("{file}: {why}", file=self.name.text(), why=trouble.sentence)
        )

    def _show_log(self, log: FlightLog) -> None:
        if self._outcome is None:
            return
        self.waiting.hide()
        end_s = max(log.duration_s, float(log.time_s[-1]))
        plot = TimePlot(lanes_of(log, self._limits), self._texts, wall_offset_s=_MIDNIGHT_S, bounds=Span(0.0, end_s))
        plot.add_marks(marks_of(self._outcome, log.resets_s))
        plot.save_picture_wanted.connect(self._save_picture)
        plot.save_values_wanted.connect(partial(self._save_values, log))
        self._room.addWidget(plot, 1)
        self.plot = plot
        moment_s = _moment(self._outcome)
        if moment_s is not None and end_s > _WINDOW_S:
            plot.sight.choose_length(_WINDOW_S)
            plot.sight.show_instant(moment_s)
        plot.draw(end_s)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, UserError):
            raise error
        self._trouble = error
        self.retranslate()

    def _save_picture(self) -> None:
        if self.plot is None:
            return
        drawing, image = self.plot.svg(), self.plot.picture().toImage()

        def save(path: Path) -> None:
            self._save(path, iter((drawing,)) if path.suffix.lower() == ".svg" else png_parts(image))

        self._choose(tr("Save picture…"), ".png", f"{tr('Picture (*.png)')};;{tr('Drawing (*.svg)')}", save)

    def _save_values(self, log: FlightLog) -> None:
        if self.plot is None:
            return
        span = self.plot.sight.span
        save = partial(self._save, parts=values_csv(log, span))
        self._choose(tr("Save values…"), ".csv", tr("Table (*.csv)"), save)

    def _choose(self, title: str, suffix: str, kinds: str, save: ThenPath) -> None:
        if self._outcome is None or self._saving.is_running:
            return
        log = Path(self._outcome.flight.name)
        self.ask_path(self, title, log.with_name(f"{log.stem}-plot{suffix}"), kinds, save)

    def _save(self, path: Path, parts: Iterable[bytes]) -> None:
        def finish(text: str) -> None:
            self.saved.setText(text)
            self.saved.show()

        self._saving.run(
            lambda _running: write_parts(path, parts, 1),
            lambda _none: finish(tr("Saved to {path}.", path=path)),
            lambda error: finish(not_saved_text(path, error)),
        )

    def _remove_plot(self) -> None:
        self.saved.hide()
        if self.plot is not None:
            self._room.removeWidget(self.plot)
            self.plot.hide()
            self.plot.deleteLater()
            self.plot = None


def values_csv(log: FlightLog, span: Span) -> Iterator[bytes]:
    """All samples of a span as a table; empty cells are unknown."""
    first, last = np.searchsorted(log.time_s, span, "left")
    columns = [("time_s", log.time_s), ("tilt_deg", log.tilt_deg), ("acceleration_g", log.specific_force_g)]
    if log.altitude_m is not None:
        columns.append(("altitude_m", log.altitude_m))
    rows = zip(*(values[first : last + 1].tolist() for _, values in columns), strict=True)
    cells = ([round(value, 6) if math.isfinite(value) else None for value in row] for row in rows)
    yield BYTE_ORDER_MARK + csv_text([name for name, _ in columns], cells).encode()


def lanes_of(log: FlightLog, limits: TriggerLimits) -> Sequence[Lane]:
    """A lane per quantity in the log, with its thresholds."""
    start_s = float(log.time_s[0])
    lanes = [
        Lane(
            marked("Tilt"), "°", _series(log.time_s, log.tilt_deg), (Scale(0, 90, 30), Scale(0, 180, 45)),
            (
                Limit(_standing(start_s, limits.attitude_threshold_deg), marked("{value}° fires"), Meaning.DANGER),
                Limit(_standing(start_s, limits.reset_angle_deg), marked("{value}° rearms"), Meaning.INFORMATION),
            ),
            weight=3, gap_s=MAX_GAP_S,
        ),
        Lane(
            marked("Acceleration"), "g", _series(log.time_s, log.specific_force_g),
            (Scale(0, 2, 1), Scale(0, 4, 2), Scale(0, 8, 4), Scale(0, 16, 8), Scale(0, 26, 13)),
            (Limit(_standing(start_s, limits.freefall_acceleration_g), marked("{value} g free fall"), Meaning.DANGER,
                   1),),
            decimals=1, weight=2, gap_s=MAX_GAP_S,
        ),
    ]  # fmt: skip
    if log.altitude_m is not None and np.isfinite(log.altitude_m).any():
        known = log.altitude_m[np.isfinite(log.altitude_m)]
        series = _series(log.time_s, log.altitude_m)
        lanes.append(Lane(marked("Altitude"), "m", series, (_scale_of(known),), weight=1.2, gap_s=1.0))
    return lanes


def marks_of(outcome: FlightOutcome, resets_s: Sequence[float] = ()) -> list[Mark]:
    """Marks in order of time."""
    flight = outcome.flight
    meaning = appearance_of(outcome.group, verdict_of(outcome)).meaning
    marks = [Mark(at_s, marked("restarted"), Icon.RESTART, Meaning.ATTENTION) for at_s in resets_s]
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
    return sorted(marks, key=lambda one: one.time_s)


def _moment(outcome: FlightOutcome) -> float | None:
    """Time that is shown first."""
    fires = [fire.at_s for fire in (outcome.direct, outcome.damped) if fire.sources]
    return min(fires) if fires else outcome.flight.loss_s


def _series(time_s: Floats, values: Floats) -> RecordedSeries:
    is_known = np.isfinite(values)
    times, known = time_s[is_known], values[is_known].astype(np.float32)
    return RecordedSeries(times, known, bucket_firsts(times))


def _standing(start_s: float, value: float) -> StepFunction:
    steps = StepFunction()
    steps.put(start_s, value)
    return steps


def _scale_of(values: Floats) -> Scale:
    """A scale with round ends that contains all values."""
    low, high = float(values.min()), float(values.max())
    step = next(one for one in _STEPS_M if (high - low) / one <= 3)
    first = np.floor(low / step) * step
    count = max(1.0, float(np.ceil((high - first) / step + 0.1)))  # not on the edge
    return Scale(float(first), float(first + count * step), step)


_STEPS_M: Final = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 5000.0, 1e5, 1e7, 1e9, 1e300)
