"""Placeholder for an empty list: picture, reason, next action."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QWidget

from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.labels import IconLabel
from ui.widgets.layouts import in_column
from ui.widgets.naming import named

_MARGIN_PX: Final = 120
_ICON_PX: Final = 48


class EmptyState(QWidget):
    """The owner fills `title` and `text`."""

    def __init__(self, name: str, picture: Icon) -> None:
        super().__init__()
        self.setObjectName(name)
        self._picture = IconLabel(f"{name}_icon", _ICON_PX)
        self._picture.show_icon(picture, is_muted=True)
        self._picture.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.title, self.text = named(QLabel(), f"{name}_title", "title"), named(QLabel(), f"{name}_text", "muted")
        column = self.column = in_column(2, self._picture, of=self, spacing=Space.S, margins=(_MARGIN_PX, 0))
        for label in (self.title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            label.setWordWrap(True)
            column.addWidget(label)  # without an alignment, which would break the height of wrapped text
        column.addStretch(3)
