"""An icon beside a text, in the colours of the theme in use."""

from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QLabel

from ui.style.icons import Icon, pixmap
from ui.style.theme import Meaning, current
from ui.widgets.naming import named

_REDRAWN_AT = (QEvent.Type.PaletteChange, QEvent.Type.StyleChange, QEvent.Type.DevicePixelRatioChange)


class IconLabel(QLabel):
    """Empty until an icon is shown."""

    def __init__(self, name: str, size_px: int) -> None:
        self._size_px = size_px
        self._shown: tuple[Icon, Meaning | None, bool] | None = None
        super().__init__()
        named(self, name)

    def show_icon(self, picture: Icon, meaning: Meaning | None = None, *, is_muted: bool = False) -> None:
        """In the colour of its meaning, of muted text, or of plain text."""
        if self._shown != (picture, meaning, is_muted):
            self._shown = (picture, meaning, is_muted)
            self._draw()

    def _draw(self) -> None:
        if self._shown is not None:
            picture, meaning, is_muted = self._shown
            ink = current().muted if is_muted else current().ink(meaning)
            self.setPixmap(pixmap(picture, self._size_px, ink, ratio=self.devicePixelRatioF()))

    def event(self, event: QEvent) -> bool:
        if event.type() in _REDRAWN_AT:
            self._draw()
        return super().event(event)
