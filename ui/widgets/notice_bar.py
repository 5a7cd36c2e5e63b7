"""Notices: what a person has to know or to decide, in a bar instead of a dialog. The window's bar is at its foot, a
page's bar says what came of its own work."""

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QSizePolicy, QToolButton, QWidget

from app.text.i18n import tr
from app.text.messages import labelled
from ui.style.icons import MEANING_ICONS, Icon, icon
from ui.style.theme import IconSize, Space, is_text_large
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
from ui.widgets.notices import Choice, Notice
from ui.widgets.step_button import FocusBack, StepButton, leave_focus

_PASSES_AFTER_MS = 6000


class NoticeBar(QFrame):
    """Shows one notice, and leads to the others, which it counts, or what passes; hidden while there is neither. One
    that `is_foot` fits its text into its place, so that nothing around it moves."""

    def __init__(self, *, is_foot: bool = False) -> None:
        super().__init__()
        named(self, "notice_bar", "notice-foot" if is_foot else "notice")
        self.notices: Sequence[Notice] = ()
        # That of `notices` which is shown.
        self.notice: Notice | None = None
        # The key of that to which a person went on, until it ends or a new one is graver.
        self._chosen = ""
        # What is shown beside the notice for a few seconds.
        self.passing = ""
        self._is_foot = is_foot
        self._focus = FocusBack(self)
        self._picture = IconLabel("notice_icon", IconSize.NOTICE, keeps_place=True)
        self._text = named(ElidedLabel() if is_foot else QLabel(), "notice_text")
        self._text.setWordWrap(True)
        vertical = QSizePolicy.Policy.Ignored if is_foot else QSizePolicy.Policy.Preferred
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, vertical)
        if not is_foot:
            self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.more = control(QToolButton(), "notice_more", says=tr("More messages"), role="quiet", slot=self._show_next)
        self.more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._dismiss = control(
            QToolButton(), "notice_dismiss", says=tr("Close"), picture=Icon.CROSS, role="quiet", slot=self._close
        )
        self._buttons: list[QPushButton] = []
        self._row = in_row(spacing=Space.S)
        # Beside the buttons large text would have a word a line.
        is_parted = is_text_large() and not is_foot
        beside, below = ((), (in_row(1, self._row),)) if is_parted else ((self._row,), ())
        head = in_row(self._picture, (self._text, 1), *beside, self.more, self._dismiss, spacing=Space.S)
        in_column(head, *below, of=self, spacing=Space.XS, margins=(Space.S, 0 if is_foot else Space.XS))
        self._passing_end = QTimer(self, singleShot=True, interval=_PASSES_AFTER_MS)
        self._passing_end.timeout.connect(lambda: self.show_passing(""))
        self.hide()

    def show_notices(self, notices: Sequence[Notice]) -> None:
        """The gravest first, which is shown unless a person went on to another one since it came."""
        if notices and notices[0].key not in {notice.key for notice in self.notices}:
            self._chosen = ""
        former, self.notices = self.notice, notices
        chosen = next((notice for notice in notices if notice.key == self._chosen), None)
        self.notice = chosen or (notices[0] if notices else None)
        self._show(() if former is None else former.choices)

    def show_passing(self, text: str) -> None:
        self.passing = text
        self._say()
        if text:
            self._passing_end.start()

    def button(self, key: str) -> QPushButton | None:
        """The button of the choice with this key, if the notice shown has it."""
        return next((button for button in self._buttons if button.objectName() == f"notice_{key}"), None)

    def order_tabs(self) -> None:
        """Tab reaches the buttons from the text on, not after everything made earlier; the foot is at the end."""
        before: QWidget | None = self.window().previousInFocusChain() if self._is_foot else self._text
        for button in (*self._buttons, self.more, self._dismiss):
            if before is not None and button is not before:
                self.setTabOrder(before, button)
            before = button

    def _show(self, former: tuple[Choice, ...]) -> None:
        """`former`: the choices whose buttons there are."""
        notice = self.notice
        choices = () if notice is None else notice.choices
        if _looks(choices) != _looks(former):
            self._make_buttons(choices)
        for button, choice in zip(self._buttons, choices, strict=True):
            button.setEnabled(choice.is_enabled)
        others = [one for one in self.notices if one is not notice]
        self.more.setVisible(bool(others))
        if others:
            self.more.setText(f"+{len(others)}" if is_text_large() else tr("{count} more", count=len(others)))
            self.more.setIcon(icon(MEANING_ICONS[others[0].meaning], others[0].meaning))
        # So that no other button is ever in its place; beside three buttons of large text there is no room for it.
        retain_size(self._dismiss, is_kept=not (is_text_large() and len(choices) > 2))
        self._dismiss.setVisible(notice is not None and notice.dismiss is not None)
        self._picture.setVisible(notice is not None)
        if notice is not None:
            self._picture.show_icon(MEANING_ICONS[notice.meaning], notice.meaning)
        set_look("" if notice is None else notice.meaning.value, self)
        self._say()

    def _say(self) -> None:
        text = "" if self.notice is None else self.notice.text
        # Not all notices end with a full stop.
        self._text.setText(" · ".join(filter(None, (text, self.passing))))
        said = labelled(tr("Message"), text) if text else tr("Message")
        if said != self.accessibleName():
            self.setAccessibleName(said)
        if self._text.text():
            self.show()
        else:
            self._focus.leave(self._leave)

    def _leave(self) -> None:
        leave_focus(self)  # else Qt gives it to the next button, which may be dangerous
        self.hide()

    def _close(self) -> None:
        if self.notice is not None and self.notice.dismiss is not None:
            self.notice.dismiss()

    def _show_next(self) -> None:
        if self.notice is not None:
            keys = [notice.key for notice in self.notices]
            self._chosen = keys[(keys.index(self.notice.key) + 1) % len(keys)]
            self.show_notices(self.notices)

    def _make_buttons(self, choices: tuple[Choice, ...]) -> None:
        """Called only where the choices differ: a new button under the pointer would swallow a click in progress."""
        had_focus = next((button.objectName() for button in self._buttons if button.hasFocus()), None)
        leave_focus(self)
        for button in self._buttons:
            self._row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self._buttons = []
        for number, choice in enumerate(choices):
            button = named(StepButton() if choice.is_step else QPushButton(), f"notice_{choice.key}")
            button.setText(without_key(choice.text))
            button.setProperty("role", "primary" if choice.is_main else "")
            pressed = button.chosen if isinstance(button, StepButton) else button.clicked
            pressed.connect(partial(self._act, number))
            self._row.addWidget(button)
            self._buttons.append(button)
            retain_size(button)
            button.setVisible(choice.is_shown)
        same = next((button for button in self._buttons if button.objectName() == had_focus), None)
        if same is not None:
            same.setFocus()
        elif had_focus is not None:
            self._focus.give()
        self.order_tabs()

    def _act(self, number: int, _is_checked: bool = False) -> None:
        """An equal notice may have replaced the one whose button this was made for, with other acts."""
        if self.notice is not None and number < len(self.notice.choices):
            self.notice.choices[number].act()


def _looks(choices: tuple[Choice, ...]) -> list[tuple[str, str, bool, bool, bool]]:
    """Return all that a person sees of them, but whether they are enabled."""
    return [(one.key, one.text, one.is_main, one.is_step, one.is_shown) for one in choices]
