"""How large the window may be on its screen."""

from typing import Final

from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtWidgets import QWidget

FRAME: Final = QSize(4, 36)
"""What a window's title bar and edges take, before the system says it."""


def fitting(wanted: QRect, free: QRect) -> QRect:
    """The wanted place, moved and made smaller until it lies within the free part of a screen."""
    size = wanted.size().boundedTo(free.size())
    left = min(max(wanted.left(), free.left()), free.left() + free.width() - size.width())
    top = min(max(wanted.top(), free.top()), free.top() + free.height() - size.height())
    return QRect(QPoint(left, top), size)


def free_area(window: QWidget) -> QRect:
    """Where the inside of the window may lie on its screen, in logical pixels."""
    frame = window.frameGeometry().size() - window.geometry().size() if window.isVisible() else QSize()
    frame = frame.expandedTo(FRAME)
    return (
        window.screen()
        .availableGeometry()
        .adjusted(frame.width() // 2, frame.height() - frame.width() // 2, -frame.width() // 2, -frame.width() // 2)
    )


def fit_screen(window: QWidget, smallest: QSize) -> None:
    """Keep the window on its screen; `smallest` is given up where the screen is smaller."""
    free = free_area(window)
    window.setMinimumSize(smallest.boundedTo(free.size()))
    if not window.isMaximized() and not window.isFullScreen():
        window.setGeometry(fitting(window.geometry(), free))
