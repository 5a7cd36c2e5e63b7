"""Asks before a port is left or the window closes, where a module that may fire or edits would be left behind."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from ui.session.port import Port
from ui.session.ports import Ports
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice

if TYPE_CHECKING:
    from ui.shell.main_window import MainWindow


@dataclass(eq=False)
class _Wish:
    """A person wants to leave `ports`; then `proceed`."""

    proceed: Callable[[], object]
    ports: tuple[Port, ...]
    is_closing: bool = False
    is_opened_again: bool = False
    is_locking: bool = False


class Leaving(QObject):
    asked = Signal()  # There is another question, or none

    def __init__(self, window: "MainWindow", ports: Ports) -> None:
        super().__init__(window)
        self._window, self._ports = window, ports
        self._wish: _Wish | None = None
        ports.shown.connect(lambda _module: self.stay())  # what was asked was about the former one

    def may_close(self, close: Callable[[], object]) -> bool:
        """Whether the window may close now; else asks, and calls `close` where that is the answer."""
        wish = _Wish(close, self._ports.all, is_closing=True)
        if self._question(wish) is None:
            return True
        if self._wish is None or not self._wish.is_closing:  # else it is asked already, or LOCK is on its way
            self._ask(wish)
        return False

    def leave_port(self, proceed: Callable[[], object], *, is_opened_again: bool = False) -> None:
        """Calls `proceed`; asks before the ACTIVE module that is shown is left, or its edits would be lost."""
        self._ask(_Wish(proceed, (self._ports.current,), is_opened_again=is_opened_again))

    def stay(self) -> None:
        self._wish = None
        self.asked.emit()

    def notice(self) -> Notice | None:
        """The question, as long as there is something to ask about."""
        wish = self._wish
        question = None if wish is None else self._question(wish)
        if wish is not None and question is None and not wish.is_locking:
            self._wish = None
        return question

    def _ask(self, wish: _Wish) -> None:
        if self._question(wish) is None:
            self._leave(wish)
            return
        self._wish = wish
        self.asked.emit()
        bar = self._window.notice_bar
        button = bar.button("lock_and_leave") or bar.button("stay")
        if button is not None:
            button.setFocus()

    def _leave(self, wish: _Wish) -> None:
        self._wish = None
        for port in wish.ports:
            port.module.settings.revert()
            if wish.is_closing:
                port.interruptions.discard_drafts()
        wish.proceed()

    def _question(self, wish: _Wish) -> Notice | None:
        """Return one question about all that would be left behind; None where there is nothing."""
        is_closing = wish.is_closing
        count = sum(one.module.settings.count_unsent() for one in wish.ports)
        if is_closing:
            count += sum(one.interruptions.count_drafts() for one in wish.ports)
        parts = [tr("Settings not written: {count}.", count=count)] if count else []
        editor = self._window.findChild(QWidget, "profile_editor")
        if is_closing and editor is not None and editor.isWindowModified():
            parts.append(labelled(tr("Profile"), tr("Unsaved edits.")))
        # A module that is or may be ready to fire, and can still be locked. One that was lost can be locked no more,
        # but the program that could lock it when it is back is not closed without a word.
        is_risky = not wish.is_opened_again and any(
            (one.is_active and (one.is_open or is_closing)) or (one.is_open and one.lock.is_unproven)
            for one in wish.ports
        )
        stay, leave = Choice("stay", tr("Cancel"), self.stay), partial(self._leave, wish)
        if is_risky:
            risk = tr("Treat the module as ACTIVE: it does not report LOCKED.")
            if any(one.is_active for one in wish.ports):
                risk = tr("The module is ACTIVE: it fires also without this program.")
            parts.insert(0, risk)
            lock = Choice("lock_and_leave", tr("LOCK first"), partial(self._lock_first, wish), is_main=True)
            choices = [lock, Choice("leave_active", tr("Leave it ACTIVE"), leave, is_step=True), stay]
        elif parts:
            drop = Choice("drop_edits", tr("Discard edits"), leave, is_step=True)
            choices = [stay._replace(is_main=True), drop]
        else:
            return None
        return Notice(Meaning.ATTENTION, join_sentences(parts), tuple(choices), cause="leaving")

    def _lock_first(self, wish: _Wish) -> None:
        def on_locked() -> None:
            """Also later: not if it was cancelled meanwhile."""
            if self._wish is wish:
                wish.is_locking = False
                self._ask(wish)

        wish.is_locking = True
        press = self._ports.lock.press_all if wish.is_closing else wish.ports[0].lock.press
        press(then=on_locked)
