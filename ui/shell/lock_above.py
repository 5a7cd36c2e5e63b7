"""LOCK above everything: its keys and a LOCK button work whatever dialog, menu or list is open."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence, QMouseEvent, QShowEvent, QWindow
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QPushButton, QSizePolicy, QWhatsThis, QWidget

from app.procedures.lock import SENTENCES
from app.safety.journal import Outcome
from app.text.i18n import tr
from ui.session.ports import Ports
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.gestures import application
from ui.widgets.labels import ElidedLabel, be_plain
from ui.widgets.layouts import in_row
from ui.widgets.visibility_timer import VisibilityTimer

LOCK_KEYS: Final = ("Ctrl+L", "F12")
_KEY_EVENTS: Final = frozenset({QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress})
_PRESSES: Final = frozenset({QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick})
_HANDLED: Final = (QKeyEvent, QMouseEvent, QShowEvent)
"""By class: of every event of the application `type()` would make an enumeration's member first."""


class LockStrip(QWidget):
    """LOCK and its outcome, in a line at the top of a dialog: hidden until there is a module to be locked."""

    def __init__(self, ports: Ports) -> None:
        super().__init__()
        named(self, "lock_strip")
        self._ports = ports
        self.sentence = named(ElidedLabel(), "lock_strip_said")
        self.button = control(
            QPushButton(tr("LOCK")), "lock_strip_button", key=LOCK_KEYS[0], picture=Icon.LOCK, slot=ports.lock.press
        )
        self.button.setAutoDefault(False)  # Enter belongs to the dialog
        in_row((self.sentence, 1), self.button, of=self, spacing=Space.S, margins=(Space.M, Space.S, Space.M, 0))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        ports.lock.buttons.add(self.button)
        ports.lock_changed.connect(self.refresh)
        self.setVisible(ports.current.lock.is_possible)
        VisibilityTimer(self, self.refresh)
        self.refresh()

    def refresh(self) -> None:
        lock = self._ports.current.lock
        if lock.is_possible and self.isHidden():
            self.show()  # and stays, so that what is below does not move back and forth
        self.button.setEnabled(lock.is_possible)
        notice = lock.notice()
        reported = tr(SENTENCES[Outcome.CONFIRMED]) if lock.is_reported else ""
        self.sentence.setText(reported if notice is None else notice.text)


class LockAbove(QObject):
    """Filters the events of the application, so that nothing new has to remember it.

    A modal dialog keeps clicks and shortcuts from the window, and any dialog may cover it: each, also Qt's own, gets a
    `LockStrip` above its contents, which covers nothing. A menu or a list that is open takes the first click: a press
    on a LOCK outside it counts all the same. Ctrl+L and F12 count in every window. `button`: the window's LOCK.

    The labels of dialogs and the tool tips show plain text: a module may be named like a picture or a heading.
    """

    def __init__(self, ports: Ports, button: QPushButton, parent: QObject) -> None:
        super().__init__(parent)
        self._ports, self._lock, self._button = ports, ports.lock, button
        self._keys = [QKeySequence(key) for key in LOCK_KEYS]
        application().installEventFilter(self)

    def stop(self) -> None:
        application().removeEventFilter(self)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """For work that shows no dialog or menu, within one turn of the event loop, which no key and no click can
        reach: what makes a page has thousands of other events, a fifth of its time."""
        self.stop()
        try:
            yield
        finally:
            application().installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, _HANDLED):
            return False
        if isinstance(event, QKeyEvent):
            return event.type() in _KEY_EVENTS and self._on_key(event)
        if isinstance(event, QMouseEvent):
            return event.type() in _PRESSES and isinstance(watched, QWindow) and self._on_press(event)
        if isinstance(watched, QDialog):
            layout = watched.layout()
            if layout is not None and layout.menuBar() is None:
                layout.setMenuBar(LockStrip(self._ports))
            for label in watched.findChildren(QLabel):  # Qt's own dialogs show names of files
                be_plain(label)
        elif isinstance(watched, QLabel) and watched.windowType() == Qt.WindowType.ToolTip:
            be_plain(watched)
            watched.resize(watched.sizeHint())
        elif isinstance(watched, QWidget) and watched.windowType() == Qt.WindowType.Popup:
            self._uncover(watched)
        return False

    def _on_key(self, event: QKeyEvent) -> bool:
        if QKeySequence(event.keyCombination()) not in self._keys:
            return False
        event.accept()  # of `ShortcutOverride`: it comes again as `KeyPress`, and not as a shortcut
        if event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat():
            self._lock.press()
        return True

    def _on_press(self, event: QMouseEvent) -> bool:
        """Where a click would only close a menu or a list, or ask what LOCK is."""
        popup = QApplication.activePopupWidget()
        if popup is None and not QWhatsThis.inWhatsThisMode():
            return False
        place = event.globalPosition().toPoint()
        if popup is not None and popup.frameGeometry().contains(place):
            return False
        button, modal = QApplication.widgetAt(place), QApplication.activeModalWidget()
        if button not in self._lock.buttons or button is None or (modal is not None and button.window() is not modal):
            return False
        if popup is not None:
            popup.close()
        self._lock.press()
        return True

    def _uncover(self, popup: QWidget) -> None:
        """Moves a menu or a list that would cover LOCK below it, or beside it."""
        button = self._button
        place = QRect(button.mapToGlobal(QPoint()), button.size())
        geometry = popup.frameGeometry()
        if not button.isVisible() or not geometry.intersects(place):
            return
        below = geometry.translated(0, place.bottom() + 1 - geometry.top())
        if below.bottom() <= popup.screen().availableGeometry().bottom():
            popup.move(below.topLeft())
        else:
            popup.move(place.left() - geometry.width(), geometry.top())
