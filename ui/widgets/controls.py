"""Makes a control from one description: object name, texts, shortcut, icon, role, slot."""

from collections.abc import Callable
from typing import ClassVar, TypeVar

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QAccessible, QKeySequence, QShortcut
from PySide6.QtWidgets import QAbstractButton, QToolButton, QWidget

from app.text.sentences import in_brackets
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import IconSize
from ui.widgets.step_button import StepButton

Named = TypeVar("Named", bound=QObject)


def named(widget: Named, name: str, role: str = "") -> Named:
    """Sets the object name of `widget`, and its role in the style sheet; returns it."""
    widget.setObjectName(name)
    if role:
        widget.setProperty("role", role)
    return widget


def set_role(widget: QWidget, role: str) -> None:
    """Changes the role of `widget` in the style sheet, and the colour of a button's picture with it."""
    if (widget.property("role") or "") != role:
        widget.setProperty("role", role)
        picture = widget.property("picture")
        if isinstance(widget, QAbstractButton) and picture is not None:
            widget.setIcon(icon(picture, is_on_primary=role == "primary"))
        widget.style().unpolish(widget)
        widget.style().polish(widget)


def set_look(look: str, *widgets: QWidget) -> None:
    """Changes what the style sheet makes of a value or a state: "danger", "stale", …; "" is plain."""
    for widget in widgets:
        if (widget.property("look") or "") != look:
            widget.setProperty("look", look)
            widget.style().polish(widget)


Control = TypeVar("Control", bound=QWidget)


def control(
    widget: Control,
    name: str,
    *,
    text: str = "",
    says: str = "",
    tip: str = "",
    key: str = "",
    keys: str = "",
    picture: Icon | None = None,
    role: str = "",
    is_checkable: bool = False,
    slot: object = None,
) -> Control:
    """Sets up `widget` and returns it. All texts are in the language in use.

    `text` is for a tool button, whose constructor takes none. `says` is the accessible name; a button with a text has
    that text as its name, which is what users of voice control say, and `says` describes it. `tip` is needed only where
    it adds something. `keys`, such as "F5; Ctrl+R" press it, see `Shortcut`; the tooltip names the first, or a `key`
    that something else handles. `role` is one of the style sheet's. `slot` is called when a button is clicked, or when
    the press of a `StepButton` counted.
    """
    named(widget, name, role)
    if keys:
        key = keys.partition(";")[0]
        Shortcut(widget, keys)
    if isinstance(widget, QAbstractButton):
        if text:
            widget.setText(text)
        text = widget.text()
        if is_checkable:
            widget.setCheckable(True)
        if picture is not None:
            widget.setProperty("picture", picture)
            widget.setIcon(icon(picture, is_on_primary=role == "primary"))
            set_icon_size(widget, IconSize.TEXT)
            if text and isinstance(widget, QToolButton):
                widget.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        if slot is not None:
            (widget.chosen if isinstance(widget, StepButton) else widget.clicked).connect(slot)
        if not tip and (key or not text):
            tip = text or says
    if text:
        widget.setAccessibleDescription(says)
    elif says:
        widget.setAccessibleName(says)
    if key:
        widget.setProperty("key", key)
        tip += in_brackets(key)
    if tip:
        widget.setToolTip(tip)
    return widget


class ChoiceButton(QToolButton):
    """One of several side by side, of which none may be checked; a radio button to screen readers. Whoever handles the
    clicks unchecks the others."""

    accessible_role: ClassVar = QAccessible.Role.RadioButton

    def __init__(self) -> None:
        super().__init__()
        self.setCheckable(True)


def without_key(text: str) -> str:
    """Of a button or an action, which takes "&" for the mark of a key."""
    return text.replace("&", "&&")


def name_of(widget: QWidget) -> str:
    """The accessible name of a control, else its text."""
    return widget.accessibleName() or (widget.text() if isinstance(widget, QAbstractButton) else "")


class Shortcut(QShortcut):
    """Clicks a control that is in sight and enabled, or gives a field the focus, by its keys; or calls `slot` while
    `holder` is in sight. It is described by the accessible name of the control."""

    def __init__(
        self, of: QWidget, keys: str, slot: Callable[[], object] | None = None, *, holder: QWidget | None = None
    ) -> None:
        super().__init__(holder or of)
        self.setObjectName(f"{of.objectName()}_key")
        self.control, self._slot = of, slot
        self.setAutoRepeat(False)  # the next step needs another press
        self.setKeys(QKeySequence.listFromString(keys))
        self.activated.connect(self._press)

    def _press(self) -> None:
        if not self.control.isEnabled():
            return
        if self._slot is not None:
            self._slot()
        elif isinstance(self.control, QAbstractButton):
            self.control.click()
        else:
            self.control.setFocus(Qt.FocusReason.ShortcutFocusReason)
