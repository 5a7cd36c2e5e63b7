""" "What's this?" of every control: the text that it was made with, else that of what it is part of, else its
tooltip or name."""

from collections.abc import Iterator
from typing import Final, cast

from PySide6.QtCore import QCoreApplication, QEvent, QObject
from PySide6.QtWidgets import QWhatsThis, QWidget

_QUESTIONS: Final = (QEvent.Type.QueryWhatsThis, QEvent.Type.WhatsThis)
_SAYS_TOOLTIP: Final = "says_tooltip"


class WhatsThis(QObject):
    """Gives a control its text at the question."""

    def __init__(self, root: QWidget) -> None:
        super().__init__(root)
        self._root = root

    def ask(self) -> None:
        """Enters "What's this?" mode, in which the next click explains a control."""
        if not QWhatsThis.inWhatsThisMode():
            _program().installEventFilter(self)
            QWhatsThis.enterWhatsThisMode()

    def show_focus_help(self) -> bool:
        """Shows the text of the focused control, or of what it is part of; returns whether there is any."""
        widget = cast("QWidget | None", self._root.focusWidget())
        if widget is None:
            return False
        explain(widget)
        text = text_of(widget)
        if text:
            QWhatsThis.showText(widget.mapToGlobal(widget.rect().bottomLeft()), text, widget)
        return bool(text)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Filters the events of the application from `ask` until the click."""
        if event.type() == QEvent.Type.LeaveWhatsThisMode:
            _program().removeEventFilter(self)
        elif event.type() in _QUESTIONS and isinstance(watched, QWidget):
            explain(watched)
        return False


def _program() -> QCoreApplication:
    return cast("QCoreApplication", QCoreApplication.instance())  # exists as long as a window does


def _with_parents(widget: QWidget) -> Iterator[QWidget]:
    around: QWidget | None = widget
    while around is not None:
        yield around
        around = around.parentWidget()


def text_of(widget: QWidget) -> str:
    """Its own text, or that of what it is part of, as Qt shows it."""
    return next((text for one in _with_parents(widget) if (text := one.whatsThis())), "")


def explain(widget: QWidget) -> None:
    """Where neither a widget nor what it is part of was made with a text, the nearest with a tooltip or an accessible
    name gets that."""
    around = list(_with_parents(widget))
    if any(one.whatsThis() and not one.property(_SAYS_TOOLTIP) for one in around):
        return
    for one in around:
        one.setWhatsThis(one.toolTip() or one.accessibleName())
        one.setProperty(_SAYS_TOOLTIP, True)
        if one.whatsThis():
            return
