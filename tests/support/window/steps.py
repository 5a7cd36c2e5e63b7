"""Prepares clicks on the steps of an act, which count only after 0.5 s."""

from PySide6.QtCore import QPointF, Qt
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from ui.widgets.gestures import gestures
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import DEAD_FOR_S, StepButton


def settle(widget: QWidget | None) -> None:
    """If `widget` is a step of an act, advance its clock and move the pointer onto it."""
    if isinstance(widget, StepButton):
        widget.check_place()
        gestures().on_pointer(QPointF(-1, -1))
        clock = gestures().clock
        left_s = widget.appeared_at + DEAD_FOR_S - clock()
        if left_s > 0:
            gestures().clock = lambda: clock() + left_s


def let_lay_out() -> None:
    """Process events, so that new buttons are laid out."""
    QApplication.processEvents()


def press(qtbot: QtBot, widget: QWidget | None) -> None:
    """Clicks `widget`, which has to exist, deliberately."""
    assert widget is not None
    settle(widget)
    qtbot.mouseClick(widget, Qt.MouseButton.LeftButton)


def notice_text(bar: NoticeBar) -> str:
    """The text of the notice shown, "" without one."""
    return "" if bar.notice is None else bar.notice.text
