""" "What's this?" for every control, in the language in use."""

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cache
from typing import Final, cast

from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QWhatsThis, QWidget
from shiboken6 import isValid

from app.settings.setting_texts import what_is
from app.text.i18n import tr
from protocol.catalogue import SETTINGS, Command
from protocol.translatable import marked

WIDGETS_AT_ONCE: Final = 50
"""About 2 ms of work."""
_BREATH_MS: Final = 1
_QUESTIONS: Final = (QEvent.Type.QueryWhatsThis, QEvent.Type.WhatsThis)
_SAYS_TOOLTIP: Final = "says_tooltip"
_OF_A_SETTING: Final[Mapping[str, Command]] = {
    pattern.format(command.name): command
    for command in SETTINGS
    for pattern in ("{}_wanted", "{}_stands", "{}_on", "{}_off", "profile_tick_{}", "profile_stands_{}")
}
TEXTS: Final[Mapping[str, str]] = {
    "lock_button": marked("Standby at once: always allowed, never asked twice, sent before everything else."),
    "live_panel": marked("Dimmed with an age: stale. Hatched: never reported."),
    "*_threshold_state|*_trigger_state|freefall_*_state|serial_output_state":
        marked("“Verified” means written, asked for again, and equal."),
    "settings_write": marked("Sends each edited row once and reads it back; never to an ACTIVE module."),
    "verdict": marked("Void after a restart, a lost link, a change, or fifteen minutes."),
    "check_*_trigger_act": marked("After power-up the triggers' state is unknown; only enabling them sets it."),
    "tests_made_safe": marked("The test makes the module fire."),
    "act_*_ask|tests_*_ask": marked("Asks once more before anything is sent."),
    "act_*_go|tests_*_go": marked("Sends it once: never repeated, never kept for later."),
    "ritual_choose": marked("Arm, then hold for two seconds. Letting go, Esc or leaving the page sends nothing."),
    "ritual_arm": marked("Arms for ten seconds. Nothing is sent yet."),
    "ritual_hold": marked("Two seconds, by mouse or space bar. Letting go before sends nothing."),
    "flights_map": marked("Shaded: fires, but must not. Hatched: must fire, but is missed."),
}  # fmt: skip
"""English, marked, by object name: shell patterns with `|` between alternatives, of which the first match counts. Other
controls use their tooltip or accessible name; settings, checks and options of the simulated module have their own."""


class WhatsThis(QObject):
    """Sets the texts of all widgets in `root`: a few in each turn of the event loop, since screen readers use them too,
    and that of a queried widget at once."""

    def __init__(self, root: QWidget) -> None:
        super().__init__(root)
        self._root = root
        self._left: list[QWidget] = []
        self._timer = QTimer(self, interval=_BREATH_MS)
        self._timer.timeout.connect(self._continue)

    @property
    def is_under_way(self) -> bool:
        return self._timer.isActive()

    def begin(self) -> None:
        """Sets all texts again, in the language in use."""
        self._left = [self._root]
        self._timer.start()

    def ask(self) -> None:
        """Enters "What's this?" mode, in which the next click explains a control."""
        if not QWhatsThis.inWhatsThisMode():
            _program().installEventFilter(self)
            QWhatsThis.enterWhatsThisMode()

    def show_focus_help(self) -> bool:
        """Shows the text of the focused control or its nearest parent with one; returns whether there is any."""
        widget = cast("QWidget | None", self._root.focusWidget())
        around = widget
        while around is not None and widget is not None:
            explain(around)
            if around.whatsThis():
                QWhatsThis.showText(widget.mapToGlobal(widget.rect().bottomLeft()), around.whatsThis(), widget)
                return True
            around = around.parentWidget()
        return False

    def _continue(self) -> None:
        for _ in range(min(WIDGETS_AT_ONCE, len(self._left))):
            widget = self._left.pop()
            if isValid(widget):  # it may have been deleted since the last turn
                explain(widget)
                self._left += widget.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly)
        if not self._left:
            self._timer.stop()

    # Qt

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Filters the events of the application from `ask` until the click."""
        if event.type() == QEvent.Type.LeaveWhatsThisMode:
            _program().removeEventFilter(self)
        elif event.type() in _QUESTIONS and isinstance(watched, QWidget):
            explain(watched)
        return False


def _program() -> QCoreApplication:
    return cast("QCoreApplication", QCoreApplication.instance())  # exists as long as a window does


def explain(widget: QWidget) -> None:
    """Sets the text from the table or the catalogue, else from the tooltip or the accessible name."""
    text = text_for(widget.objectName())
    if text:
        widget.setWhatsThis(text)
    elif not widget.whatsThis() or widget.property(_SAYS_TOOLTIP):
        widget.setWhatsThis(widget.toolTip() or widget.accessibleName())
        widget.setProperty(_SAYS_TOOLTIP, True)


def text_for(name: str) -> str:
    """The text for an object name, in the language in use; "" where neither the table nor the catalogue has one."""
    command = _OF_A_SETTING.get(name)
    if command is not None:
        return what_is(command)
    english = _english(name)
    return tr(english) if english else ""


@cache
def _english(name: str) -> str:
    return next((text for pattern, text in TEXTS.items() if name and fits(pattern, name)), "")


def fits(pattern: str, name: str) -> bool:
    """Whether one of the alternatives of `pattern` matches `name`."""
    return any(fnmatchcase(name, one) for one in pattern.split("|"))
