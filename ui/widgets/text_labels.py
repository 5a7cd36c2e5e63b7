"""Labels for running text."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from ui.widgets.naming import named


def text_label(name: str, role: str = "", *, is_selectable: bool = False) -> QLabel:
    """Plain text that wraps; `role` is one of the style sheet's."""
    label = named(QLabel(), name, role)
    label.setWordWrap(True)
    label.setTextFormat(Qt.TextFormat.PlainText)
    if is_selectable:
        flags = Qt.TextInteractionFlag
        label.setTextInteractionFlags(flags.TextSelectableByMouse | flags.TextSelectableByKeyboard)
    return label
