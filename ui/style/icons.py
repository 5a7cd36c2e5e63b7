"""Icons: one SVG file each in `svg`, drawn in the theme's colours, sharp at every scale.

A file is on a grid of 24, in `currentColor`. `icon` makes a QIcon that paints itself with the theme in use, so that a
change of theme needs nobody to set it again.
"""

from enum import Enum
from functools import cache, lru_cache
from pathlib import Path
from string import Template
from typing import Final, NamedTuple

from PySide6.QtCore import QByteArray, QPoint, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QIconEngine, QImage, QPainter, QPixmap, QPixmapCache
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QAbstractButton, QAbstractItemView

from ui.style.theme import Meaning, current, scaled

FILES: Final = Path(__file__).parent / "svg"
_STROKE: Final = 'stroke-width="1.8"'
_SUNLIGHT_STROKE: Final = 'stroke-width="2.4"'


class Icon(Enum):
    """Every icon, by the name of its file."""

    LOCK = "lock"
    # A warning sign with a flash, not merely an open lock.
    ACTIVE = "active"
    PARACHUTE = "parachute"
    NOT_TRIGGERED = "not-triggered"
    BOLT = "bolt"
    PLUG = "plug"
    UNPLUGGED = "unplugged"
    LINK = "link"
    LINK_LOST = "link-lost"
    CONNECTING = "connecting"
    PAUSE = "pause"
    CAMERA = "camera"
    SAVE = "save"
    TABLE = "table"
    WARNING = "warning"
    # An octagon, as a stop sign: no warning in shape either.
    DANGER = "danger"
    INFORMATION = "information"
    UNKNOWN = "unknown"
    CHECK = "check"
    CROSS = "cross"
    MENU = "menu"
    MORE = "more"
    LIVE = "live"
    SETTINGS = "settings"
    HISTORY = "history"
    CLOCK = "clock"
    CHECKLIST = "checklist"
    DIAGNOSIS = "diagnosis"
    SIMULATOR = "simulator"
    BAY_CLOSED = "bay-closed"
    BAY_OPEN = "bay-open"
    CHEVRON_LEFT = "chevron-left"
    CHEVRON_RIGHT = "chevron-right"
    CHEVRON_UP = "chevron-up"
    CHEVRON_DOWN = "chevron-down"
    AGAIN = "again"
    COPY = "copy"
    ERASE = "erase"
    LABEL = "label"
    RECORD = "record"
    RECORD_OFF = "record-off"
    RECORDINGS = "recordings"
    FOLDER = "folder"
    FOLDER_NEW = "folder-new"
    BUNDLE = "bundle"
    TO_LIVE = "to-live"
    RESTART = "restart"
    DISCARD = "discard"
    DROP = "drop"
    FLEET = "fleet"
    MAP = "map"
    BATTERY_0 = "battery-0"
    BATTERY_1 = "battery-1"
    BATTERY_2 = "battery-2"
    BATTERY_3 = "battery-3"
    BATTERY_4 = "battery-4"
    BATTERY_UNKNOWN = "battery-unknown"


# The icon that goes with each meaning.
MEANING_ICONS: Final = {
    Meaning.GOOD: Icon.CHECK,
    Meaning.ATTENTION: Icon.WARNING,
    Meaning.DANGER: Icon.DANGER,
    Meaning.INFORMATION: Icon.INFORMATION,
    Meaning.UNKNOWN: Icon.UNKNOWN,
}


class StateStyle(NamedTuple):
    """How a state looks; without a meaning it is plain."""

    icon: Icon
    meaning: Meaning | None


def battery(level: float | None) -> Icon:
    """A battery with four bars: full at 1, empty at 0, dashed where the level is unknown."""
    name = "unknown" if level is None else min(4, max(0, round(level * 4)))
    return Icon(f"battery-{name}")


@lru_cache(maxsize=16)
def themed_svg(path: Path, **values: object) -> QSvgRenderer:
    """A drawing with these colours, sizes and words in the places of its `$names`; kept, as it is asked for at each
    paint."""
    svg = QSvgRenderer(QByteArray(Template(path.read_text(encoding="utf-8")).substitute(values).encode()))
    svg.setAspectRatioMode(Qt.AspectRatioMode.KeepAspectRatio)
    return svg


def draw(painter: QPainter, picture: Icon, rect: QRectF | QRect, colour: QColor | str) -> None:
    square = QRectF(rect)
    pixels = max(1, round(square.width() * painter.device().devicePixelRatio()))
    drawing = pixmap(picture, pixels, colour)
    painter.drawPixmap(square, drawing, QRectF(drawing.rect()))


def pixmap(picture: Icon, size: int, colour: QColor | str, *, ratio: float = 1.0) -> QPixmap:
    """An icon of `size` logical pixels for a screen of `ratio` device pixels each.

    Kept in `QPixmapCache`. A label that got a new pixmap each time would leave one more scaled copy in that cache.
    """
    name = QColor(colour).name()
    pixels = max(1, round(size * ratio))
    key = f"dps-s/{pixels}/{ratio}/{current().line_px}/{name}/{picture.value}"
    drawing = QPixmap()
    if not QPixmapCache.find(key, drawing):
        svg = _source(picture.value).replace("currentColor", name)
        drawing = _rendered(svg if current().line_px == 1 else svg.replace(_STROKE, _SUNLIGHT_STROKE), pixels)
        drawing.setDevicePixelRatio(ratio)
        QPixmapCache.insert(key, drawing)
    return drawing


@cache
def _source(name: str) -> str:
    return (FILES / f"{name}.svg").read_text(encoding="utf-8")


def _rendered(svg: str, pixels: int) -> QPixmap:
    image = QImage(pixels, pixels, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    QSvgRenderer(QByteArray(svg.encode())).render(painter)
    painter.end()
    return QPixmap.fromImage(image)


class _Engine(QIconEngine):
    """Paints one icon in the colour that the theme has for it at that moment."""

    def __init__(self, picture: Icon, meaning: Meaning | None, *, is_on_primary: bool) -> None:
        super().__init__()
        self._icon = picture
        self._meaning = meaning
        self._is_on_primary = is_on_primary

    def _colour(self, mode: QIcon.Mode) -> QColor:
        theme = current()
        if mode == QIcon.Mode.Disabled:
            return QColor(theme.disabled)
        return QColor(theme.on_primary) if self._is_on_primary else theme.ink(self._meaning)

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, _state: QIcon.State) -> None:
        side = min(rect.width(), rect.height())
        square = QRect(QPoint(0, 0), QSize(side, side))
        square.moveCenter(rect.center())
        draw(painter, self._icon, square, self._colour(mode))

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        return self.scaledPixmap(size, mode, state, 1.0)

    def scaledPixmap(self, size: QSize, mode: QIcon.Mode, _state: QIcon.State, scale: float) -> QPixmap:
        # Since Qt 6.8 the size is in logical pixels.
        return pixmap(self._icon, min(size.width(), size.height()), self._colour(mode), ratio=scale)

    def clone(self) -> QIconEngine:
        return _Engine(self._icon, self._meaning, is_on_primary=self._is_on_primary)


def icon(picture: Icon, meaning: Meaning | None = None, *, is_on_primary: bool = False) -> QIcon:
    """An icon for a button or an entry, in the colour of plain text, of a meaning, or of text on a main button."""
    return QIcon(_Engine(picture, meaning, is_on_primary=is_on_primary))


def set_icon_size(widget: QAbstractButton | QAbstractItemView, px: int) -> None:
    """Sets the size of a widget's icons at the usual size of text."""
    widget.setIconSize(QSize(scaled(px), scaled(px)))


def app_icon() -> QIcon:
    """The program's own: a white parachute on a dark rounded square, the same in every theme."""
    return QIcon(str(FILES / "dps-s-configurator.svg"))
