"""Notices: what a person has to know or to decide, in a bar instead of a dialog. The window's bar is at its foot."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QApplication, QFrame, QLabel, QPushButton, QSizePolicy, QToolButton, QWidget

from app.text.i18n import tr
from app.text.messages import labelled
from ui.style.icons import MEANING_ICONS, Icon, icon
from ui.style.theme import IconSize, Meaning, Space, is_text_large
from ui.widgets.controls import (
    ElidedLabel,
    IconLabel,
    control,
    in_column,
    in_row,
    named,
    retain_size,
    set_look,
    without_key,
)
from ui.widgets.step_button import FocusBack, StepButton, leave_focus


class Choice(NamedTuple):
    """A button of a notice. `key` is a part of its object name, `text` is in the language in use."""

    key: str
    text: str
    act: Callable[[], object]
    is_main: bool = False
    # Changes the module or loses data: a `StepButton`, which counts only deliberate presses.
    is_step: bool = False
    # A hidden button keeps its place for another step of the same act.
    is_shown: bool = True
    # A disabled one shows what will be possible; the text of the notice says when.
    is_enabled: bool = True


class Notice(NamedTuple):
    """`text` is in the language in use. `dismiss` adds a button to close it. `cause` tells a notice whose text changes
    from another one."""

    meaning: Meaning
    text: str
    choices: tuple[Choice, ...] = ()
    dismiss: Callable[[], object] | None = None
    cause: str = ""

    @property
    def key(self) -> str:
        return self.cause or self.text


class NoticeBar(QFrame):
    """Shows one notice whole, and leads to the others; hidden while there is none.

    That at the foot of the window fits its text into the height of its place, so that nothing around it moves.
    """

    changed = Signal()  # Another notice is shown, or none

    def __init__(self, *, is_foot: bool = False) -> None:
        super().__init__()
        named(self, "notice_bar", "notice-foot" if is_foot else "notice")
        self.hide()
        self.notice: Notice | None = None
        self.notices: Sequence[Notice] = ()
        # The notice to which a person went on, until it ends or a new one is graver.
        self._chosen = ""
        self._note = ""
        self._looks: list[tuple[str, str, bool, bool]] = []
        self._is_foot = is_foot
        self._focus = FocusBack(self)
        self._text = named(ElidedLabel() if is_foot else QLabel(), "notice_text")
        self._text.setWordWrap(True)
        if not is_foot:
            self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        vertical = QSizePolicy.Policy.Ignored if is_foot else QSizePolicy.Policy.Preferred
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, vertical)
        more = tr("More messages")
        self.more = control(QToolButton(), "notice_more", says=more, role="quiet", slot=self._show_next)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.more.hide()
        self._dismiss = control(
            QToolButton(), "notice_dismiss", says=tr("Close"), picture=Icon.CROSS, role="quiet", slot=self._close
        )
        retain_size(self._dismiss)  # so that no other button is ever in its place
        self._buttons: list[QPushButton] = []
        self._choices = in_row(spacing=Space.S)
        self._picture = IconLabel("notice_icon", IconSize.NOTICE, keeps_place=True)
        # Beside the buttons large text would have a word a line.
        is_parted = is_text_large() and not is_foot
        beside, below = ((), (in_row(1, self._choices),)) if is_parted else ((self._choices,), ())
        head = in_row(self._picture, (self._text, 1), *beside, self.more, self._dismiss, spacing=Space.S)
        in_column(head, *below, of=self, spacing=Space.XS, margins=(Space.S, 0 if is_foot else Space.XS))

    def show_notice(self, notice: Notice | None) -> None:
        self.show_notices([] if notice is None else [notice])

    def show_notices(self, notices: Sequence[Notice]) -> None:
        """The gravest first, which is shown whole unless a person went on to another one since it came."""
        if notices and notices[0].key not in {notice.key for notice in self.notices}:
            self._chosen = ""
        old, self.notices = self.notice, notices
        shown = next((notice for notice in notices if notice.key == self._chosen), None)
        notice = self.notice = shown or (notices[0] if notices else None)
        if notice is None:
            self._focus.leave(self._hide)
        else:
            # All that a person sees of them, but whether they are enabled.
            looks = [(one.key, one.text, one.is_main, one.is_shown) for one in notice.choices]
            if old is None or looks != self._looks:
                self._looks = looks
                self._make_buttons(notice)
            for button, choice in zip(self._buttons, notice.choices, strict=True):
                button.setEnabled(choice.is_enabled)
            others = [one for one in notices if one is not notice]
            # Beside three buttons of large text there is no room for both its sentence and the way to others.
            self.more.setVisible(bool(others) and not (is_text_large() and len(notice.choices) > 2))
            if others:
                self.more.setText(tr("{count} more", count=len(others)))
                self.more.setIcon(icon(MEANING_ICONS[others[0].meaning], others[0].meaning))
            self._dismiss.setVisible(notice.dismiss is not None)
            self._picture.show_icon(MEANING_ICONS[notice.meaning], notice.meaning)
            set_look(notice.meaning.value, self)
            self.show_note(self._note)
            said = labelled(tr("Message"), notice.text)
            if said != self.accessibleName():
                self.setAccessibleName(said)
            self.show()
        if (old is None) != (notice is None):
            self.changed.emit()

    def show_note(self, note: str) -> None:
        """Shows a passing message after the text of the notice."""
        self._note = note
        if self.notice is not None:
            # Not all notices end with a full stop.
            self._text.setText(" · ".join(filter(None, (self.notice.text, note))))

    def button(self, key: str) -> QPushButton | None:
        """The button of the choice with this key, if the notice shown has it."""
        buttons = self._buttons if self.notice is not None else ()
        return next((button for button in buttons if button.objectName() == f"notice_{key}"), None)

    def order_tabs(self) -> None:
        """Tab reaches the buttons from the text on, not after everything made earlier; the foot is at the end."""
        before: QWidget | None = self.window().previousInFocusChain() if self._is_foot else self._text
        for button in (*self._buttons, self.more, self._dismiss):
            if before is not None and button is not before:
                self.setTabOrder(before, button)
            before = button

    def _hide(self) -> None:
        leave_focus(self)  # else Qt gives it to the next button, which may be dangerous
        self.hide()

    def _close(self) -> None:
        if self.notice is not None and self.notice.dismiss is not None:
            self.notice.dismiss()

    def _show_next(self) -> None:
        keys = [notice.key for notice in self.notices]
        if self.notice is not None:
            self._chosen = keys[(keys.index(self.notice.key) + 1) % len(keys)]
            self.show_notices(self.notices)

    def _make_buttons(self, notice: Notice) -> None:
        """Called only where the choices differ: a new button under the pointer would swallow a click in progress."""
        had_focus = next((button.objectName() for button in self._buttons if button.hasFocus()), None)
        leave_focus(self)
        for button in self._buttons:
            self._choices.removeWidget(button)
            button.hide()
            button.deleteLater()
        self._buttons = []
        for number, choice in enumerate(notice.choices):
            button = named(StepButton() if choice.is_step else QPushButton(), f"notice_{choice.key}")
            button.setText(without_key(choice.text))
            button.setProperty("role", "primary" if choice.is_main else "")
            pressed = button.chosen if isinstance(button, StepButton) else button.clicked
            pressed.connect(partial(self._act, number))
            self._choices.addWidget(button)
            self._buttons.append(button)
            retain_size(button)
            button.setVisible(choice.is_shown)
            if button.objectName() == had_focus:
                button.setFocus()
        if had_focus is not None and QApplication.focusWidget() is None:
            self._focus.give()
        self.order_tabs()

    def _act(self, number: int, _is_checked: bool = False) -> None:
        """An equal notice may have replaced the one whose button this was made for, with other acts."""
        if self.notice is not None and number < len(self.notice.choices):
            self.notice.choices[number].act()
