"""Roles and names for screen readers, of widgets that Qt knows nothing about; and what is told them at once.

Qt gives a widget of our own the role of a container, which screen readers skip. Here it has the role that its class
names in `accessible_role`; a container with a name is a group.

The name is asked for when somebody wants to know it, so it may hold a measured value or an age. A change of it is told
only where Qt's own property changes: see `Spoken`.
"""

from functools import cache
from typing import Final, cast

from PySide6.QtCore import QObject
from PySide6.QtGui import QAccessible, QAccessibleActionInterface, QAccessibleAnnouncementEvent, QAccessibleInterface
from PySide6.QtWidgets import QAbstractButton, QAccessibleWidget, QApplication, QFrame, QScrollArea, QWidget

_CONTAINERS: Final = (QWidget, QFrame, QScrollArea)
"""What Qt's own role says nothing of."""


class _Accessible(QAccessibleWidget):
    def text(self, kind: QAccessible.Text) -> str:
        widget: QWidget | None = self.widget()
        name = widget.accessibleName() if kind is QAccessible.Text.Name and widget is not None else ""
        return name or super().text(kind)


class _Leaf(_Accessible):
    """A picture or a value: its parts are nothing of their own."""

    def childCount(self) -> int:
        return 0


class _Choice(_Accessible):
    """A button with a state."""

    def text(self, kind: QAccessible.Text) -> str:
        return super().text(kind) or (self._button.text() if kind is QAccessible.Text.Name else "")

    def state(self) -> QAccessible.State:
        state = super().state()
        state.checkable, state.checked = True, self._button.isChecked()
        return state

    def actionNames(self) -> list[str]:
        return [QAccessibleActionInterface.pressAction(), *super().actionNames()]

    def doAction(self, name: str) -> None:
        if name == QAccessibleActionInterface.pressAction():
            self._button.click()
        else:
            super().doAction(name)

    @property
    def _button(self) -> QAbstractButton:
        return cast("QAbstractButton", self.widget())


class _Container(_Accessible):
    """A group as soon as it has a name. What is scrolled is a section: of a group all labels are read at once."""

    def role(self) -> QAccessible.Role:
        if isinstance(self.widget(), QScrollArea):
            return QAccessible.Role.Section
        return QAccessible.Role.Grouping if self.text(QAccessible.Text.Name) else QAccessible.Role.Client


_KINDS: Final[dict[QAccessible.Role, type[_Accessible]]] = {
    QAccessible.Role.Chart: _Leaf,
    QAccessible.Role.StaticText: _Leaf,
    QAccessible.Role.RadioButton: _Choice,
}


def _make(class_name: str, widget: QObject) -> QAccessibleInterface | None:
    """Called by Qt for the class of `widget` and all those above it, until it gets an answer."""
    if not isinstance(widget, QWidget) or type(widget).__name__ != class_name:
        return None
    role: QAccessible.Role | None = getattr(widget, "accessible_role", None)
    if role is not None:
        return _KINDS.get(role, _Accessible)(widget, role)
    of_qt = next(kind for kind in type(widget).__mro__ if kind.__module__.startswith("PySide6."))
    return _Container(widget) if of_qt in _CONTAINERS else None


class Spoken:
    """A part of a widget's class: what it says may tick or be measured."""

    _spoken = ""

    def say(self, text: str, *, name: str = "") -> None:
        """Lets screen readers say `text`. `name` is the part of it that neither ticks nor is measured: they learn at
        once when that changes, of the rest when they ask."""
        self._spoken = text
        widget = cast("QWidget", self)
        if QWidget.accessibleName(widget) != (name or text):
            widget.setAccessibleName(name or text)

    def accessibleName(self) -> str:
        """Whole, as a screen reader gets it."""
        return self._spoken or QWidget.accessibleName(cast("QWidget", self))


@cache
def install_accessible_roles() -> None:
    """Once for the application; before anybody asks."""
    QAccessible.installFactory(_make)


_POLITENESS = QAccessible.AnnouncementPoliteness


def announce(text: str, *, is_urgent: bool = False) -> None:
    """For events only, not for values that change all the time. `text` is in the language in use. `is_urgent`: it
    interrupts what is being read."""
    visible = (window for window in QApplication.topLevelWidgets() if window.isVisible())
    speaker = QApplication.activeWindow() or next(visible, None)
    if text and speaker is not None:
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
