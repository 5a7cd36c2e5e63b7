"""Charts of link statistics: round trips, invalid bytes by reason, and both over time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy

from app.diagnosis.link_statistics import Slice, TripClass
from app.text.durations import duration
from app.text.i18n import tr
from protocol.frame import Reason
from protocol.translatable import marked
from ui.style.painted_widget import PaintedWidget
from ui.style.shapes import pen
from ui.style.theme import Meaning, Size, Space, current, font

REASON_WORDS: Final = {
    Reason.NO_HEADER: marked("no header"),
    Reason.UNKNOWN_CODE: marked("unknown code"),
    Reason.CONTROL: marked("wrong control byte"),
    Reason.CHECKSUM: marked("wrong checksum"),
    Reason.VALUE: marked("impossible value"),
    Reason.INCOMPLETE: marked("broken off"),
}
_CENTRE = Qt.AlignmentFlag.AlignCenter
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_LINE_PX: Final = 18
_TICK_MS: Final = frozenset((1, 4, 16, 64, 250, 1000))
"""Bounds labelled below the histogram; there is no room for all."""


def percent_text(share: float) -> str:
    """ "0 %", "0.03 %", "12 %"."""
    percent = share * 100
    return f"{percent:.0f} %" if percent >= 10 or not percent else f"{percent:.2g} %"


class _Chart(PaintedWidget):
    """A chart that takes all the room that it gets."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    usual: ClassVar = QSize(320, 130)
    least: ClassVar = QSize(220, 90)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)


class Histogram(_Chart):
    """Histogram of round trips, with shares."""

    def __init__(self) -> None:
        super().__init__("figures_trips")
        self._classes: tuple[TripClass, ...] = ()

    def show_classes(self, classes: tuple[TripClass, ...]) -> None:
        if classes == self._classes:
            return
        self._classes = classes
        total = sum(one.count for one in classes)
        said = "; ".join(f"{_bound(one)}: {one.count}" for one in classes if one.count)
        self.announce(tr("Round trips: {n}. {classes}", n=total, classes=said), name=tr("Round trips"))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = QPainter(self)
        painter.setFont(font(Size.SMALL))
        ground = QRectF(0, _LINE_PX, self.width(), self.height() - 2 * _LINE_PX)
        painter.setPen(pen(theme.divider, theme.border_px))
        painter.drawLine(ground.bottomLeft(), ground.bottomRight())
        total, most = sum(one.count for one in self._classes), max((one.count for one in self._classes), default=0)
        painter.setPen(QColor(theme.muted))
        if not total:
            painter.drawText(ground, _CENTRE, tr("not measured yet"))
            painter.end()
            return
        step = ground.width() / len(self._classes)
        self._paint_bars(painter, ground, step, most, total)
        painter.end()

    def _paint_bars(self, painter: QPainter, ground: QRectF, step: float, most: int, total: int) -> None:
        """Each bar with its share above it, where that fits beside the previous one and between higher bars."""
        theme, metrics = current(), painter.fontMetrics()
        said = QRectF()
        heights = [max(2.0, ground.height() * one.count / most) if one.count else 0.0 for one in self._classes]
        bars = [
            QRectF(ground.left() + number * step + 1, ground.bottom() - height, step - 2, height)
            for number, height in enumerate(heights)
        ]
        for number, (one, bar) in enumerate(zip(self._classes, bars, strict=True)):
            left = ground.left() + number * step
            if one.count:
                painter.fillRect(bar, QColor(theme.curves[0]))
                text = percent_text(one.count / total)
                wide = metrics.horizontalAdvance(text) + 4
                share = QRectF(bar.center().x() - wide / 2, bar.top() - _LINE_PX, wide, _LINE_PX)
                is_free = not any(share.intersects(other) for other in (said, *bars))
                if one.count * 20 >= total and is_free:
                    said = share
                    painter.setPen(QColor(theme.text))
                    painter.drawText(share, _CENTRE, text)
            if one.up_to_ms in _TICK_MS:
                painter.setPen(QColor(theme.muted))
                place = QRectF(left + step - 24, ground.bottom() + 1, 48, _LINE_PX)
                painter.drawLine(QPointF(left + step, ground.bottom()), QPointF(left + step, ground.bottom() + 3))
                painter.drawText(place, _CENTRE, f"{one.up_to_ms:g}")


def _bound(one: TripClass) -> str:
    return tr("longer") if one.up_to_ms is None else tr("up to {ms} ms", ms=f"{one.up_to_ms:g}")


class ReasonBars(_Chart):
    """Invalid bytes by reason, most frequent first."""

    def __init__(self) -> None:
        super().__init__("figures_reasons")
        self._counts: tuple[tuple[Reason, int], ...] = ()

    def show_counts(self, counts: Sequence[tuple[Reason, int]]) -> None:
        shown = tuple((reason, count) for reason, count in counts if count)
        if shown != self._counts or not self.accessibleName():
            self._counts = shown
            said = "; ".join(f"{tr(REASON_WORDS[reason])}: {count}" for reason, count in shown) or tr("none")
            self.announce(tr("{setting}: {what}", setting=tr("Invalid bytes"), what=said), name=tr("Invalid bytes"))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = QPainter(self)
        one = font(Size.SMALL)
        painter.setFont(one)
        metrics = QFontMetricsF(one)
        if not self._counts:
            painter.setPen(QColor(theme.muted))
            painter.drawText(QRectF(self.rect()), _CENTRE, tr("none"))
            painter.end()
            return
        words = metrics.horizontalAdvance(max((tr(word) for word in REASON_WORDS.values()), key=len)) + Space.S
        numbers = metrics.horizontalAdvance(f"{self._counts[0][1]:,}") + Space.S
        room = max(10.0, self.width() - words - numbers)
        line = min(24.0, self.height() / len(self._counts))
        for row, (reason, count) in enumerate(self._counts):
            top = row * line
            painter.setPen(QColor(theme.text))
            painter.drawText(QRectF(0, top, words, line), _LEFT, tr(REASON_WORDS[reason]))
            width = max(2.0, room * count / self._counts[0][1])
            painter.fillRect(QRectF(words, top + line * 0.25, width, line * 0.5), theme.ink(Meaning.ATTENTION))
            painter.drawText(QRectF(words + width + Space.XS, top, numbers, line), _LEFT, f"{count:,}")
        painter.end()


@dataclass(frozen=True, slots=True)
class Stretch:
    """The time line from `now_s - length_s` to `now_s`."""

    now_s: float
    length_s: float
    slices: tuple[Slice, ...]


@dataclass(frozen=True, slots=True)
class _Lane:
    title: str
    meaning: Meaning | None
    values: tuple[float | None, ...]
    text: str
    """Shown for the highest value."""


class OverTime(_Chart):
    """Slowest answer, queries without reply and invalid bytes over time, with marks for restarts of the module and lost
    ports."""

    usual: ClassVar = QSize(640, 200)
    least: ClassVar = QSize(260, 150)

    def __init__(self) -> None:
        super().__init__("figures_over_time")
        self._stretch = Stretch(0.0, 600.0, ())

    def show_stretch(self, stretch: Stretch) -> None:
        self._stretch = stretch
        restarts, losses = sum(one.restarts for one in stretch.slices), sum(one.losses for one in stretch.slices)
        name = tr(
            "Over the last {time}: {lanes}; restarts: {restarts}; port lost: {losses}",
            time=duration(stretch.length_s),
            lanes="; ".join(f"{lane.title} {lane.text}" for lane in self._lanes()),
            restarts=restarts,
            losses=losses,
        )
        self.announce(name)

    def _lanes(self) -> tuple[_Lane, ...]:
        slices = self._stretch.slices
        slowest = [one.slowest_s for one in slices if one.slowest_s is not None]
        missed, rejected = sum(one.time_outs for one in slices), sum(one.rejected_bytes for one in slices)
        worst = f"{max(slowest) * 1000:.1f} ms" if slowest else "–"
        return (
            _Lane(tr("Slowest answer"), None, tuple(one.slowest_s for one in slices), worst),
            _Lane(tr("Without reply"), Meaning.ATTENTION, tuple(one.time_outs for one in slices), f"{missed:,}"),
            _Lane(tr("Invalid bytes"), Meaning.ATTENTION, tuple(one.rejected_bytes for one in slices), f"{rejected:,}"),
        )

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, stretch = current(), self._stretch
        painter = QPainter(self)
        small = font(Size.SMALL)
        painter.setFont(small)
        lanes = self._lanes()
        titles = max(QFontMetricsF(small).horizontalAdvance(lane.title) for lane in lanes) + Space.M
        ground = QRectF(titles, 0, self.width() - titles, self.height() - _LINE_PX)
        height = ground.height() / len(lanes)
        for number, lane in enumerate(lanes):
            box = QRectF(ground.left(), ground.top() + number * height + 4, ground.width(), height - 8)
            painter.setPen(pen(theme.divider, theme.border_px))
            painter.drawLine(box.bottomLeft(), box.bottomRight())
            painter.setPen(QColor(theme.text))
            painter.drawText(QRectF(0, box.top(), titles, 16), _LEFT, lane.title)
            painter.setPen(QColor(theme.muted))
            painter.drawText(QRectF(0, box.top() + 16, titles, 16), _LEFT, lane.text)
            self._paint_lane(painter, lane, box)
        self._paint_marks(painter, ground)
        painter.setPen(QColor(theme.muted))
        foot = QRectF(ground.left(), self.height() - _LINE_PX, ground.width(), _LINE_PX)
        painter.drawText(foot, _LEFT, tr("{time} ago", time=duration(stretch.length_s)))
        painter.drawText(foot, _RIGHT, tr("now"))
        painter.end()

    def _x(self, at_s: float, box: QRectF) -> float:
        began_s = self._stretch.now_s - self._stretch.length_s
        return box.left() + box.width() * (at_s - began_s) / self._stretch.length_s

    def _paint_lane(self, painter: QPainter, lane: _Lane, box: QRectF) -> None:
        theme = current()
        top = max((value for value in lane.values if value), default=0.0)
        if not top:
            return
        colour = QColor(theme.curves[0]) if lane.meaning is None else theme.ink(lane.meaning)
        for one, value in zip(self._stretch.slices, lane.values, strict=True):
            if value:
                left, right = self._x(one.begins_s, box), self._x(one.begins_s + one.lasts_s, box)
                if right <= box.left():
                    continue
                tall = max(2.0, box.height() * value / top)
                left = max(left, box.left())
                bar = QRectF(left, box.bottom() - tall, max(1.5, right - left), tall)
                painter.fillRect(bar.intersected(box), colour)

    def _paint_marks(self, painter: QPainter, ground: QRectF) -> None:
        theme = current()
        for one in self._stretch.slices:
            x = self._x(one.begins_s + one.lasts_s / 2, ground)
            if x < ground.left() or not (one.restarts or one.losses):
                continue
            ink = theme.ink(Meaning.DANGER if one.losses else Meaning.INFORMATION)
            painter.setPen(QPen(ink, theme.line_px, Qt.PenStyle.DashLine))
            painter.drawLine(QPointF(x, ground.top()), QPointF(x, ground.bottom()))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(ink)
            tip = ground.top() + 7
            if one.losses:  # a square for a lost port
                painter.drawRect(QRectF(x - 3.5, ground.top(), 7, 7))
            else:  # a triangle for a restart
                points = [QPointF(x - 4.5, ground.top()), QPointF(x + 4.5, ground.top()), QPointF(x, tip)]
                painter.drawPolygon(QPolygonF(points))
            painter.setBrush(Qt.BrushStyle.NoBrush)
