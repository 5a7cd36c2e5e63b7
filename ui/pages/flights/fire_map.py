"""Map over the thresholds: false triggers and missing triggers."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF, QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy

from app.firing.judge import TriggerLimits
from app.flight_analysis.flight_set import FireMap
from app.text.i18n import tr
from protocol.translatable import marked
from ui.style.painted_widget import PaintedWidget
from ui.style.shapes import mixed, pen
from ui.style.theme import Meaning, Size, Space, Theme, current, font

_TILTS_DEG: Final = (30, 45, 60, 75, 90, 105, 120)
_TIMES_S: Final = (0.5, 1.0, 1.5, 2.0, 2.5)
_SWATCH_PX: Final = 12
_HATCH_PX: Final = 8
_DOT_PX: Final = 6
_MIN_SHADE: Final = 0.35
_HANDLE_PX: Final = 5.0
_FAST: Final = 10
"""Degrees for Page Up and Page Down."""
_TIME_STEP_S: Final = 0.05
_EDGE_DEG: Final = 0.5
Cells = NDArray[np.float64]


class MapCells(NamedTuple):
    """By attitude threshold (rows) and free-fall time (columns)."""

    wrong: Cells
    """Share of the flights that must not fire and do."""
    missed: Cells
    """Share of the flights that must fire in time and do not."""
    differs: NDArray[np.bool_]
    """The other reading of the vendor's rule gives other numbers."""


@dataclass(frozen=True, slots=True)
class _Key:
    """One entry of the legend; `fill` draws its swatch."""

    word: str
    wrong: float = 0.0
    missed: float = 0.0
    differs: bool = False


_LEGEND: Final = (
    _Key(marked("false trigger"), wrong=0.6),
    _Key(marked("no trigger"), missed=0.6),
    _Key(marked("separates")),
    _Key(marked("unclear"), differs=True),
)


def cells_of(shown: FireMap, other: FireMap) -> MapCells:
    must_not, must = max(1, shown.must_not_count), max(1, shown.must_count)
    missed = (shown.must_count - shown.must_fired) / must
    differs = (shown.must_not_fired != other.must_not_fired) | (shown.must_fired != other.must_fired)
    return MapCells(shown.must_not_fired / must_not, missed, differs)


def map_pixels(cells: MapCells, theme: Theme, size: QSize, ratio: float, *, has_must: bool) -> NDArray[np.uint32]:
    """The image as 0xffRRGGBB: shade for false triggers, hatch for missing ones, dots where the readings differ."""
    height, width = size.height(), size.width()
    count_y, count_x = cells.wrong.shape
    rows = ((height - 1 - np.arange(height)) * count_y // height)[:, None]
    columns = (np.arange(width) * count_x // width)[None, :]
    good = theme.tint(Meaning.GOOD).wash if has_must else theme.surface
    shades = _shades(theme.danger.wash, theme.danger.fill).copy()
    shades[0] = _rgb(good)
    missed_shades = shades.copy()
    missed_shades[0] = _rgb(theme.surface)
    levels = np.ceil(np.clip(cells.wrong, 0, 1) * 255).astype(np.intp)
    colours = np.where(cells.missed > 0, missed_shades[levels], shades[levels])
    pixels = colours[rows, columns]
    period = round(_HATCH_PX * ratio)
    stroke = np.where(cells.missed >= 0.5, 3 * ratio, 1.5 * ratio) * (cells.missed > 0)
    diagonal = (np.arange(height)[:, None] + np.arange(width)[None, :]) % period
    pixels = np.where(diagonal < stroke[rows, columns], np.uint32(_rgb(theme.muted)), pixels)
    if cells.differs.any():
        step, dot = round(_DOT_PX * ratio), round(2 * ratio)
        is_dot = ((np.arange(height) % step < dot)[:, None]) & ((np.arange(width) % step < dot)[None, :])
        pixels = np.where(cells.differs[rows, columns] & is_dot, np.uint32(_rgb(theme.information.ink)), pixels)
    found: NDArray[np.uint32] = np.ascontiguousarray(pixels, np.uint32)
    return found


@lru_cache(maxsize=4)
def _shades(wash: str, fill: str) -> NDArray[np.uint32]:
    """Colours by share of false triggers (0 … 255)."""
    shares = (_MIN_SHADE + (1 - _MIN_SHADE) * number / 255 for number in range(256))
    return np.array([mixed(wash, fill, share).rgb() for share in shares], np.uint32)


def _rgb(colour: str) -> int:
    return QColor(colour).rgb()


def _image_of(pixels: NDArray[np.uint32]) -> QImage:
    height, width = pixels.shape
    return QImage(pixels.tobytes(), width, height, width * 4, QImage.Format.Format_RGB32).copy()


class FireMapView(PaintedWidget):
    """Chooses thresholds by click, drag and arrow keys."""

    chosen = Signal(float, float)
    """Attitude threshold in degrees, free-fall time in seconds."""
    opened = Signal()
    """Double click or Enter: show the flights of this cell."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    usual: ClassVar = QSize(320, 280)
    least: ClassVar = QSize(240, 200)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("flights_map")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self._map: FireMap | None = None
        self._cells: MapCells | None = None
        self._limits = TriggerLimits()
        self._image: QImage | None = None
        self._image_of: object = None

    def show_maps(self, shown: FireMap, other: FireMap) -> None:
        if shown is not self._map:
            self._map, self._cells = shown, cells_of(shown, other)
            self._image_of = None
            self.update()

    def show_limits(self, limits: TriggerLimits, told: str) -> None:
        """Moves the cross; `told` is the accessible text."""
        self._limits = limits
        self.announce(told)

    # Geometry

    def plot(self) -> QRectF:
        """Rectangle of the cells."""
        metrics = QFontMetricsF(font(Size.SMALL))
        left = metrics.horizontalAdvance("120°") + Space.S
        top = metrics.height() + Space.S
        lines = len(list(self._legend_lines(metrics)))
        bottom = (lines + 1) * (metrics.height() + Space.XS) + Space.S
        return QRectF(left, top, max(40.0, self.width() - left - Space.S), max(40.0, self.height() - top - bottom))

    def place_of(self, tilt_deg: float, time_s: float) -> QPointF:
        """Position of thresholds, limited to the map."""
        plot, (low, high), (first, last) = self.plot(), self._tilts(), self._times()
        x = plot.left() + (min(max(time_s, first), last) - first) / (last - first) * plot.width()
        y = plot.bottom() - (min(max(tilt_deg, low), high) - low) / (high - low) * plot.height()
        return QPointF(x, y)

    def thresholds_at(self, place: QPointF) -> tuple[float, float]:
        """Thresholds at a position: whole degrees, steps of 0.05 s."""
        plot, (low, high), (first, last) = self.plot(), self._tilts(), self._times()
        tilt = low + (plot.bottom() - place.y()) / plot.height() * (high - low)
        time_s = first + (place.x() - plot.left()) / plot.width() * (last - first)
        return self._bounded(round(tilt), round(time_s / _TIME_STEP_S) * _TIME_STEP_S)

    def _bounded(self, tilt_deg: float, time_s: float) -> tuple[float, float]:
        (low, high), (first, last) = self._tilts(), self._times()
        half = _TIME_STEP_S / 2
        tilt = min(max(tilt_deg, low + _EDGE_DEG), high - _EDGE_DEG)
        return tilt, round(min(max(time_s, first + half), last - half), 2)

    def _tilts(self) -> tuple[float, float]:
        """Lower and upper edge."""
        if self._map is None:
            return _TILTS_DEG[0] - _EDGE_DEG, _TILTS_DEG[-1] + _EDGE_DEG
        axis = self._map.attitude_thresholds_deg
        return float(axis[0]) - _EDGE_DEG, float(axis[-1]) + _EDGE_DEG

    def _times(self) -> tuple[float, float]:
        if self._map is None:
            return 0.175, 2.575
        axis = self._map.freefall_times_s
        half = _TIME_STEP_S / 2
        return float(axis[0]) - half, float(axis[-1]) + half

    # Painting

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = QPainter(self)
        plot = self.plot()
        painter.setFont(font(Size.SMALL))
        metrics = QFontMetricsF(painter.font())
        if self._cells is not None:
            painter.drawImage(plot, self._picture(self._cells, theme, plot))
        painter.setPen(pen(theme.border, theme.border_px))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(plot)
        self._paint_axes(painter, theme, plot, metrics)
        self._paint_cross(painter, theme, plot)
        self._paint_legend(painter, theme, plot, metrics)
        if self.hasFocus():
            painter.setPen(pen(theme.information.ink, 2))
            painter.drawRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), 6, 6)
        painter.end()

    def _picture(self, cells: MapCells, theme: Theme, plot: QRectF) -> QImage:
        ratio = self.devicePixelRatioF()
        size = QSize(round(plot.width() * ratio), round(plot.height() * ratio))
        key = (id(cells), theme.name, size.width(), size.height())
        if self._image is None or key != self._image_of:
            has_must = self._map is not None and bool(self._map.must_count)
            self._image = _image_of(map_pixels(cells, theme, size, ratio, has_must=has_must))
            self._image_of = key
        return self._image

    def _paint_axes(self, painter: QPainter, theme: Theme, plot: QRectF, metrics: QFontMetricsF) -> None:
        line = metrics.height()
        chosen = self.place_of(self._limits.attitude_threshold_deg, self._limits.freefall_time_s)
        painter.setPen(QColor(theme.muted))
        painter.drawText(QRectF(0, 0, self.width(), line), int(Qt.AlignmentFlag.AlignLeft), tr("Attitude threshold"))
        right = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        centre = int(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter)
        room = plot.left() - Space.XS
        every = 1 if plot.height() > (len(_TILTS_DEG) + 1) * line else 2
        for tilt in _TILTS_DEG[::every]:
            y = self.place_of(tilt, 0).y()
            if abs(y - chosen.y()) > line:
                painter.drawText(QRectF(0, y - line / 2, room, line), right, f"{tilt}°")
        foot = plot.bottom() + 2
        title = tr("Free-fall time")
        width = metrics.horizontalAdvance(title) + 1
        for time_s in _TIMES_S:
            x = self.place_of(0, time_s).x()
            if abs(x - chosen.x()) > 44 and x < plot.right() - width - 24:
                painter.drawText(QRectF(x - 24, foot, 48, line), centre, f"{time_s:g} s")
        if chosen.x() < plot.right() - width - 30:
            painter.drawText(QRectF(plot.right() - width, foot, width, line), right, title)
        painter.setFont(font(Size.SMALL, is_bold=True))
        painter.setPen(QColor(theme.text))
        tilt_text = f"{self._limits.attitude_threshold_deg:.0f}°"
        painter.drawText(QRectF(0, chosen.y() - line / 2, room, line), right, tilt_text)
        left = min(max(chosen.x() - 28, 0.0), self.width() - 56.0)
        painter.drawText(QRectF(left, foot, 56, line), centre, f"{self._limits.freefall_time_s:.2f} s")
        painter.setFont(font(Size.SMALL))

    def _paint_cross(self, painter: QPainter, theme: Theme, plot: QRectF) -> None:
        """Outlined, so that it contrasts with every cell."""
        place = self.place_of(self._limits.attitude_threshold_deg, self._limits.freefall_time_s)
        for colour, width in ((theme.surface, theme.line_px + 3.0), (theme.text, theme.line_px + 0.5)):
            painter.setPen(pen(colour, width))
            painter.drawLine(QPointF(plot.left(), place.y()), QPointF(plot.right(), place.y()))
            painter.drawLine(QPointF(place.x(), plot.top()), QPointF(place.x(), plot.bottom()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(QColor(theme.text))
        painter.setPen(pen(theme.surface, 2.0))
        painter.drawEllipse(place, _HANDLE_PX, _HANDLE_PX)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, on=False)
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _keys(self) -> tuple[_Key, ...]:
        """Entries that apply to this map."""
        has_must = self._map is not None and bool(self._map.must_count)
        differs = self._cells is not None and bool(self._cells.differs.any())
        return tuple(
            one for one in _LEGEND
            if (has_must or one.wrong) and (differs or not one.differs)
        )  # fmt: skip

    def _legend_lines(self, metrics: QFontMetricsF) -> Iterator[list[tuple[_Key, float, float]]]:
        """Lines of entries with left edge and text width, wrapped to the widget's width."""
        line: list[tuple[_Key, float, float]] = []
        x = 0.0
        for key in self._keys():
            word = metrics.horizontalAdvance(tr(key.word)) + 1
            width = _SWATCH_PX + Space.XS + word
            if line and x + width > self.width():
                yield line
                line, x = [], 0.0
            line.append((key, x, word))
            x += width + Space.S
        yield line

    def _paint_legend(self, painter: QPainter, theme: Theme, plot: QRectF, metrics: QFontMetricsF) -> None:
        height = metrics.height()
        top = plot.bottom() + height + Space.S
        for line in self._legend_lines(metrics):
            for key, x, word in line:
                swatch = QRectF(x, top + (height - _SWATCH_PX) / 2, _SWATCH_PX, _SWATCH_PX)
                painter.drawImage(swatch, self._swatch(key, theme))
                painter.setPen(pen(theme.border, 1))
                painter.drawRect(swatch)
                painter.setPen(QColor(theme.muted))
                place = QRectF(x + _SWATCH_PX + Space.XS, top, word, height)
                painter.drawText(place, int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter), tr(key.word))
            top += height + Space.XS

    def _swatch(self, key: _Key, theme: Theme) -> QImage:
        ratio = self.devicePixelRatioF()
        one = np.ones((1, 1))
        cells = MapCells(one * key.wrong, one * key.missed, one * key.differs > 0)
        side = round(_SWATCH_PX * ratio)
        return _image_of(map_pixels(cells, theme, QSize(side, side), ratio, has_must=not key.differs))

    # Mouse and keyboard

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            self.chosen.emit(*self.thresholds_at(event.position()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self.chosen.emit(*self.thresholds_at(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {
            Qt.Key.Key_Up: (1, 0), Qt.Key.Key_Down: (-1, 0), Qt.Key.Key_Right: (0, 1), Qt.Key.Key_Left: (0, -1),
            Qt.Key.Key_PageUp: (_FAST, 0), Qt.Key.Key_PageDown: (-_FAST, 0),
        }.get(Qt.Key(event.key()))  # fmt: skip
        if steps is not None:
            tilt = self._limits.attitude_threshold_deg + steps[0]
            self.chosen.emit(*self._bounded(tilt, self._limits.freefall_time_s + steps[1] * _TIME_STEP_S))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.opened.emit()
        else:
            super().keyPressEvent(event)
