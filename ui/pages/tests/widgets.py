"""Widgets of the Tests page and what they say: picture, list of steps, live value, result."""

from datetime import datetime
from pathlib import Path
from typing import ClassVar, Final, NamedTuple

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.guided.results import (
    VERDICT_WORDS,
    GuidedKind,
    GuidedResult,
    GuidedVerdict,
    MeasuredValue,
    StoredTest,
)
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import capitalised, join_names
from app.text.user_error import UserError
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.tests.controller import GuidedController, Stage
from ui.services.port import Ports
from ui.style.icons import MEANING_ICONS, Icon, icon, themed_svg
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, Space, current, font, scaled
from ui.widgets.controls import named, set_role
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import in_column, in_row

_MARK_PX: Final = 18
_BAR_PX: Final = 12
_MAX_STEPS: Final = 6


def step_pictures() -> QSvgRenderer:
    """`steps.svg` in the theme's colours, with thick lines in sunlight."""
    theme = current()
    return themed_svg(
        Path(__file__).parent / "steps.svg", **{meaning.value: theme.tint(meaning).ink for meaning in Meaning},
        text=theme.text, muted=theme.muted, border=theme.border, surface=theme.surface, raised=theme.raised,
        wash=theme.information.wash, line=theme.line_px + 1, thick=theme.line_px + 2,
        size=scaled(Size.SMALL), side=tr("from the side"), behind=tr("from behind"),
    )  # fmt: skip


class GuidedPicture(PaintedWidget):
    usual: ClassVar = QSize(280, 170)

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_picture")
        self._kind, self._step = GuidedKind.TILT, 0
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def show_step(self, kind: GuidedKind, step: int, what: str) -> None:
        """`what`: the step in words, for screen readers."""
        self._kind, self._step = kind, step
        self.announce(tr("Picture: {what}", what=what))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        painter.setPen(pen(theme.divider, theme.border_px))
        painter.setBrush(QColor(theme.surface))
        box = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        painter.drawRoundedRect(box, 8, 8)
        step_pictures().render(painter, f"{self._kind.value}-{self._step}", box)
        painter.end()


class StepList(QWidget):
    """Numbered steps, marked as done, current or still to do."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_steps")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(Space.S)
        grid.setVerticalSpacing(Space.XS)
        grid.setColumnStretch(1, 1)
        self.rows: list[tuple[IconLabel, QLabel]] = []
        for number in range(_MAX_STEPS):
            mark = IconLabel(f"tests_step_{number}_mark", _MARK_PX)
            mark.setFixedWidth(_MARK_PX)
            text = text_label(f"tests_step_{number}")
            grid.addWidget(mark, number, 0, Qt.AlignmentFlag.AlignTop)
            grid.addWidget(text, number, 1)
            self.rows.append((mark, text))
        grid.setRowStretch(_MAX_STEPS, 1)

    def show_steps(self, steps: tuple[str, ...], step: int, *, is_running: bool) -> None:
        """`steps`: translated; those before `step` are done."""
        for number, (mark, label) in enumerate(self.rows):
            is_there = number < len(steps)
            mark.setVisible(is_there)
            label.setVisible(is_there)
            if not is_there:
                continue
            is_done, is_now = number < step, is_running and number == step
            state = tr("done") if is_done else tr("now") if is_now else tr("to do")
            text = f"{number + 1}. {steps[number]}"
            if label.text() != text:
                label.setText(text)
            label.setAccessibleName(f"{text} ({state})")
            set_role(label, "strong" if is_now else "" if is_done else "muted")
            if is_done:
                mark.show_icon(Icon.CHECK, Meaning.GOOD)
            elif is_now:
                mark.show_icon(Icon.CHEVRON_RIGHT, Meaning.INFORMATION)
            else:
                mark.clear_icon()


class LiveMark(NamedTuple):
    """A limit on the bar."""

    value: float
    text: str
    meaning: Meaning


class LiveReading(NamedTuple):
    """A current value. `value` None: unknown. `shown`: translated."""

    caption: str
    shown: str
    value: float | None = None
    highest: float = 0.0
    """End of the bar; 0: no bar."""
    marks: tuple[LiveMark, ...] = ()


class LiveValue(PaintedWidget):
    """A number with a caption, above a bar with the limits."""

    usual: ClassVar = QSize(320, 84)
    least: ClassVar = QSize(200, 84)

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_live")
        self._reading = LiveReading("", "")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_reading(self, reading: LiveReading) -> None:
        if reading != self._reading or not self.accessibleName():
            self._reading = reading
            # Without the number, which changes all the time.
            limits = ", ".join(mark.text for mark in reading.marks)
            self.announce(f"{reading.caption}: {limits}" if limits else reading.caption)

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, reading = current(), self._reading
        painter = self.begin_paint()
        number = font(Size.NUMBER, is_bold=True)
        painter.setFont(number)
        painter.setPen(QColor(theme.text if reading.value is not None else theme.muted))
        painter.drawText(QRectF(0, 0, self.width(), 36), Qt.AlignmentFlag.AlignVCenter, reading.shown)
        width = QFontMetricsF(number).horizontalAdvance(reading.shown)
        painter.setFont(font(Size.BODY))
        painter.setPen(QColor(theme.muted))
        caption = QRectF(width + Space.M, 4, max(0.0, self.width() - width - Space.M), 32)
        painter.drawText(caption, Qt.AlignmentFlag.AlignVCenter, reading.caption)
        if reading.highest > 0:
            self._paint_bar(painter, QRectF(1, 44, self.width() - 2, _BAR_PX))
        painter.end()

    def _paint_bar(self, painter: QPainter, bar: QRectF) -> None:
        theme, reading = current(), self._reading
        painter.setPen(pen(theme.border, theme.border_px))
        painter.setBrush(QColor(theme.sunken))
        painter.drawRoundedRect(bar, 5, 5)
        if reading.value is not None:
            part = min(1.0, max(0.0, reading.value / reading.highest))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(theme.information.ink))
            filled = bar.adjusted(1, 1, -1, -1)
            filled.setWidth(max(3.0, filled.width() * part))
            painter.drawRoundedRect(filled, 4, 4)
        painter.setFont(font(Size.SMALL))
        metrics = QFontMetricsF(painter.font())
        taken = -1.0
        for mark in sorted(reading.marks, key=lambda mark: mark.value):
            x = bar.left() + bar.width() * min(1.0, max(0.0, mark.value / reading.highest))
            ink = theme.tint(mark.meaning).ink
            painter.setPen(pen(ink, theme.line_px + 1))
            painter.drawLine(QPointF(x, bar.top() - 4), QPointF(x, bar.bottom() + 4))
            wide = metrics.horizontalAdvance(mark.text)
            left = min(max(taken + Space.S, x - wide / 2), bar.right() - wide)
            painter.setPen(QColor(ink))
            painter.drawText(QRectF(left, bar.bottom() + 4, wide + 2, 18), Qt.AlignmentFlag.AlignVCenter, mark.text)
            taken = left + wide


VERDICT_MEANINGS = {
    GuidedVerdict.PASSED: Meaning.GOOD,
    GuidedVerdict.FAILED: Meaning.DANGER,
    GuidedVerdict.UNCLEAR: Meaning.ATTENTION,
}
_UNKNOWN = "–"


def instruction(work: GuidedController) -> str:
    """What to do now."""
    if work.stage in (Stage.PREPARING, Stage.MEASURING):
        report = work.report
        return _formatted(report.doing, report.values) if report is not None else tr("Asking the module…")
    return work.test.steps[work.step].translated() if work.stage is Stage.CONFIRMING else ""


def _formatted(text: str, values: tuple[tuple[str, object], ...]) -> str:
    words = {name: value.translated() if isinstance(value, UserMessage) else value for name, value in values}
    return tr(text, **words) if "{" in text else tr(text)


def last_text(last: StoredTest | None) -> str:
    """Result, date and person of the last test."""
    if last is None:
        return tr("never tested")
    try:
        when = f"{datetime.fromisoformat(last.at).astimezone():%Y-%m-%d}"
    except ValueError:
        when = last.at
    verdict = tr(VERDICT_WORDS[last.verdict])
    return f"{verdict} {when}, {last.who or '—'}"


def live_reading(work: GuidedController, connector: Ports) -> LiveReading:
    """The current value against the limits of the test."""

    def fresh(key: str) -> float | None:
        value = connector.current.device.fresh(key, connector.clock())
        return None if value is None else float(value)

    def reading(
        caption: str, key: str, unit: str, decimals: int, highest: float, *marks: tuple[float | None, str, Meaning]
    ) -> LiveReading:
        value = fresh(key)
        limits = tuple(
            LiveMark(at, tr(text, value=f"{at:.{decimals}f}"), meaning) for at, text, meaning in marks if at is not None
        )
        shown = _UNKNOWN if value is None else f"{value:.{decimals}f}{unit}"
        return LiveReading(caption, shown, value, highest, limits)

    match work.kind:
        case GuidedKind.TILT:
            fires, has_fired = fresh("attitude_threshold_deg"), fresh("triggered")
            if fires is None:
                return reading(tr("Tilt"), "tilt_deg", "°", 0, 180.0)
            state = tr("TRIGGERED") if has_fired else tr("not triggered")
            return reading(
                join_names((tr("Tilt"), state)), "tilt_deg", "°", 0, 120.0,
                (fires - RESET_BELOW_THRESHOLD_DEG, marked("{value}° rearms"), Meaning.INFORMATION),
                (fires, marked("{value}° fires"), Meaning.DANGER),
            )  # fmt: skip
        case GuidedKind.FREE_FALL:
            limit = (fresh("freefall_acceleration_g"), marked("{value} g free fall"), Meaning.INFORMATION)
            return reading(tr("Acceleration"), "acceleration_g", " g", 1, 2.0, limit)
        case GuidedKind.BAY:
            threshold = fresh("light_threshold_v")
            highest = max(3.0, 1.5 * (threshold or 0.0), fresh("light_v") or 0.0)
            limit = (threshold, marked("{value} V bay open"), Meaning.INFORMATION)
            return reading(tr("Light"), "light_v", " V", 1, highest, limit)
        case _:
            return _losses(work)


def _losses(work: GuidedController) -> LiveReading:
    values = dict(work.report.values) if work.report is not None else {}
    asked, lost = values.get("asked"), values.get("lost")
    if isinstance(asked, int) and isinstance(lost, int):
        return LiveReading(tr("lost"), f"{lost} / {asked}", float(lost))
    return LiveReading(tr("lost"), _UNKNOWN)


_ROW_PX: Final = 28

COLUMNS: Final[tuple[TableColumn[MeasuredValue], ...]] = (
    TableColumn(marked("Quantity"), lambda row: row.name.translated()),
    TableColumn(marked("Measured"), lambda row: row.shown.translated(), stretches=True),
    TableColumn(marked("Tolerance"), lambda row: row.tolerance.translated(), stretches=True),
    TableColumn(
        marked("Result"),
        lambda row: tr(VERDICT_WORDS[row.verdict]),
        picture=lambda row: icon(MEANING_ICONS[VERDICT_MEANINGS[row.verdict]], VERDICT_MEANINGS[row.verdict]),
        ink=lambda row: VERDICT_MEANINGS[row.verdict],
    ),
)


class ResultView(QWidget):
    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "tests_result")
        self.mark, self.verdict = IconLabel("tests_verdict_mark", 24), text_label("tests_verdict", "heading")
        self.advice = text_label("tests_advice")
        self.table = RowsTable(texts, "tests_table", "Measured values", COLUMNS, lambda row: row.name, _row_sentence,
                               row_px=_ROW_PX, is_single=True)  # fmt: skip
        self.table.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        head = in_row(self.mark, (self.verdict, 1), spacing=Space.S)
        in_column(head, self.advice, self.table, 1, of=self, spacing=Space.S, margins=0)

    def show_outcome(self, outcome: GuidedResult | UserError | None) -> None:
        meaning, text, role, measured, advice = Meaning.ATTENTION, "", "title", tuple[MeasuredValue, ...](), None
        if isinstance(outcome, GuidedResult):
            meaning, text = VERDICT_MEANINGS[outcome.verdict], capitalised(tr(VERDICT_WORDS[outcome.verdict]))
            role, measured, advice = "heading", outcome.measured, outcome.advice
        elif outcome is not None:
            text = outcome.message.translated()
        self.mark.show_icon(MEANING_ICONS[meaning], meaning)
        set_role(self.verdict, role)
        self.verdict.setText(text)
        self.verdict.setAccessibleName(text)
        self.table.show_rows(measured)
        self.table.setVisible(bool(measured))
        self.table.setFixedHeight(self.table.horizontalHeader().sizeHint().height() + _ROW_PX * len(measured) + 4)
        self.advice.setText("" if advice is None else advice.translated())
        self.advice.setVisible(advice is not None)


def _row_sentence(row: MeasuredValue) -> str:
    return ", ".join(column.text(row) for column in COLUMNS)
