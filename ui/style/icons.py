"""Icons drawn from outlines on a grid of 24, in the theme's colours, sharp at every scale.

An icon is one SVG fragment whose strokes and fills are ``currentColor``.  ``icon`` gives a QIcon that paints
itself with the theme in use, so that a change of theme needs nobody to set it again.
"""

from enum import Enum
from typing import Final, NamedTuple

from PySide6.QtCore import QByteArray, QPoint, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QIconEngine, QImage, QPainter, QPixmap, QPixmapCache
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QAbstractButton, QAbstractItemView, QWidget

from ui.style.theme import Meaning, current, scaled

_FULL: Final = 'fill="currentColor" stroke="none"'
_SIZE: Final = "icon_size"
"""Property of a button or list: the size of its icons at the usual size of text."""


class Icon(Enum):
    """Every icon, by its outline."""

    LOCK = '<rect x="5" y="11" width="14" height="9.5" rx="2"/><path d="M8 11V7.5a4 4 0 0 1 8 0V11M12 15v2"/>'
    # Standing ready to fire: a warning sign with a flash, not merely an open lock.
    ACTIVE = f'<path d="M12 3 22 20.5H2Z"/><path {_FULL} d="M12.9 8.5 8.6 14.6h2.8l-.6 4.2 4.4-6.3h-2.9z"/>'
    PARACHUTE = (
        '<path d="M2.5 11.5a9.5 8.5 0 0 1 19 0c-1.6-1.4-3.2-1.4-4.75 0-1.6-1.4-3.15-1.4-4.75 0'
        '-1.6-1.4-3.15-1.4-4.75 0-1.55-1.4-3.15-1.4-4.75 0Z"/>'
        '<path d="M2.5 11.5 12 20.5l9.5-9M7.25 11.5 12 20.5l4.75-9"/>'
        f'<circle {_FULL} cx="12" cy="20.5" r="1.9"/>'
    )
    # The pack, closed.
    NOT_TRIGGERED = '<circle cx="12" cy="12" r="8.5"/><path d="M8.2 12.3 11 15l5-5.6"/>'
    BOLT = f'<path {_FULL} d="M13.5 2 5 13.5h5.5L9.5 22 19 10h-6z"/>'
    PLUG = '<path d="M9 2.5V8M15 2.5V8M6 8h12v3.5a6 6 0 0 1-12 0ZM12 17.5v4"/>'
    UNPLUGGED = (
        '<path d="M9 2.5V6M15 2.5V8M10.5 8H18v3.5q0 1.7-.8 3M14.6 17a6 6 0 0 1-8.6-5.5V9.5M12 17.5v4M3 3l18 18"/>'
    )
    LINK = f'<circle {_FULL} cx="12" cy="12" r="5"/><circle cx="12" cy="12" r="8.8"/>'
    LINK_LOST = '<circle cx="12" cy="12" r="8.8"/><path d="m8.5 8.5 7 7M15.5 8.5l-7 7"/>'
    CONNECTING = (
        '<path d="M12 3.2a8.8 8.8 0 0 1 8.8 8.8M12 20.8A8.8 8.8 0 0 1 3.2 12" />'
        f'<circle {_FULL} cx="12" cy="12" r="2.6"/>'
    )
    PAUSE = (
        f'<rect {_FULL} x="6" y="4.5" width="4.2" height="15" rx="1.2"/>'
        f'<rect {_FULL} x="13.8" y="4.5" width="4.2" height="15" rx="1.2"/>'
    )
    PLAY = f'<path {_FULL} d="M7 4.8v14.4a.9.9 0 0 0 1.4.75l11-7.2a.9.9 0 0 0 0-1.5l-11-7.2A.9.9 0 0 0 7 4.8Z"/>'
    CAMERA = (
        '<path d="M4.5 7.5h3L9.2 5h5.6l1.7 2.5h3a1.5 1.5 0 0 1 1.5 1.5v9a1.5 1.5 0 0 1-1.5 1.5h-15'
        'A1.5 1.5 0 0 1 3 18V9a1.5 1.5 0 0 1 1.5-1.5Z"/><circle cx="12" cy="13.2" r="3.4"/>'
    )
    SAVE = (
        '<path d="M12 3.5V15M7.5 10.8 12 15.3l4.5-4.5M4 16.5v2.5a1.5 1.5 0 0 0 1.5 1.5h13A1.5 1.5 0 0 0 20 19v-2.5"/>'
    )
    TABLE = '<rect x="3.5" y="4.5" width="17" height="15" rx="1.5"/><path d="M3.5 9.5h17M3.5 14.5h17M9.5 4.5v15"/>'
    WARNING = f'<path d="M12 3.5 21.8 20.5H2.2Z"/><path d="M12 9.8v4.6"/><circle {_FULL} cx="12" cy="17.4" r="1.2"/>'
    DANGER = (
        '<path d="M8.2 2.8h7.6l5.4 5.4v7.6l-5.4 5.4H8.2l-5.4-5.4V8.2Z"/><path d="M12 7.2v5.8"/>'
        f'<circle {_FULL} cx="12" cy="16.4" r="1.2"/>'
    )
    """An octagon, as a stop sign has: in shape too it is no warning."""
    INFORMATION = f'<circle cx="12" cy="12" r="8.8"/><path d="M12 11.2v5.2"/><circle {_FULL} cx="12" cy="7.8" r="1.2"/>'
    UNKNOWN = (
        '<circle cx="12" cy="12" r="8.8" stroke-dasharray="3.1 2.43"/>'
        f'<path d="M9.3 9.6a2.8 2.8 0 1 1 4.2 2.4c-1 .6-1.5 1-1.5 2.1"/><circle {_FULL} cx="12" cy="17" r="1.2"/>'
    )
    CHECK = '<path d="m4.5 12.8 5 5 10-11.3"/>'
    CROSS = '<path d="m6 6 12 12M18 6 6 18"/>'
    MENU = '<path d="M4 6.5h16M4 12h16M4 17.5h16"/>'
    MORE = (
        f'<g {_FULL}><circle cx="5.5" cy="12" r="1.7"/><circle cx="12" cy="12" r="1.7"/>'
        '<circle cx="18.5" cy="12" r="1.7"/></g>'
    )
    LIVE = '<path d="M2.5 12.5h4l2.6-7.5 4.6 14 3-8.5 1.4 2h3.4"/>'
    SETTINGS = (
        '<path d="M4 7h9M19 7h1M4 17h1M11 17h9"/><circle cx="16" cy="7" r="2.8"/><circle cx="8" cy="17" r="2.8"/>'
    )
    HISTORY = '<path d="M3.6 12a8.6 8.6 0 1 0 2.7-6.3L3.5 8.2M3.5 3.8v4.4h4.4M12 7.5V12l3.2 2.2"/>'
    CLOCK = '<circle cx="12" cy="12" r="8.8"/><path d="M12 7v5.2l3.4 2"/>'
    CHECKLIST = '<path d="m3.5 6 1.7 1.7L8.4 4.5M3.5 16.5l1.7 1.7 3.2-3.2M12 6.2h8.5M12 16.7h8.5"/>'
    # A box that is being tipped.
    TESTS = (
        '<path d="m8 9.5 9-3.3 3.3 9-9 3.3Z"/><path d="M3 13.5a9.5 9.5 0 0 1 6.5-9.6M3 13.5l-1.2-3.6M3 13.5l3.3-1.8"/>'
    )
    DIAGNOSIS = '<circle cx="10.5" cy="10.5" r="6.8"/><path d="m15.6 15.6 5 5M7.4 10.8h1.8l1.3-2.6 1.3 4.3 1-1.7h1"/>'
    SIMULATOR = (
        '<rect x="6.5" y="6.5" width="11" height="11" rx="1.5" stroke-dasharray="3 2"/>'
        '<path d="M9.5 2.5v4M14.5 2.5v4M9.5 17.5v4M14.5 17.5v4M2.5 9.5h4M2.5 14.5h4M17.5 9.5h4M17.5 14.5h4"/>'
    )
    LIGHT = (
        '<circle cx="12" cy="12" r="3.8"/><path d="M12 2.5V5M12 19v2.5M2.5 12H5M19 12h2.5M5.3 5.3 7 7M17 17l1.7 1.7'
        'M18.7 5.3 17 7M7 17l-1.7 1.7"/>'
    )
    BAY_CLOSED = '<path d="M4 9.5h16v9.5a1.5 1.5 0 0 1-1.5 1.5h-13A1.5 1.5 0 0 1 4 19ZM3 5.5h18v4H3ZM10 13.5h4"/>'
    BAY_OPEN = '<path d="M4 11.5h16V19a1.5 1.5 0 0 1-1.5 1.5h-13A1.5 1.5 0 0 1 4 19ZM4 11.5 8.5 3 22 6.5M10 15h4"/>'
    CHEVRON_LEFT = '<path d="m14.5 5-7 7 7 7"/>'
    CHEVRON_RIGHT = '<path d="m9.5 5 7 7-7 7"/>'
    CHEVRON_UP = '<path d="m5 14.5 7-7 7 7"/>'
    CHEVRON_DOWN = '<path d="m5 9.5 7 7 7-7"/>'
    AGAIN = '<path d="M3.8 12a8.2 8.2 0 1 0 2.6-6L3.8 8.3M3.8 3.6v4.7h4.7"/>'
    COPY = (
        '<rect x="8.5" y="8.5" width="12" height="12" rx="1.8"/>'
        '<path d="M15.5 8.5v-3a2 2 0 0 0-2-2h-8a2 2 0 0 0-2 2v8a2 2 0 0 0 2 2h3"/>'
    )
    ERASE = '<path d="M4 6.5h16M9.5 6.5V4h5v2.5M6 6.5 7 20.5h10l1-14M10 10.5v6M14 10.5v6"/>'
    BOOKMARK = f'<path {_FULL} d="M6.5 3h11v18.2L12 17l-5.5 4.2Z"/>'
    RECORD = f'<circle {_FULL} cx="12" cy="12" r="7"/>'
    # A reel of what was.
    RECORDINGS = (
        '<rect x="2.8" y="5" width="18.4" height="14" rx="2"/><circle cx="8.2" cy="11" r="2.3"/>'
        '<circle cx="15.8" cy="11" r="2.3"/><path d="M8.2 13.3h7.6M6.5 19l1.4-2.6h8.2l1.4 2.6"/>'
    )
    FOLDER = '<path d="M3 19V5.5h6.2L11.4 8H21v11Z"/>'
    BUNDLE = '<path d="M3.5 7.5 12 3l8.5 4.5v9L12 21l-8.5-4.5ZM3.5 7.5 12 12l8.5-4.5M12 12v9"/>'
    TO_LIVE = (
        f'<path {_FULL} d="M4.5 5.2v13.6a.8.8 0 0 0 1.2.7l10-6.8a.8.8 0 0 0 0-1.4l-10-6.8a.8.8 0 0 0-1.2.7Z"/>'
        '<path d="M19.5 4.8v14.4"/>'
    )
    RESTART = '<path d="M12 2.8v8.4M7.2 5.6a8.2 8.2 0 1 0 9.6 0"/>'
    UNDO = '<path d="M8.5 4.5 4 9l4.5 4.5M4.5 9H14.5a5.5 5.5 0 0 1 0 11H11"/>'
    REDO = '<path d="M15.5 4.5 20 9l-4.5 4.5M19.5 9H9.5a5.5 5.5 0 0 0 0 11H13"/>'
    DROP = '<path d="M12 3v13M6.5 10.8 12 16.3l5.5-5.5M4.5 20.5h15"/>'
    # Flights that fire and flights that do not, over two thresholds.
    # Four modules side by side.
    FLEET = (
        '<rect x="3.5" y="4" width="7" height="7" rx="1.5"/><rect x="13.5" y="4" width="7" height="7" rx="1.5"/>'
        '<rect x="3.5" y="13.5" width="7" height="7" rx="1.5"/><rect x="13.5" y="13.5" width="7" height="7" rx="1.5"/>'
    )
    MAP = '<path d="M4 3.5v16.5h16.5M4 8h5.5v4h5v4H20"/><circle cx="16" cy="7" r="2.2"/>'
    BATTERY = '<rect x="1.8" y="6.8" width="17.4" height="10.4" rx="2"/><path d="M22.2 10.3v3.4"/>'


# The icon that goes with each meaning.
MEANING_ICONS: Final = {
    Meaning.GOOD: Icon.CHECK,
    Meaning.ATTENTION: Icon.WARNING,
    Meaning.DANGER: Icon.DANGER,
    Meaning.INFORMATION: Icon.INFORMATION,
    Meaning.UNKNOWN: Icon.UNKNOWN,
}


class Look(NamedTuple):
    """How a state looks; without a meaning it is plain."""

    icon: Icon
    meaning: Meaning | None


def svg(fragment: str, colour: str, stroke: float = 1.8) -> bytes:
    """A whole SVG picture of 24 by 24 from a fragment."""
    body = fragment.replace("currentColor", colour)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><g fill="none" stroke="{colour}" '
        f'stroke-width="{stroke}" stroke-linecap="round" stroke-linejoin="round">{body}</g></svg>'
    ).encode()


def battery(level: float | None) -> str:
    """The fragment of a battery, full at 1 and empty at 0; None is an unknown level, dashed."""
    if level is None:
        return Icon.BATTERY.value.replace("/>", ' stroke-dasharray="3 2.4"/>', 1)
    bars = min(4, max(0, round(level * 4)))
    filled = "".join(f'<rect {_FULL} x="{4 + 3.4 * bar}" y="9" width="2.4" height="6" rx=".4"/>' for bar in range(bars))
    return Icon.BATTERY.value + filled


def draw(painter: QPainter, fragment: Icon | str, rect: QRectF | QRect, colour: QColor | str) -> None:
    """Paint an icon, or a fragment such as ``battery`` makes, into a square."""
    square = QRectF(rect)
    pixels = max(1, round(square.width() * painter.device().devicePixelRatio()))
    picture = pixmap(fragment, pixels, colour)
    painter.drawPixmap(square, picture, QRectF(picture.rect()))


def pixmap(fragment: Icon | str, size: int, colour: QColor | str, *, ratio: float = 1.0) -> QPixmap:
    """An icon of ``size`` logical pixels for a screen of ``ratio`` device pixels each.

    Kept in ``QPixmapCache``. A label that got a new pixmap each time would leave one more scaled copy in that cache.
    """
    text = fragment.value if isinstance(fragment, Icon) else fragment
    name = QColor(colour).name()
    pixels = max(1, round(size * ratio))
    key = f"dps-s/{pixels}/{ratio}/{current().line_px}/{name}/{text}"
    picture = QPixmap()
    if not QPixmapCache.find(key, picture):
        picture = _rendered(text, name, pixels)
        picture.setDevicePixelRatio(ratio)
        QPixmapCache.insert(key, picture)
    return picture


def _rendered(fragment: str, colour: str, pixels: int) -> QPixmap:
    # Thick lines in sunlight, for icons too.
    stroke = 1.8 if current().line_px == 1 else 2.4
    image = QImage(pixels, pixels, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    QSvgRenderer(QByteArray(svg(fragment, colour, stroke))).render(painter)
    painter.end()
    return QPixmap.fromImage(image)


def _widened(picture: QPixmap, width: int, ratio: float) -> QPixmap:
    """The picture at the left of empty room: Qt leaves only 4 px between the icon and the text of a button."""
    wide = QPixmap(width, picture.height())
    wide.setDevicePixelRatio(ratio)
    wide.fill(Qt.GlobalColor.transparent)
    painter = QPainter(wide)
    painter.drawPixmap(0, 0, picture)
    painter.end()
    return wide


class _Engine(QIconEngine):
    """Paints one icon in the colour that the theme has for it at that moment."""

    def __init__(self, one: Icon, meaning: Meaning | None, *, is_on_primary: bool) -> None:
        super().__init__()
        self._icon = one
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
        side = min(size.width(), size.height())
        picture = pixmap(self._icon, side, self._colour(mode), ratio=scale)
        return picture if size.width() <= side else _widened(picture, round(size.width() * scale), scale)

    def clone(self) -> QIconEngine:
        return _Engine(self._icon, self._meaning, is_on_primary=self._is_on_primary)


def icon(one: Icon, meaning: Meaning | None = None, *, is_on_primary: bool = False) -> QIcon:
    """An icon for a button or an entry, in the colour of plain text, of a meaning, or of text on a main button."""
    return QIcon(_Engine(one, meaning, is_on_primary=is_on_primary))


def set_icon_size(widget: QAbstractButton | QAbstractItemView, px: int, *, gap_px: int = 0) -> None:
    """Sets the size of a widget's icons at the usual size of text; they grow with the text. `gap_px` is empty room at
    the right."""
    widget.setProperty(_SIZE, QSize(px + gap_px, px))
    _scale_icons(widget)


def fit_icons(part: QWidget) -> None:
    """Scales the icons of all buttons and lists in a part of the window, after a change of the size of text."""
    for button in part.findChildren(QAbstractButton):
        _scale_icons(button)
    for view in part.findChildren(QAbstractItemView):
        _scale_icons(view)


def _scale_icons(widget: QAbstractButton | QAbstractItemView) -> None:
    size = widget.property(_SIZE)
    if isinstance(size, QSize):
        widget.setIconSize(QSize(scaled(size.width()), scaled(size.height())))


_APP_ICON: Final = (
    '<rect x="0" y="0" width="24" height="24" rx="5.4" fill="#1F2833" stroke="none"/>'
    '<g transform="translate(3.4 3) scale(.717)">'
    '<path fill="#F3B434" stroke="#F3B434" d="M7.25 11.5C7.6 6.5 9.8 3 12 3s4.4 3.5 4.75 8.5c-1.6-1.4-3.15-1.4'
    '-4.75 0-1.6-1.4-3.15-1.4-4.75 0Z"/>'
    f"{Icon.PARACHUTE.value}</g>"
)


def app_icon() -> QIcon:
    """The program's own: a white parachute on a dark rounded square, the same in every theme."""
    one = QIcon()
    for side in (16, 24, 32, 48, 64, 128, 256):
        one.addPixmap(pixmap(_APP_ICON, side, "#FFFFFF"))
    return one


def app_icon_svg() -> bytes:
    """The same as a file, for packages and desktops."""
    return svg(_APP_ICON, "#FFFFFF") + b"\n"
