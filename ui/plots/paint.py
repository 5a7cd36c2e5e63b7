"""Paints everything around the curves: grid, scales, limits, markers, cursor.

Painted here since it costs a tenth of what the axes of a general plotting library cost when they scroll.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter

from app.text.i18n import tr
from ui.plots.axis import Tick, ago_text, clock_text
from ui.plots.curve import LaneCurve
from ui.plots.limits import LimitPicture, limit_text, paint_limit_labels, paint_limit_lines, word_places
from ui.plots.view import Mark, Span
from ui.style import icons
from ui.style.shapes import cleared_word, mixed, pen
from ui.style.theme import Size, Space, Theme, font

_LEFT: Final = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT: Final = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_CENTRE: Final = Qt.AlignmentFlag.AlignCenter
_MARK_PX: Final = 14
_UNIT_GAP_PX: Final = 6


@dataclass(frozen=True, slots=True)
class Picture:
    """Everything that one draw shows."""

    theme: Theme
    lanes: Sequence[LaneCurve]
    span: Span
    now_s: float
    ticks: Sequence[Tick]
    marks: Sequence[Mark]
    cursor_s: float | None
    is_live: bool
    wall_offset_s: float
    marks_row: QRectF
    axis: QRectF
    has_focus: bool
    limits: LimitPicture

    def x(self, time_s: float) -> float:
        """The x coordinate of a time."""
        return self.lanes[0].x(time_s, self.span)


def paint_back(painter: QPainter, picture: Picture) -> None:
    """Paints titles, grid, scales, the time line, and the limits that do not move."""
    theme = picture.theme
    small = font(Size.SMALL)
    metrics = QFontMetricsF(small)
    grid = QColor(theme.divider)
    if theme.line_px > 1:
        grid = QColor("#9A9A9A")  # black hairlines would hide the curve
    for lane in picture.lanes:
        box, scale = lane.box, lane.scale
        painter.setPen(pen(grid, 1))
        for tick in picture.ticks:
            x = round(picture.x(tick.time_s)) + 0.5
            if box.left() <= x <= box.right() + 1:
                painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        painter.setFont(small)
        steps = round((scale.high - scale.low) / scale.step)
        for step in range(steps + 1):
            value = scale.low + step * scale.step
            y = round(lane.y(value)) + 0.5
            painter.setPen(pen(theme.border if step == 0 else grid, 1))
            painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
            is_last = step in (0, steps) if box.height() >= metrics.height() else step == steps
            if not is_last and box.height() / steps < metrics.height():
                continue  # no room for the label
            painter.setPen(QColor(theme.muted))
            room = QRectF(0, y - metrics.height() / 2, box.left() - 6, metrics.height())
            painter.drawText(room, _RIGHT, limit_text(value, 0 if float(scale.step).is_integer() else 1))
        if lane is not picture.lanes[0]:  # whose title is in the row of the marks
            _title(painter, theme, lane, lane.box.left())
    paint_limit_lines(painter, picture.limits.steady, theme)
    paint_limit_labels(painter, picture.limits.labels)
    painter.setFont(small)
    painter.setPen(QColor(theme.muted))
    for room, label in _tick_labels(picture, metrics):
        painter.drawText(room, _CENTRE, label)


def _tick_labels(picture: Picture, metrics: QFontMetricsF) -> Iterator[tuple[QRectF, str]]:
    """The labels below the plots and their rectangles, none below the scale's, none touching another."""
    free_from = picture.axis.left()
    for tick in sorted(picture.ticks, key=lambda tick: tick.time_s):
        width = metrics.horizontalAdvance(tick.label) + 4
        x, edge = picture.x(tick.time_s), picture.axis.left()
        left = edge if abs(x - edge) < 1 else x - width / 2
        if left >= free_from and left + width <= picture.axis.right() + width:
            free_from = left + width + Space.XS
            yield QRectF(left, picture.axis.top() + 3, width, metrics.height()), tick.label


def _title(painter: QPainter, theme: Theme, lane: LaneCurve, left: float) -> None:
    bold = font(Size.SMALL, is_bold=True)
    metrics = QFontMetricsF(bold)
    top = lane.box.top() - metrics.height() - 3
    title = tr(lane.lane.title)
    painter.setFont(bold)
    painter.setPen(QColor(theme.curves[lane.number % len(theme.curves)]))
    painter.drawText(QPointF(left, top + metrics.ascent()), title)
    painter.setFont(font(Size.SMALL))
    painter.setPen(QColor(theme.muted))
    unit = QPointF(left + metrics.horizontalAdvance(title) + _UNIT_GAP_PX, top + metrics.ascent())
    painter.drawText(unit, lane.lane.unit)


def _title_px(lane: LaneCurve) -> float:
    title = QFontMetricsF(font(Size.SMALL, is_bold=True)).horizontalAdvance(tr(lane.lane.title))
    return title + _UNIT_GAP_PX + QFontMetricsF(font(Size.SMALL)).horizontalAdvance(lane.lane.unit)


def paint_front(painter: QPainter, picture: Picture) -> None:
    """Paints gaps, limits that begin or end in sight, marks and the cursor."""
    words = [room for _, room in word_places(picture.limits.moving, QFontMetricsF(font(Size.SMALL, is_bold=True)))]
    for lane in picture.lanes:
        _paint_gaps(painter, picture, lane, words)
    paint_limit_lines(painter, picture.limits.moving, picture.theme)
    _paint_marks(painter, picture)
    if picture.cursor_s is not None:
        _paint_cursor(painter, picture, picture.cursor_s)
    if picture.has_focus:
        painter.setPen(pen(picture.theme.information.ink, 2))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        whole = picture.lanes[0].box.united(picture.lanes[-1].box)
        painter.drawRoundedRect(whole.adjusted(-2, -2, 2, 2), 3, 3)


def _paint_gaps(painter: QPainter, picture: Picture, lane: LaneCurve, taken: Sequence[QRectF]) -> None:
    """Writes "no data" where samples are missing, if there is room; `taken` are the words of limits."""
    if not lane.gaps:
        return
    small = font(Size.SMALL)
    word = tr("no data")
    width, height = QFontMetricsF(small).horizontalAdvance(word) + 12, QFontMetricsF(small).height() + 2
    for gap in lane.gaps:
        left = max(lane.box.left(), lane.x(gap.start_s, picture.span))
        right = min(lane.box.right(), lane.x(gap.end_s, picture.span))
        for part in (0.5, 0.25, 0.75):
            ground = QRectF(0, 0, width, height)
            ground.moveCenter(QPointF((left + right) / 2, lane.box.top() + part * lane.box.height()))
            if right - left > width and not any(ground.intersects(one) for one in taken):
                cleared_word(painter, picture.theme, ground, word, small)
                break


def _paint_marks(painter: QPainter, picture: Picture) -> None:
    """Paints all lines, then icons, words and the title; the most important and newest come first, none overlap."""
    theme, strip = picture.theme, picture.marks_row
    bold = font(Size.SMALL, is_bold=True)
    metrics = QFontMetricsF(bold)
    painter.setFont(bold)
    marks = [mark for mark in picture.marks if strip.left() <= picture.x(mark.time_s) <= strip.right()]
    marks.sort(key=lambda one: (one.rank, -one.time_s))
    for mark in reversed(marks):
        x = round(picture.x(mark.time_s)) + 0.5
        painter.setPen(pen(_faint(theme.ink(mark.meaning), theme), 1))
        for lane in picture.lanes:
            painter.drawLine(QPointF(x, lane.box.top()), QPointF(x, lane.box.bottom()))
    shown = placed_marks([picture.x(mark.time_s) for mark in marks])
    taken = [(x - _MARK_PX / 2, x + _MARK_PX / 2) for _, x in shown]
    top = strip.top() + (strip.height() - _MARK_PX) / 2
    for number, x in shown:
        mark = marks[number]
        icons.draw(painter, mark.icon, QRectF(x - _MARK_PX / 2, top, _MARK_PX, _MARK_PX), theme.ink(mark.meaning))
    for number, x in shown:
        word, left = tr(marks[number].word), x + _MARK_PX / 2 + 3
        right = left + metrics.horizontalAdvance(word)
        if right < strip.right() + 80 and not any(a < right + 4 and left - 2 < b for a, b in taken):
            taken.append((left, right))
            painter.setPen(theme.ink(marks[number].meaning))
            painter.drawText(QPointF(left, strip.center().y() + metrics.ascent() / 2 - 1), word)
    lane, title_left = picture.lanes[0], strip.left()
    for left, right in sorted(taken):  # the title of the first plot is beside the marks
        if left < title_left + _title_px(lane) + _UNIT_GAP_PX:
            title_left = max(title_left, right + _UNIT_GAP_PX)
    _title(painter, theme, lane, title_left)


def placed_marks(places: Sequence[float]) -> list[tuple[int, float]]:
    """Index and position of the marks that get an icon; one that would overlap an earlier one is left out."""
    shown: list[tuple[int, float]] = []
    for number, x in enumerate(places):
        if all(abs(x - other) >= _MARK_PX + 4 for _, other in shown):
            shown.append((number, x))
    return shown


def _faint(ink: QColor, theme: Theme) -> QColor:
    """Fainter than cursor and curves; mixed here since transparent pens are slow."""
    if theme.line_px > 1:
        return ink
    return mixed(ink, theme.surface, 0.4)


def _paint_cursor(painter: QPainter, picture: Picture, cursor_s: float) -> None:
    theme = picture.theme
    x = round(picture.x(cursor_s)) + 0.5
    painter.setPen(pen(theme.text, 1))
    painter.drawLine(QPointF(x, picture.lanes[0].box.top()), QPointF(x, picture.axis.top() + 2))
    for lane in picture.lanes:
        text, y = reading(lane, cursor_s, picture.span), None
        found = lane.lane.series.around(cursor_s, within_s=lane.lane.gap_s)
        if found is not None:
            y = lane.y(found.high)
            painter.setPen(pen(theme.surface, 1.5))
            painter.setBrush(QColor(theme.curves[lane.number % len(theme.curves)]))
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.drawEllipse(QPointF(x, y), 4, 4)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        place = lane.box.top() + 12 if y is None else y - 14
        _pill(painter, theme, QPointF(x, place), text, lane.box)
    metrics_px = QFontMetricsF(font(Size.SMALL, is_bold=True)).height()
    below = QRectF(picture.axis.left(), picture.axis.top(), picture.axis.width(), metrics_px + 6)
    text, middle = cursor_time(picture, cursor_s), QPointF(x, below.center().y())
    box = _pill_box(middle, text, below)
    for room, _ in _tick_labels(picture, QFontMetricsF(font(Size.SMALL))):
        if room.intersects(box):  # a partly covered label would show another time
            painter.fillRect(room, QColor(theme.surface))
    _pill(painter, theme, middle, text, below)


def reading(lane: LaneCurve, at_s: float, span: Span) -> str:
    """The value at a time with its unit, a range where only that was kept, or "no data"."""
    found = lane.lane.series.around(at_s, within_s=min(lane.lane.gap_s, max(0.002, span.length_s / 50)))
    if found is None:
        return tr("no data")
    low, high = limit_text(found.low, lane.lane.decimals), limit_text(found.high, lane.lane.decimals)
    gap = "" if lane.lane.unit == "°" else " "
    text = f"{low}{gap}{lane.lane.unit}" if low == high else f"{low} … {high}{gap}{lane.lane.unit}"
    judge = lane.lane.outside
    outside = None if judge is None else judge(found.low, at_s) or judge(found.high, at_s)
    return text if outside is None else outside.beside(text)


def cursor_time(picture: Picture, cursor_s: float) -> str:
    """The age and the time of day at the cursor, and the events there."""
    decimals = 1 if picture.span.length_s > 3 else 3
    text = clock_text(cursor_s + picture.wall_offset_s, decimals)
    if picture.is_live:
        text = f"{ago_text(max(0.0, picture.now_s - cursor_s), decimals)} · {text}"
    for mark in picture.marks:
        if abs(picture.x(mark.time_s) - picture.x(cursor_s)) < 6:
            text += f" · {tr(mark.word)}"
    return text


def _pill(painter: QPainter, theme: Theme, middle: QPointF, text: str, within: QRectF) -> None:
    """A text on a filled box, within the lane."""
    bold = font(Size.SMALL, is_bold=True)
    box = _pill_box(middle, text, within)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(theme.text))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.drawRoundedRect(box, 4, 4)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
    painter.setFont(bold)
    painter.setPen(QColor(theme.window))
    painter.drawText(box, _CENTRE, text)


def _pill_box(middle: QPointF, text: str, within: QRectF) -> QRectF:
    metrics = QFontMetricsF(font(Size.SMALL, is_bold=True))
    box = QRectF(0, 0, metrics.horizontalAdvance(text) + 12, metrics.height() + 4)
    left = middle.x() + 8
    if left + box.width() > within.right():
        left = max(0.0, middle.x() - 8 - box.width())
    top = min(max(middle.y() - box.height() / 2, within.top()), max(within.top(), within.bottom() - box.height()))
    box.moveTopLeft(QPointF(left, top))
    return box
