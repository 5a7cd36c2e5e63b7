"""Keeps the window on its screen."""

from typing import Final

from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtWidgets import QWidget

FRAME: Final = QSize(4, 36)
"""Size of a window's title bar and edges, before the system reports it."""


def fitting(wanted: QRect, free: QRect) -> QRect:
    """`wanted`, moved and shrunk until it lies within `free`."""
    size = wanted.size().boundedTo(free.size())
    left = min(max(wanted.left(), free.left()), free.left() + free.width() - size.width())
    top = min(max(wanted.top(), free.top()), free.top() + free.height() - size.height())
    return QRect(QPoint(left, top), size)


def free_area(window: QWidget) -> QRect:
    """The part of the screen where the inside of the window may be, in logical pixels."""
    frame = window.frameGeometry().size() - window.geometry().size() if window.isVisible() else QSize()
    frame = frame.expandedTo(FRAME)
    return (
        window.screen()
        .availableGeometry()
        .adjusted(frame.width() // 2, frame.height() - frame.width() // 2, -frame.width() // 2, -frame.width() // 2)
    )


def fit_screen(window: QWidget, smallest: QSize) -> None:
    """Keeps the window on its screen, whose size also limits the minimum size `smallest`."""
    free = free_area(window)
    window.setMinimumSize(smallest.boundedTo(free.size()))
    if not window.isMaximized() and not window.isFullScreen():
        window.setGeometry(fitting(window.geometry(), free))
