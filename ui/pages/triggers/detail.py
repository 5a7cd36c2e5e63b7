"""Details of the selected trigger records, with what made the module fire as a picture, and what a person judges."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetrics, QFontMetricsF, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QFrame, QLineEdit, QSizePolicy, QToolButton

from app.records.check_store import MAX_NOTE_LENGTH
from app.system.wall_clock import local_time
from app.text.i18n import tr
from app.text.sentences import capitalised, with_units
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, cause_message, uptime_message
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.messages import TriggerRecord
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.rows_table import FactRows
from ui.pages.triggers.controller import TriggerRow
from ui.pages.triggers.model import COLUMNS, Column, sources_text
from ui.plots.gauge import draw_aircraft
from ui.style import icons
from ui.style.icons import Icon
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, Space, current, fixed_font, font
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import FlowRow, Gap, in_column

_BEYOND_DEG: Final = 8.0
"""How far past the threshold the aircraft is drawn; the record does not contain the tilt."""
_CENTRE: Final = Qt.AlignmentFlag.AlignCenter


def _draw_tilt(painter: QPainter, box: QRectF, record: TriggerRecord) -> None:
    """The aircraft past the threshold, which is red; blue is where the trigger rearms."""
    theme, metrics, fires_deg = current(), QFontMetricsF(painter.font()), record.attitude_threshold_deg
    radius = max(24.0, min(box.height() - metrics.height() - 12, (box.width() - 80) / 2))
    rearms_deg = fires_deg - RESET_BELOW_THRESHOLD_DEG
    # One label above the arc, one beside it, so that they never overlap.
    labels = (
        (fires_deg, 0.9, theme.danger.ink, tr("{value}° fires", value=f"{fires_deg:g}")),
        (rearms_deg, 0.1, theme.information.ink, tr("{value}° rearms", value=f"{rearms_deg:g}")),
    )
    ways = [QPointF(math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))) for degrees, *_ in labels]
    widths = [metrics.horizontalAdvance(text) + 2 for *_, text in labels]
    right = max(way.x() * (radius + 10) + width for way, width in zip(ways, widths, strict=True))
    # In the middle, or further left where a label would reach into what is drawn beside it.
    middle = max(box.left() + radius + 3, min(box.center().x(), box.right() - right))
    painter.translate(middle, box.top() + metrics.height() + 6 + radius)
    arc = QRectF(-radius, -radius, 2 * radius, 2 * radius)
    painter.setPen(pen(theme.border, theme.border_px))
    painter.drawLine(QPointF(-radius, 0), QPointF(radius, 0))
    painter.drawArc(arc, 0, 180 * 16)
    painter.setPen(pen(theme.danger.ink, 3.0 + theme.line_px))
    painter.drawArc(arc, round(fires_deg * 16), round((180 - fires_deg) * 16))
    for (_, above, colour, text), way, width in zip(labels, ways, widths, strict=True):
        painter.setPen(pen(colour, 1.0 + theme.line_px))
        painter.drawLine(way * (radius - 6), way * (radius + 6))
        place = way * (radius + 10) - QPointF(0, metrics.height() * above)
        room = QRectF(place.x(), place.y(), width, metrics.height())
        painter.drawText(room, _CENTRE | Qt.TextFlag.TextDontClip, text)
    painter.rotate(-min(180.0, fires_deg + _BEYOND_DEG))
    draw_aircraft(painter, theme, radius * 0.95, QColor(theme.danger.ink))


def _draw_fall(painter: QPainter, box: QRectF, record: TriggerRecord) -> None:
    theme, metrics = current(), QFontMetricsF(painter.font())
    danger = QColor(theme.danger.ink)
    text = tr(
        "below {g} g for {time} s", g=f"{record.freefall_acceleration_g:.1f}", time=f"{record.freefall_time_s:.2f}"
    )
    line = metrics.height() * (1 if metrics.horizontalAdvance(text) < box.width() else 2)
    radius = max(24.0, min((box.height() - line) * 0.62, box.width() / 2.6))
    painter.setPen(danger)
    room = QRectF(box.left(), box.bottom() - line, box.width(), line)
    painter.drawText(room, _CENTRE | Qt.TextFlag.TextWordWrap, text)
    centre = QPointF(box.center().x(), box.top() + (box.height() - line) * 0.42)
    painter.translate(centre)
    painter.setPen(pen(theme.muted, 1.0 + theme.line_px))
    for x in (-0.45 * radius, 0.0, 0.45 * radius):
        painter.drawLine(QPointF(x, box.top() + 4 - centre.y()), QPointF(x, -radius * 0.3))
    draw_aircraft(painter, theme, radius * 0.95, danger)
    tip = QPointF(0, radius * 0.66)
    painter.setPen(pen(danger, 2.0))
    painter.drawLine(QPointF(0, radius * 0.3), tip)
    head = QPainterPath(tip)
    head.lineTo(tip + QPointF(-6, -8))
    head.lineTo(tip + QPointF(6, -8))
    painter.fillPath(head, danger)


def _draw_command(painter: QPainter, box: QRectF, _record: TriggerRecord, *, picture: Icon) -> None:
    square = QRectF(QPointF(), QSize(1, 1) * min(48.0, box.height() * 0.5))
    square.moveCenter(box.center())
    icons.draw(painter, picture, square, current().ink(Meaning.DANGER))


_DRAWN: Final[dict[str, tuple[float, Callable[[QPainter, QRectF, TriggerRecord], None]]]] = {
    "attitude": (1.25, _draw_tilt),  # it has labels beside it
    "freefall": (1.0, _draw_fall),
    "serial": (1.0, partial(_draw_command, picture=Icon.LINK)),
    "pwm": (1.0, partial(_draw_command, picture=Icon.PLUG)),
}
"""The share in the width of each cause, and what draws it."""


class TriggerPicture(PaintedWidget):
    """Draws the causes in a trigger record side by side."""

    usual: ClassVar = QSize(280, 96)
    least: ClassVar = QSize(0, 0)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self._record: TriggerRecord | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.use_card_background()

    def show_record(self, record: TriggerRecord | None, words: str) -> None:
        """`words`: the causes, for screen readers."""
        self._record = record
        self.announce(words)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, record = self.begin_paint(), self._record
        if record is not None:
            parts = [_DRAWN[cause] for cause in record.sources if cause in _DRAWN]
            left, whole = 0.0, sum(share for share, _ in parts)
            for share, draw in parts:
                width = self.width() * share / whole
                painter.save()
                painter.setFont(font(Size.SMALL, is_bold=True))
                draw(painter, QRectF(left, 0, width, self.height()), record)
                painter.restore()
                left += width
        painter.end()


_FACTS: Final = {
    "link": Column.LINK,
    "charger": Column.CHARGE,
    "light": Column.LIGHT,
    "cell": Column.CELL,
}
"""Those of the table's columns that may be hidden there."""
JUDGEMENTS: Final = (None, *Judgement)
WIDTH_PX: Final = 304
_WITH_PICTURE_LINES: Final = 28
"""Height of the page, in lines of text, from which the picture is shown."""


class TriggersDetail(QFrame):
    """`judged`: the record's id, the judgement (None removes it) and the note."""

    judged = Signal(int, object, str)

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "triggers_detail", "card")
        self._rows: Sequence[TriggerRow] = ()
        self._note_of: int | None = None
        self._has_picture = True
        self.picture = TriggerPicture("triggers_picture")
        self.cause = text_label("triggers_cause", "strong", is_selectable=True)
        self.facts = FactRows(
            texts, "triggers", {"when": marked("Time")} | {key: COLUMNS[column].title for key, column in _FACTS.items()}
        )
        self.seen = text_label("triggers_seen", "small", is_selectable=True)
        self.bytes = text_label("triggers_bytes", "muted", is_selectable=True)
        self.bytes.hide()
        self.raw = control(QToolButton(), texts, "triggers_raw", "Raw bytes", is_checkable=True)
        self.raw.toggled.connect(self.bytes.setVisible)
        self.buttons: dict[Judgement | None, QToolButton] = {}
        for judgement in JUDGEMENTS:
            name = "none" if judgement is None else judgement.name.lower()
            text = marked("not reviewed") if judgement is None else JUDGEMENT_WORDS[judgement]
            self.buttons[judgement] = control(QToolButton(), texts, f"triggers_judge_{name}", text, role="choice",
                                              is_checkable=True, slot=partial(self._judge, judgement))  # fmt: skip
        self.note = control(QLineEdit(), texts, "triggers_note", says="Note", tip="Note")
        self.note.setMaxLength(MAX_NOTE_LENGTH)
        texts.bind(self.note.setPlaceholderText, "Note")
        self.note.editingFinished.connect(self._commit_note)
        self._lay_out()
        self.show_rows(())

    @property
    def _row(self) -> TriggerRow | None:
        return self._rows[0] if len(self._rows) == 1 else None

    def show_rows(self, rows: Sequence[TriggerRow]) -> None:
        """The selected rows; several are judged at once."""
        self._rows, row = rows, rows[0] if len(rows) == 1 else None
        for widget in (self.facts, self.raw, self.note, self.seen):
            widget.setVisible(row is not None)
        self.picture.setVisible(row is not None and self._has_picture)
        self.bytes.setVisible(row is not None and self.raw.isChecked())
        judgements = {chosen.seen.judgement for chosen in rows if chosen.is_stored}
        for judgement, button in self.buttons.items():
            button.setVisible(bool(rows))
            button.setChecked(judgements == {judgement})
            button.setEnabled(bool(judgements))
        if row is None:
            self.cause.setText(tr("{count} selected", count=len(rows)) if rows else tr("Select a row."))
            self._note_of = None
            return
        self.cause.setText(with_units(capitalised(cause_message(row.record).translated())))
        when = tr("{uptime} after power-on, boot {boot}", boot=row.record.boot_count,
                  uptime=uptime_message(row.record).translated())  # fmt: skip
        self.facts.show_facts({"when": when} | {key: COLUMNS[column].text(row) for key, column in _FACTS.items()})
        self.picture.show_record(row.record, sources_text(row.record.sources))
        self.bytes.setText(row.record.raw.hex(" ").upper())
        self.bytes.setFont(fixed_font(Size.SMALL))
        self.seen.setText(self._seen_text(row))
        self.note.setEnabled(row.is_stored)
        if self._note_of != row.seen.id or not self.note.hasFocus():
            self.note.setText(row.seen.note)
        self._note_of = row.seen.id

    @staticmethod
    def _seen_text(row: TriggerRow) -> str:
        if row.is_seen_once:
            return tr("Seen in one reading only. Read again.")
        if row.is_being_stored:
            return tr("Saving…")
        if not row.is_stored:
            return tr("Not kept.")
        where = tr("On the module") if row.is_on_module else tr("No longer on the module")
        return f"{tr('First seen {time}', time=local_time(row.seen.first_seen_at))} · {where}"

    def _judge(self, judgement: Judgement | None, _is_checked: bool = False) -> None:
        alone = self._row
        for row in self._rows:
            if row.is_stored:
                self.judged.emit(row.seen.id, judgement, row.seen.note if alone is None else self.note.text())

    def _commit_note(self) -> None:
        row = self._row
        if row is not None and row.is_stored and self.note.text() != row.seen.note:
            self.judged.emit(row.seen.id, row.seen.judgement, self.note.text())

    def fit_height(self, page_px: int) -> None:
        self._has_picture = page_px >= _WITH_PICTURE_LINES * QFontMetrics(font()).height()
        self.picture.setVisible(self._row is not None and self._has_picture)

    def _lay_out(self) -> None:
        judging, tools = FlowRow(*self.buttons.values()), FlowRow(right=(self.raw,))
        in_column(
            self.picture,
            self.cause,
            self.facts,
            self.seen,
            Gap(Space.XS),
            judging,
            self.note,
            1,
            self.bytes,
            tools,
            of=self,
            spacing=Space.S,
            margins=Space.M,
        )
