"""Notice across the window with a message and actions, instead of a dialog."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QLabel, QPushButton, QSizePolicy, QToolButton, QWidget

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import Meaning, Space
from ui.widgets.banner import Banner
from ui.widgets.controls import control
from ui.widgets.naming import named
from ui.widgets.step_button import StepButton, leave_focus

_ICON_PX: Final = 20


@dataclass(frozen=True, slots=True)
class Choice:
    """A button of a notice; `key` names it for tests and screen readers' users alike."""

    key: str
    text: str
    act: Callable[[], None]
    is_main: bool = False
    is_step: bool = False
    """It changes the module or loses data: it counts only a press that was meant for it."""
    is_shown: bool = True
    """Else it only keeps its place, for another step of the same act."""


@dataclass(frozen=True, slots=True)
class Notice:
    """Texts are in the language in use: make it again when that changes. `dismiss` adds a button to close it."""

    meaning: Meaning
    text: str
    choices: tuple[Choice, ...] = ()
    dismiss: Callable[[], None] | None = None


class NoticeBar(Banner):
    """Shows one notice, or is not there at all."""

    def __init__(self, texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__("notice_bar", "notice_icon", icon_px=_ICON_PX, parent=parent)
        self.notice: Notice | None = None
        self.picture.setFixedSize(QSize(_ICON_PX, _ICON_PX))
        self._text = named(QLabel(), "notice_text")
        self._text.setWordWrap(True)
        self._text.setTextFormat(Qt.TextFormat.PlainText)
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._dismiss = control(QToolButton(), texts, "notice_dismiss", says="Close",
                                picture=Icon.CROSS, role="quiet",
                                slot=self._close)  # fmt: skip
        policy = self._dismiss.sizePolicy()
        policy.setRetainSizeWhenHidden(True)  # no other button ever lies where it comes to lie
        self._dismiss.setSizePolicy(policy)
        self._buttons: list[QPushButton] = []
        self.row.setContentsMargins(Space.M, Space.XS, Space.M, Space.XS)
        self.row.addWidget(self._text, 1)
        self.row.addWidget(self._dismiss)

    def show_notice(self, notice: Notice | None) -> None:
        """Replace what is shown; None takes the bar away. The same notice again changes nothing."""
        if notice is None:
            self.notice = None
            leave_focus(self)
            self.hide()
            return
        if not self._is_same(notice):
            self._fill(notice)
        self.notice = notice
        self.show()

    def button(self, key: str) -> QPushButton | None:
        """The button of a choice that is shown."""
        return next((one for one in self._buttons if one.objectName() == f"notice_{key}"), None)

    def _is_same(self, notice: Notice) -> bool:
        old = self.notice
        return (
            old is not None
            and (old.meaning, old.text) == (notice.meaning, notice.text)
            and _buttons_of(old) == _buttons_of(notice)
        )

    def _fill(self, notice: Notice) -> None:
        if self.notice is None or _buttons_of(self.notice) != _buttons_of(notice):
            self._make_buttons(notice)
        self._text.setText(notice.text)
        self._dismiss.setVisible(notice.dismiss is not None)
        self.setAccessibleName(tr("Message: {text}", text=notice.text))
        self.show_meaning(notice.meaning, MEANING_ICONS[notice.meaning])

    def _make_buttons(self, notice: Notice) -> None:
        """Only where they are others: a new one under the pointer would swallow the click that is under way."""
        had_focus = next((one.objectName() for one in self._buttons if one.hasFocus()), None)
        leave_focus(self)
        for button in self._buttons:
            self.row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self._buttons = [self._make_button(choice, number) for number, choice in enumerate(notice.choices)]
        before: QWidget = self._text
        for number, button in enumerate(self._buttons):
            self.row.insertWidget(2 + number, button)
            button.setVisible(notice.choices[number].is_shown)
            self.setTabOrder(before, button)  # where it stands, not behind everything that was made earlier
            before = button
            if button.objectName() == had_focus:
                button.setFocus()

    def _make_button(self, choice: Choice, number: int) -> QPushButton:
        button = named(StepButton() if choice.is_step else QPushButton(), f"notice_{choice.key}")
        button.setText(choice.text)
        button.setAccessibleName(choice.text)
        if choice.is_main:
            button.setProperty("role", "primary")
        # By number: the act of the notice shown now, also where an equal one replaced it.
        pressed = button.chosen if isinstance(button, StepButton) else button.clicked
        pressed.connect(lambda: self._act(number))
        return button

    def _act(self, number: int) -> None:
        if self.notice is not None and number < len(self.notice.choices):
            self.notice.choices[number].act()

    def _close(self) -> None:
        if self.notice is not None and self.notice.dismiss is not None:
            self.notice.dismiss()


def _buttons_of(notice: Notice) -> list[tuple[str, str, bool, bool]]:
    return [(one.key, one.text, one.is_main, one.is_shown) for one in notice.choices]
