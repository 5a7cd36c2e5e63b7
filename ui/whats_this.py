""" "What's this?" for every control, in the language in use."""

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cache
from typing import Final, cast

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWhatsThis, QWidget

from app.i18n import tr
from app.setting_texts import what_is
from protocol.catalogue import SETTINGS, Command
from ui.what_texts import ENTRIES

_OF_A_SETTING: Final[Mapping[str, Command]] = {
    pattern.format(command.name): command
    for command in SETTINGS
    for pattern in ("{}_wanted", "{}_stands", "{}_on", "{}_off", "profile_tick_{}", "profile_stands_{}")
}


def explain_all(root: QWidget) -> None:
    """Give every widget in `root` that the table or the catalogue knows its text; where it has none at all, a
    control says what its tooltip says."""
    for widget in (root, *root.findChildren(QWidget)):
        text = text_for(widget.objectName())
        if text:
            widget.setWhatsThis(text)
        elif not widget.whatsThis() and widget.focusPolicy() is not Qt.FocusPolicy.NoFocus:
            widget.setWhatsThis(widget.toolTip())


def text_for(name: str) -> str:
    """Of a control by its object's name, in the language in use; empty where neither the table nor the catalogue
    knows it."""
    command = _OF_A_SETTING.get(name)
    if command is not None:
        return what_is(command)
    english = _english(name)
    return tr(english) if english else ""


@cache
def _english(name: str) -> str:
    return next((entry.text for entry in ENTRIES if name and fits(entry.pattern, name)), "")


def fits(pattern: str, name: str) -> bool:
    """Whether one of the alternatives of a pattern stands for this name."""
    return any(fnmatchcase(name, one) for one in pattern.split("|"))


def say_what_has_focus(root: QWidget) -> bool:
    """Show the text of the control with the keyboard, or of the nearest thing around it; whether there is one."""
    explain_all(root)
    widget = cast("QWidget | None", root.focusWidget())
    around = widget
    while around is not None and widget is not None:
        if around.whatsThis():
            QWhatsThis.showText(widget.mapToGlobal(widget.rect().bottomLeft()), around.whatsThis(), widget)
            return True
        around = around.parentWidget()
    return False
