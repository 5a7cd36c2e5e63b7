"""Widgets of the Tests page: picture, list of steps, live value."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QAccessibleEvent, QColor, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.guided.results import GuidedKind
from app.text.i18n import tr
from ui.style.icons import Icon, themed_svg
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, Space, current, font, scaled
from ui.widgets.controls import named, set_role
from ui.widgets.labels import IconLabel, text_label

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
    """Picture of the current step."""

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


class Instruction(QLabel):
    """What to do now; screen readers announce a new instruction."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_instruction", "title")
        self.setWordWrap(True)
        self.setTextFormat(Qt.TextFormat.PlainText)

    def set_text(self, text: str) -> None:
        if text != self.text():
            self.setText(text)
            self.setAccessibleName(text)
            QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.NameChanged))


@dataclass(frozen=True, slots=True)
class LiveMark:
    """A limit on the bar."""

    value: float
    text: str
    meaning: Meaning


@dataclass(frozen=True, slots=True)
class LiveReading:
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
        for mark in sorted(reading.marks, key=lambda one: one.value):
            x = bar.left() + bar.width() * min(1.0, max(0.0, mark.value / reading.highest))
            ink = theme.tint(mark.meaning).ink
            painter.setPen(pen(ink, theme.line_px + 1))
            painter.drawLine(QPointF(x, bar.top() - 4), QPointF(x, bar.bottom() + 4))
            wide = metrics.horizontalAdvance(mark.text)
            left = min(max(taken + Space.S, x - wide / 2), bar.right() - wide)
            painter.setPen(QColor(ink))
            painter.drawText(QRectF(left, bar.bottom() + 4, wide + 2, 18), Qt.AlignmentFlag.AlignVCenter, mark.text)
            taken = left + wide
