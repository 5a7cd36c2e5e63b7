"""Labels: wrapping text, one elided line, text in a given height, a ticking figure, an icon of the theme, and
what stands in place of an empty list."""

from typing import ClassVar, Final

from PySide6.QtCore import QEvent, QRect, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFont, QFontMetrics, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget

from app.text.sentences import join_sentences
from ui.style.icons import Icon, pixmap
from ui.style.theme import IconSize, Meaning, Size, Space, current, font, scaled
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
    """One line of plain text, elided at `mode` where it has no room. `text()` is always the whole text."""

    def __init__(self, mode: Qt.TextElideMode = Qt.TextElideMode.ElideRight) -> None:
        self._mode = mode
        super().__init__()

    def setText(self, text: str) -> None:
        super().setText(text)
        self._update_tip()

    def minimumSizeHint(self) -> QSize:
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        painter.drawText(self.contentsRect(), self.alignment(), self._elided())
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._update_tip()

    def _elided(self) -> str:
        return QFontMetrics(self.font()).elidedText(self.text(), self._mode, self.contentsRect().width())

    def _update_tip(self) -> None:
        self.setToolTip("" if self._elided() == self.text() else self.text())


class FittedLabel(QLabel):
    """Plain text that wraps within the height that the layout gives: small where it is long, and at last elided, then
    with a tooltip."""

    def __init__(self, *, is_bold: bool = False) -> None:
        super().__init__()
        self._whole, self._is_bold = "", is_bold
        self.setWordWrap(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)

    def show_text(self, text: str, note: str = "") -> None:
        """Shows `text`, and after it a `note`."""
        whole = join_sentences([text, note])
        if self._whole != whole:
            self._whole = whole
            self._fit()

    def minimumSizeHint(self) -> QSize:
        return QSize(0, 0)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        for size in (Size.BODY, Size.SMALL):
            letters = font(size)
            letters.setBold(self._is_bold)
            if self._has_room(self._whole, letters):
                break
        shown, end = self._whole, len(self._whole)
        while end and not self._has_room(shown, letters):
            end -= 1
            shown = f"{self._whole[:end].rstrip()}…"
        self.setFont(letters)
        self.setText(shown)
        self.setToolTip("" if shown == self._whole else self._whole)

    def _has_room(self, text: str, letters: QFont) -> bool:
        room = self.contentsRect()
        flags = Qt.TextFlag.TextWordWrap.value
        needed = QFontMetrics(letters).boundingRect(QRect(0, 0, room.width(), 0), flags, text)
        return needed.height() <= room.height() and needed.width() <= room.width()


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
