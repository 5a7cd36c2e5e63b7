"""Limits in the plots: a line for the value at each time, and a label at the right for the current one.

Lines across the whole plot and labels do not move from draw to draw, so they belong to the cached background.
"""

from collections.abc import Hashable, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen

from app.samples.step_function import StepFunction, StepPoint
from app.text.i18n import tr
from ui.plots.curve import LaneCurve
from ui.plots.view import Limit, Span
from ui.style.shapes import pen
from ui.style.theme import Size, Theme, font

_LEFT: Final = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT: Final = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_DRAFT_DASHES: Final = [9, 3, 2, 3]
_STALE_DASHES: Final = [1, 4]
"""Distinguishable from the module's own limits without colour."""


class LimitLine(NamedTuple):
    """A limit from `left` to `right`, with `word` on its right end."""

    left: float
    right: float
    y: float
    ink: str
    word: str
    dashes: tuple[float, ...]


class LimitLabel(NamedTuple):
    """The label of a current limit in the gutter; `y` is its middle."""

    left: float
    y: float
    text: str
    ink: str


class LimitPicture(NamedTuple):
    """The limits of one draw: those in the background, and those that move with time."""

    steady: tuple[LimitLine, ...]
    moving: tuple[LimitLine, ...]
    labels: tuple[LimitLabel, ...]

    @property
    def background_key(self) -> Hashable:
        return self.steady, self.labels


def limit_text(value: float, decimals: int) -> str:
    """A value with a typographic minus sign."""
    return f"{value:.{decimals}f}".replace("-", "−")


def gutter_px(lanes: Sequence[LaneCurve]) -> float:
    """Width of the widest label of a limit."""
    metrics = QFontMetricsF(font(Size.SMALL, is_bold=True))
    labels = [tr(limit.label, value="000") for lane in lanes for limit in lane.lane.limits]
    return max((metrics.horizontalAdvance(label) for label in labels), default=0.0) + 12


def limit_picture(lanes: Sequence[LaneCurve], span: Span, theme: Theme) -> LimitPicture:
    """Lines and labels of all limits in sight; labels of one lane never overlap."""
    steady: list[LimitLine] = []
    moving: list[LimitLine] = []
    labels: list[LimitLabel] = []
    height = QFontMetricsF(font(Size.SMALL, is_bold=True)).height()
    for lane in lanes:
        named: list[LimitLabel] = []
        for limit in lane.lane.limits:
            for line in _lines(lane, span, theme, limit, named):
                is_whole = line.left <= lane.box.left() and line.right >= lane.box.right() and not line.word
                (steady if is_whole else moving).append(line)
        places = apart([one.y for one in named], height, lane.box.top(), lane.box.bottom())
        labels += [one._replace(y=y) for one, y in zip(named, places, strict=True)]
    return LimitPicture(tuple(steady), tuple(moving), tuple(labels))


def _lines(lane: LaneCurve, span: Span, theme: Theme, limit: Limit, labels: list[LimitLabel]) -> list[LimitLine]:
    ink = theme.tint(limit.meaning).ink
    dashes = tuple(_DRAFT_DASHES) if limit.is_draft else ()
    is_stale_now = limit.stale is not None and limit.stale.value is not None
    found = _of_steps(lane, span, limit, limit.steps, ink, dashes, labels, ends_with_picture=not is_stale_now)
    if limit.stale is not None:
        stale = _of_steps(
            lane, span, limit, limit.stale, theme.muted, tuple(_STALE_DASHES), labels, ends_with_picture=False
        )
        found += [one._replace(word=tr("stale")) for one in stale]
    return found


def _of_steps(
    lane: LaneCurve,
    span: Span,
    limit: Limit,
    steps: StepFunction,
    ink: str,
    dashes: tuple[float, ...],
    labels: list[LimitLabel],
    *,
    ends_with_picture: bool,
) -> list[LimitLine]:
    """`ends_with_picture`: also label a limit that becomes unknown at the right edge, as in a recording."""
    box = lane.box
    changes = steps.between(span.start_s, span.end_s)
    at_edge = len(changes) > 1 and changes[-1].value is None and lane.x(changes[-1].time_s, span) > box.right() - 1
    if ends_with_picture and at_edge:
        changes.pop()
    lines = []
    for n, change in enumerate(changes):
        if change.value is None:
            continue
        is_last = n + 1 == len(changes)
        left = max(box.left(), lane.x(change.time_s, span))
        right = box.right() if is_last else lane.x(changes[n + 1].time_s, span)
        y = round(lane.y(change.value)) + 0.5
        text, word = limit_text(change.value, limit.decimals), ""
        if is_last:
            labels.append(LimitLabel(box.right() + 6, y, tr(limit.label, value=text), ink))
        elif change.value != _next_value(changes[n + 1 :]):  # an equal value that follows is labelled at its own end
            word = text
        lines.append(LimitLine(left, right, y, ink, word, dashes))
    return lines


def _next_value(changes: Sequence[StepPoint]) -> float | None:
    """The next known value of the limit."""
    return next((one.value for one in changes if one.value is not None), None)


def apart(places: Sequence[float], distance: float, top: float, bottom: float) -> list[float]:
    """`places` pushed apart to at least `distance`, between `top` and `bottom` if they fit."""
    order = sorted(range(len(places)), key=lambda n: places[n])
    moved = list(places)
    for _ in range(4 * len(order)):  # pushing two apart may push one onto a third
        for upper, lower in pairwise(order):
            lacking = distance - (moved[lower] - moved[upper])
            if lacking > 0:
                moved[upper] -= lacking / 2
                moved[lower] += lacking / 2
    if order:
        down = max(0.0, top - moved[order[0]])
        up = max(0.0, moved[order[-1]] + down - bottom)
        moved = [one + down - up for one in moved]
    return moved


def paint_limit_lines(painter: QPainter, lines: Sequence[LimitLine], theme: Theme) -> None:
    bold = font(Size.SMALL, is_bold=True)
    for line in lines:
        painter.setPen(_limit_pen(line, theme))
        painter.drawLine(QPointF(line.left, line.y), QPointF(line.right, line.y))
    painter.setFont(bold)
    for line, room in word_places(lines, QFontMetricsF(bold)):
        painter.setPen(QColor(line.ink))
        painter.drawText(room, _RIGHT, line.word)


def word_places(lines: Sequence[LimitLine], metrics: QFontMetricsF) -> list[tuple[LimitLine, QRectF]]:
    """The room of each word: above its line, or below where that is taken; else it is omitted."""
    found: list[tuple[LimitLine, QRectF]] = []
    for line in lines:
        width = metrics.horizontalAdvance(line.word)
        if not line.word or line.right - line.left <= width + 8:
            continue
        for top in (line.y - metrics.height() - 1, line.y + 1):
            room = QRectF(line.right - 4 - width, top, width, metrics.height())
            if not any(room.intersects(other) for _, other in found):
                found.append((line, room))
                break
    return found


def paint_limit_labels(painter: QPainter, labels: Sequence[LimitLabel]) -> None:
    bold = font(Size.SMALL, is_bold=True)
    height = QFontMetricsF(bold).height()
    painter.setFont(bold)
    for one in labels:
        painter.setPen(QColor(one.ink))
        room = QRectF(one.left, one.y - height / 2, 300, height)
        painter.drawText(room, _LEFT | Qt.TextFlag.TextDontClip, one.text)  # Chinese glyphs are taller


def _limit_pen(line: LimitLine, theme: Theme) -> QPen:
    one = pen(line.ink, theme.line_px, is_dashed=True)
    if line.dashes:
        one.setDashPattern(list(line.dashes))
    return one
