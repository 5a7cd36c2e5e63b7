"""LOCK from everywhere: its keys in every window, and the first click on its button while a menu or a list is open."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence, QMouseEvent, QShowEvent, QWindow
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QWhatsThis

from ui.session.ports import LockControl
from ui.widgets.gestures import application
from ui.widgets.labels import be_plain

LOCK_KEYS: Final = ("Ctrl+L", "F12")
# By class: `type()` would first make a member of its enumeration of every event of the application.
_HANDLED: Final = (QKeyEvent, QMouseEvent, QShowEvent)


class LockFilter(QObject):
    """Filters the events of the application, so that no new window has to remember LOCK.

    It also makes the labels of dialogs and the tool tips show plain text: a module or a file may be named like a
    picture or a heading.
    """

    def __init__(self, lock: LockControl, parent: QObject) -> None:
        super().__init__(parent)
        self._lock = lock
        self._keys = [QKeySequence(key) for key in LOCK_KEYS]
        application().installEventFilter(self)

    def stop(self) -> None:
        application().removeEventFilter(self)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """For the making of pages: no key and no click comes then, and a fifth of the time would go into the filter."""
        self.stop()
        try:
            yield
        finally:
            application().installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, _HANDLED):
            return False
        if isinstance(event, QKeyEvent):
            return event.type() != QEvent.Type.KeyRelease and self._on_key(event)
        if isinstance(event, QMouseEvent):
            return (
                event.type() == QEvent.Type.MouseButtonPress and isinstance(watched, QWindow) and self._on_press(event)
            )
        if isinstance(watched, QDialog):
            for label in watched.findChildren(QLabel):  # Qt's own dialogs show names of files
                be_plain(label)
        elif isinstance(watched, QLabel) and watched.windowType() == Qt.WindowType.ToolTip:
            be_plain(watched)
            watched.resize(watched.sizeHint())
        return False

    def _on_key(self, event: QKeyEvent) -> bool:
        if QKeySequence(event.keyCombination()) not in self._keys:
            return False
        event.accept()  # of `ShortcutOverride`: it comes again as `KeyPress`, and not as a shortcut
        if event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat():
            self._lock.press()
        return True

    def _on_press(self, event: QMouseEvent) -> bool:
        """Without this a click would only close the menu or the list, or ask what LOCK is."""
        popup = QApplication.activePopupWidget()
        if popup is None and not QWhatsThis.inWhatsThisMode():
            return False
        if QApplication.widgetAt(event.globalPosition().toPoint()) not in self._lock.buttons:
            return False
        if popup is not None:
            popup.close()
        self._lock.press()
        return True
