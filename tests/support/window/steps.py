"""Finds, awaits and clicks widgets; steps of an act, which count only after 0.5 s, deliberately."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QMimeData, QObject, QPoint, QPointF, QRect, Qt, QUrl
from PySide6.QtGui import QCursor, QDragEnterEvent, QDropEvent, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.controls import visible_in
from ui.style import appearance
from ui.style.theme import Theme
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import DEAD_FOR_S, StepButton, gestures

Thing = TypeVar("Thing")
Found = TypeVar("Found", bound=QObject)
_POINTER_AT_START = QPoint(10, 10)
"""Of Qt's offscreen platform."""


def choosing(answer: object, asked: list[Any] | None = None) -> Callable[..., object]:
    """In place of a dialog for a file or a text: a person who answers at once. `asked`: gets what each dialog said."""

    def choose(*dialog: Any) -> None:
        if asked is not None:
            asked.append(dialog[1:-1])
        dialog[-1](answer)

    return choose


def style_all(app: QApplication, theme: Theme) -> None:
    """Style all widgets, for those in no window; the sheet is taken away after the test."""
    appearance.apply(app, theme)
    app.setStyleSheet(appearance.style_sheet(theme))


def drop(target: QWidget, *paths: Path) -> bool:
    """As the window system would tell it; whether these files were taken."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    place, actions = target.rect().center(), Qt.DropAction.CopyAction
    button, no_key = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(place, actions, data, button, no_key)
    enter.ignore()
    QApplication.sendEvent(target, enter)
    if enter.isAccepted():
        QApplication.sendEvent(target, QDropEvent(QPointF(place), actions, data, button, no_key))
    return enter.isAccepted()


def settle(widget: QWidget | None) -> None:
    """If `widget` is a step of an act, advance its clock and move the pointer onto it."""
    if isinstance(widget, StepButton):
        widget.check_place()
        gestures().on_pointer(QPointF(-1, -1))
        clock = gestures().clock
        left_s = widget.appeared_at + DEAD_FOR_S - clock()
        if left_s > 0:
            gestures().clock = lambda: clock() + left_s


def release_input() -> None:
    """Releases the keys and buttons that a test left down, moves the pointer to where it was at first, and resets the
    gestures.

    Qt keeps them for the whole process: the next test would select rows with Ctrl held.
    """
    if is_input_down():
        widget = QWidget()
        QTest.mouseRelease(widget, Qt.MouseButton.LeftButton)
        QTest.keyRelease(widget, Qt.Key.Key_Shift)
    if QCursor.pos() != _POINTER_AT_START:
        QCursor.setPos(_POINTER_AT_START)
    gestures().reset()
    assert not is_input_down()


def is_input_down() -> bool:
    """Whether Qt takes a modifier key or a mouse button as held."""
    nothing = Qt.KeyboardModifier.NoModifier, Qt.MouseButton.NoButton
    return (QGuiApplication.keyboardModifiers(), QGuiApplication.mouseButtons()) != nothing


def let_lay_out(root: QWidget) -> None:
    """Process events until nothing below `root` moves any more.

    What an event changes is laid out from child to parent, one step a turn; a scroll bar narrows what made it appear.
    """
    places = _places(root)
    for _ in range(12):
        QApplication.processEvents()
        for _ in range(12):  # as often as widgets are nested
            QApplication.sendPostedEvents()
        before, places = places, _places(root)
        if places == before:
            return
    raise AssertionError("the layout does not come to rest")


def _places(root: QWidget) -> list[QRect]:
    return [one.geometry() for one in visible_in(root)]


def press(qtbot: QtBot, widget: QWidget | None) -> None:
    """Clicks `widget`, which has to exist, deliberately."""
    assert widget is not None
    settle(widget)
    qtbot.mouseClick(widget, Qt.MouseButton.LeftButton)


def given(one: Thing | None) -> Thing:
    """What has to be there."""
    assert one is not None
    return one


def find(root: QObject, kind: type[Found], name: str = "") -> Found:
    """The child of this kind, and name if one is given, which has to exist."""
    found = root.findChild(kind, name) if name else root.findChild(kind)
    assert found is not None, name or kind
    return found


def notice_text(bar: NoticeBar) -> str:
    """The text of the notice shown, "" without one."""
    return "" if bar.notice is None else bar.notice.text
