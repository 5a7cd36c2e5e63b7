"""Placeholder for an empty list: picture, reason, next action."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QWidget

from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.labels import IconLabel
from ui.widgets.layouts import in_column

_MARGIN_PX: Final = 120
_ICON_PX: Final = 48


class EmptyState(QWidget):
    """`title` and `text` are English, marked; without them the owner fills the labels."""

    def __init__(self, name: str, picture: Icon, texts: Texts, title: str = "", text: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        self._picture = IconLabel(f"{name}_icon", _ICON_PX)
        self._picture.show_icon(picture, is_muted=True)
        self._picture.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.title = control(QLabel(), texts, f"{name}_title", title, role="title")
        self.text = control(QLabel(), texts, f"{name}_text", text, role="muted")
        column = self.column = in_column(2, self._picture, of=self, spacing=Space.S, margins=(_MARGIN_PX, 0))
        for label in (self.title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            label.setWordWrap(True)
            column.addWidget(label)  # without an alignment, which would break the height of wrapped text
        column.addStretch(3)
