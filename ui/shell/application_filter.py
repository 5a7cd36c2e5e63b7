"""What holds in every window: LOCK by its keys and by the first click while a menu is open; labels are plain text."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence, QMouseEvent, QShowEvent, QWindow
from PySide6.QtWidgets import QApplication, QLabel

from ui.session.ports import LockControl
from ui.widgets.step_button import application

LOCK_KEYS: Final = ("Ctrl+L", "F12")
LOCK_ALL_KEY: Final = "Ctrl+Shift+L"
# By class: `type()` would first make a member of its enumeration of every event of the application.
_HANDLED: Final = (QKeyEvent, QMouseEvent, QShowEvent)


class ApplicationFilter(QObject):
    """Filters the events of the application, so that no new window has to remember any of it. A label or a tool tip is
    made plain before it is seen: a module or a file may be named like a picture or a heading."""

    def __init__(self, lock: LockControl, parent: QObject) -> None:
        super().__init__(parent)
        self._lock = lock
        self._acts: dict[str, Callable[[], object]] = dict.fromkeys(LOCK_KEYS, lock.press)
        self._acts |= {LOCK_ALL_KEY: lock.press_all}
        for label in parent.findChildren(QLabel):
            label.setTextFormat(Qt.TextFormat.PlainText)
        application().installEventFilter(self)

    def stop(self) -> None:
        application().removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, _HANDLED):
            return False
        if isinstance(event, QKeyEvent):
            return event.type() != QEvent.Type.KeyRelease and self._on_key(event)
        if isinstance(event, QMouseEvent):
            is_press = event.type() == QEvent.Type.MouseButtonPress and isinstance(watched, QWindow)
            return is_press and self._on_press(event)
        if isinstance(watched, QLabel) and watched.textFormat() != Qt.TextFormat.PlainText:
            watched.setTextFormat(Qt.TextFormat.PlainText)
            if watched.windowType() == Qt.WindowType.ToolTip:
                watched.resize(watched.sizeHint())
        return False

    def _on_key(self, event: QKeyEvent) -> bool:
        act = self._acts.get(QKeySequence(event.keyCombination()).toString())
        if act is None:
            return False
        event.accept()  # of `ShortcutOverride`: it comes again as `KeyPress`, and not as a shortcut
        if event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat():
            act()
        return True

    def _on_press(self, event: QMouseEvent) -> bool:
        """Without this a click would only close the menu or the list."""
        popup, button = QApplication.activePopupWidget(), QApplication.widgetAt(event.globalPosition().toPoint())
        act = None if button is None else self._lock.buttons.get(button)
        if act is None or popup is None:
            return False
        popup.close()
        act()
        return True
