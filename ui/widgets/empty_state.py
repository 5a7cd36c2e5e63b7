"""Placeholder for an empty list: picture, reason, next action."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from ui.style.icons import Icon, pixmap
from ui.style.theme import Space, current
from ui.widgets.naming import named

_MARGIN_PX: Final = 120
_ICON_PX: Final = 48


class EmptyState(QWidget):
    """Who makes it fills `title` and `text`, and calls `apply_theme` when the theme has changed."""

    def __init__(self, name: str, picture: Icon) -> None:
        super().__init__()
        self.setObjectName(name)
        self._icon = picture
        self._picture = named(QLabel(), f"{name}_icon")
        self._picture.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.title, self.text = named(QLabel(), f"{name}_title"), named(QLabel(), f"{name}_text")
        self.title.setProperty("role", "title")
        self.text.setProperty("role", "muted")
        column = QVBoxLayout(self)
        column.setContentsMargins(_MARGIN_PX, 0, _MARGIN_PX, 0)
        column.setSpacing(Space.S)
        column.addStretch(2)
        column.addWidget(self._picture)
        for label in (self.title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            label.setWordWrap(True)
            column.addWidget(label)  # not aligned itself: then it would not get the height of its lines
        column.addStretch(3)
        self.apply_theme()

    def apply_theme(self) -> None:
        """Take the colours of the theme in use."""
        self._picture.setPixmap(pixmap(self._icon, _ICON_PX, current().muted, ratio=self.devicePixelRatioF()))
