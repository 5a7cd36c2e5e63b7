"""Presses as a careful person makes them, for tests that are about something else."""

from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QApplication, QWidget

from ui.widgets.gestures import gestures
from ui.widgets.step_button import DEAD_FOR_S, StepButton


def settle(widget: QWidget | None) -> None:
    """If `widget` is a step of an act: half a second after it appeared where it stays, move the pointer onto it."""
    if isinstance(widget, StepButton):
        widget.check_place()
        gestures().on_pointer(QPointF(-1, -1))
        clock = gestures().clock
        left_s = widget.appeared_at + DEAD_FOR_S - clock()
        if left_s > 0:
            gestures().clock = lambda: clock() + left_s


def let_lay_out() -> None:
    """A question that was asked this moment: until its buttons lie where they are seen."""
    QApplication.processEvents()
