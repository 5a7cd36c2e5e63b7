"""Makes a control from one description: object name, texts in the language in use, shortcut, icon, role, slot."""

from typing import ClassVar, Final, TypeVar

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAccessible, QAction, QKeySequence
from PySide6.QtWidgets import QAbstractButton, QLabel, QToolButton, QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import Icon, icon
from ui.widgets.naming import named
from ui.widgets.step_button import StepButton

ICON_PX: Final = 16
TEXT_GAP_PX: Final = 2
"""Between the icon and the text of a button, beside the 4 px of Qt."""
_KEY: Final = "key"
Control = TypeVar("Control", bound=QWidget)


class _Translated:
    """A text inside another one, in the language in use."""

    def __init__(self, english: str) -> None:
        self._english = english

    def __format__(self, _spec: str) -> str:
        return tr(self._english)


def control(
    one: Control,
    texts: Texts,
    name: str,
    text: str = "",
    *,
    says: str = "",
    tip: str = "",
    key: str = "",
    picture: Icon | None = None,
    role: str = "",
    is_checkable: bool = False,
    slot: object = None,
) -> Control:
    """`one`, complete. `text`, `says` and `tip` are English. `says` is the accessible name; that of a button with a
    text is its text, which is what somebody who speaks to the computer says, and `says` describes it.

    `tip` only where it adds something to them. `key` is the shortcut that its tooltip names. `role` is one of the
    style sheet's. `slot` is called when a button is clicked, or when the press of a step counted.
    """
    named(one, name, role)
    if isinstance(one, QAbstractButton):
        if text:
            says, description = text, says
            if description not in ("", says):
                texts.bind(one.setAccessibleDescription, description)
        if is_checkable:
            one.setCheckable(True)
        if picture is not None:
            one.setIcon(icon(picture, is_on_primary=role == "primary"))
            one.setIconSize(QSize(ICON_PX + (TEXT_GAP_PX if text else 0), ICON_PX))
            if text and isinstance(one, QToolButton):
                one.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        if slot is not None:
            (one.chosen if isinstance(one, StepButton) else one.clicked).connect(slot)
    if text and isinstance(one, QAbstractButton | QLabel):
        texts.bind(one.setText, text)
    if says:
        texts.bind(one.setAccessibleName, says)
    if not tip and (key or not text) and isinstance(one, QAbstractButton):
        tip = text or says  # one text is enough: the tooltip adds the key, or stands for the text
    if key:
        one.setProperty(_KEY, key)
        texts.bind(one.setToolTip, "{tip} ({key})", tip=_Translated(tip), key=key)
    elif tip:
        texts.bind(one.setToolTip, tip)
    return one


def rename(button: QAbstractButton, texts: Texts, text: str) -> None:
    """Binds another text, in English, as the text and the accessible name of a button."""
    for setter in (button.setText, button.setAccessibleName):
        texts.bind(setter, text)


class ChoiceButton(QToolButton):
    """One of several beside each other, or none while nothing is known or wanted; a radio button to a screen reader.
    Which is pressed stays with whoever handles the clicks."""

    accessible_role: ClassVar = QAccessible.Role.RadioButton

    def __init__(self) -> None:
        super().__init__()
        self.setCheckable(True)


def name_of(one: QWidget) -> str:
    """What a control is called: by its accessible name, else by its text."""
    return one.accessibleName() or (one.text() if isinstance(one, QAbstractButton) else "")


class Shortcut(QAction):
    """A key of a page, by default for the click of a control. What it does is that control's accessible name."""

    def __init__(
        self, name: str, page: QWidget, of: QWidget, slot: object = None, *, keys: tuple[str, ...] = ()
    ) -> None:
        super().__init__(page)
        self.setObjectName(name)
        self.control = of
        self.setShortcuts([QKeySequence(key) for key in keys or (of.property(_KEY),)])
        self.triggered.connect(of.click if slot is None and isinstance(of, QAbstractButton) else slot)
        page.addAction(self)
