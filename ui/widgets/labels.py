"""Labels: wrapping and elided text, a ticking figure, an icon of the theme, what stands in place of an empty list."""

from typing import ClassVar, Final

from PySide6.QtCore import QEvent, QRect, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetrics, QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QWidget

from ui.style.icons import Icon, pixmap
from ui.style.theme import IconSize, Meaning, Space, current, scaled
from ui.widgets.controls import named
from ui.widgets.layouts import in_column

_REDRAWN_AT: Final = (QEvent.Type.PaletteChange, QEvent.Type.StyleChange, QEvent.Type.DevicePixelRatioChange)

SELECTABLE: Final = Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard


def text_label(name: str, role: str = "", *, is_selectable: bool = False) -> QLabel:
    """A label that wraps; `role` is one of the style sheet's."""
    label = named(QLabel(), name, role)
    label.setWordWrap(True)
    if is_selectable:
        label.setTextInteractionFlags(SELECTABLE)
    return label


class ElidedLabel(QLabel):
    """Plain text that ends in "…" where it has no room, and is then whole in the tooltip. `text()` is always whole.

    It is one line, elided at `mode`; with word wrap it takes the height that the layout gives.
    """

    def __init__(self, mode: Qt.TextElideMode = Qt.TextElideMode.ElideRight) -> None:
        super().__init__()
        self._mode = mode
        self.setMinimumWidth(1)  # less than its text

    def paintEvent(self, _event: QPaintEvent) -> None:
        shown = self._wrapped() if self.wordWrap() else self._elided()
        self.setToolTip("" if shown == self.text() else self.text())
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        wrap = Qt.TextFlag.TextWordWrap.value if self.wordWrap() else 0
        painter.drawText(self.contentsRect(), self.alignment().value | wrap, shown)
        painter.end()

    def _elided(self) -> str:
        return QFontMetrics(self.font()).elidedText(self.text(), self._mode, self.contentsRect().width())

    def _wrapped(self) -> str:
        metrics, room = QFontMetrics(self.font()), self.contentsRect()
        wide, flags = QRect(0, 0, room.width(), 0), Qt.TextFlag.TextWordWrap.value
        shown, end = self.text(), len(self.text())
        while end and metrics.boundingRect(wide, flags, shown).height() > room.height():
            end -= 1
            shown = f"{self.text()[:end].rstrip()}…"
        return shown


class TickingLabel(QLabel):
    """A figure or an age that changes all the time. Its accessible name says what it is; screen readers get the text
    when they ask, and no event for each change."""

    accessible_role: ClassVar = QAccessible.Role.StaticText

    def accessibleName(self) -> str:
        """The whole text, as screen readers get it."""
        subject = super().accessibleName()
        return f"{subject}: {self.text()}" if self.text() else subject


class IconLabel(QLabel):
    """An icon beside a text; empty at first."""

    def __init__(self, name: str, size_px: int, *, keeps_place: bool = False) -> None:
        """`size_px` at the usual size of text. `keeps_place`: as large without an icon."""
        self._size_px = scaled(size_px)
        self._shown: tuple[Icon, Meaning | None, bool, bool] | None = None
        super().__init__()
        named(self, name)
        if keeps_place:
            self.setFixedSize(self._size_px, self._size_px)

    def show_icon(
        self, picture: Icon, meaning: Meaning | None = None, *, is_muted: bool = False, is_filled: bool = False
    ) -> None:
        """Shows `picture` in the colour of its meaning, also on a ground filled with it, of muted text, or of text."""
        if self._shown != (picture, meaning, is_muted, is_filled):
            self._shown = (picture, meaning, is_muted, is_filled)
            self._draw()

    def clear_icon(self) -> None:
        self._shown = None
        self.clear()

    def _draw(self) -> None:
        if self._shown is not None:
            picture, meaning, is_muted, is_filled = self._shown
            ink = QColor(current().muted) if is_muted else current().ink(meaning)
            if is_filled and meaning is not None:
                ink = QColor(current().tint(meaning).on_fill)
            self.setPixmap(pixmap(picture, self._size_px, ink, ratio=self.devicePixelRatioF()))

    def event(self, event: QEvent) -> bool:
        if event.type() in _REDRAWN_AT:
            self._draw()
        return super().event(event)


class EmptyState(QWidget):
    """Without `title` and `text` the owner fills the labels."""

    def __init__(self, name: str, picture: Icon, title: str = "", text: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        self._picture = IconLabel(f"{name}_icon", IconSize.EMPTY)
        self._picture.show_icon(picture, is_muted=True)
        self._picture.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.title = named(QLabel(title), f"{name}_title", "title")
        self.text = named(QLabel(text), f"{name}_text", "muted")
        column = self.column = in_column(2, self._picture, of=self, spacing=Space.S, margins=Space.XL)
        for label in (self.title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            label.setWordWrap(True)
            column.addWidget(label)  # without an alignment, which would break the height of wrapped text
        column.addStretch(3)
