"""A hand at the real window: pointer and keys, of which each event goes to the window's `QWindow`, as a platform sends
them. Qt finds the widget under the pointer itself."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar
from unittest.mock import patch

from PySide6.QtCore import QCoreApplication, QEvent, QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QInputEvent, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QApplication, QMenu, QWidget

from tests.support.journals import FakeJournal
from tests.support.window.fakes_ui import page_entries
from tests.support.window.rig import TURN_S, Rig, on_fake_time
from tests.support.window.steps import given
from ui.services.storage import Storage
from ui.widgets.step_button import gestures

LEFT, NO_BUTTON, NO_KEY = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier
Made = TypeVar("Made", bound="Hand")


@dataclass
class Hand(Rig):
    journal: FakeJournal = field(default_factory=FakeJournal)
    pointer: QPoint = field(default_factory=lambda: QPoint(1, 1))
    is_down: bool = False
    _event_ms: int = 0

    # Time

    def turn(self, longest_s: float = TURN_S) -> None:
        super().turn(longest_s)
        QCoreApplication.sendEvent(self.window, QEvent(QEvent.Type.UpdateRequest))  # as before each frame

    def look(self) -> None:
        """What changed is shown; no time passes."""
        self.turn(0)

    def wait(self, seconds: float) -> None:
        self.look()  # what changed is seen before time passes
        end_s = self.clock() + seconds
        while (left_s := end_s - self.clock()) > 1e-9:
            has_time = not (self.is_down or gestures().has_key_down or self.commands.ritual.is_under_way)
            self.turn(min(left_s, 4 * TURN_S if has_time else TURN_S))

    # The hand

    def _send(self, event: QInputEvent, *, is_same_time: bool = False) -> None:
        if not is_same_time:
            self._event_ms = max(self._event_ms + 1, round(self.clock() * 1000))
        event.setTimestamp(self._event_ms)
        QTimer.singleShot(0, self.window, _close_menu)  # a menu returns only when it is closed
        QApplication.sendEvent(given(self.window.windowHandle()), event)

    def _mouse(self, kind: QEvent.Type, button: Qt.MouseButton) -> None:
        place, down = QPointF(self.pointer), LEFT if self.is_down else NO_BUTTON
        self._send(QMouseEvent(kind, place, place, self.window.mapToGlobal(place), button, down, NO_KEY))

    def at(self, widget: QWidget, offset: QPoint | None = None) -> QPoint:
        return widget.mapTo(self.window, widget.rect().center() if offset is None else offset)

    def move(self, to: QPoint) -> None:
        self.pointer = to
        self._mouse(QEvent.Type.MouseMove, NO_BUTTON)

    def press(self, *, is_double: bool = False) -> None:
        self.is_down = True
        self._mouse(QEvent.Type.MouseButtonDblClick if is_double else QEvent.Type.MouseButtonPress, LEFT)

    def release(self) -> None:
        self.is_down = False
        self._mouse(QEvent.Type.MouseButtonRelease, LEFT)

    def click(self, widget: QWidget | str | None = None, *, is_double: bool = False) -> None:
        """Where the pointer is; a widget as a careful person does, from elsewhere and after a while."""
        if widget is not None:
            one = self.find(QWidget, widget) if isinstance(widget, str) else widget
            self.move(QPoint(1, 1))
            self.wait(0.6)
            self.move(self.at(one))
        self.press(is_double=is_double)
        self.look()
        self.release()
        self.look()

    def key(self, key: Qt.Key, *, is_press: bool, is_repeat: bool = False, is_marked: bool = True) -> None:
        """Repeats have one timestamp, and are not always marked as repeats on X11."""
        kind = QEvent.Type.KeyPress if is_press else QEvent.Type.KeyRelease
        event = QKeyEvent(kind, key, NO_KEY, " " if key == Qt.Key.Key_Space else "", is_repeat and is_marked)
        self._send(event, is_same_time=is_repeat and is_press)

    # States to begin from

    def show_guided(self) -> None:
        self.window.go_to("preflight")
        self.preflight.show_view("guided")

    def settle_module(self, *, is_active: bool) -> None:
        view = self.assembly.ports.module
        self.bench.module.activate(is_active=is_active)
        self.until(lambda: view.view.fresh("active", self.clock()) is is_active)

    def reset(self) -> None:
        """Cancel every choice and question, and release what is held."""
        if self.is_down:
            self.release()
        for row in self.commands.acts.values():
            row.confirm.withdraw()
        if self.commands.ritual.is_under_way:
            self.commands.ritual.cancel.click()
        self.move(QPoint(1, 1))
        self.wait(1.0)
        self.requests.clear()


def _close_menu() -> None:
    if isinstance(popup := QApplication.activePopupWidget(), QMenu):
        popup.close()


@contextmanager
def hand_at(kind: type[Made], qapp: QApplication, folder: Path, *pages: str) -> Iterator[Made]:
    """Open a window with these pages, Commands among them, on a simulated module of which everything is read."""
    journal, no_bot = FakeJournal(), None
    with (
        patch.object(Storage, "journal", lambda *_: journal),
        # No hand has a dialog for files under it: whoever is asked cancels at once.
        patch("ui.files.file_dialogs._open_file_dialog", lambda dialog, _then: dialog.deleteLater()),
        on_fake_time(kind, no_bot, qapp, folder, "hand", page_entries(*pages)) as hand,  # type: ignore[arg-type]
    ):
        hand.journal = journal
        hand.window.resize(1024, 600)
        if "preflight" in pages:  # a menu of this button would wait for a person
            hand.preflight.form.choose.setMenu(None)  # type: ignore[arg-type]
        hand.connect()
        hand.window.go_to("commands")
        yield hand
    gestures().reset()
