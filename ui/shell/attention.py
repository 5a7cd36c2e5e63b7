"""The window's notices, the gravest first: one list, in which each notice belongs to its cause and goes with it.

What is asked before leaving; a LOCK that is not confirmed; what has fired; what was left ACTIVE; errors of the program;
the link; which module it is; what an ended conversation left; advice.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

from app import version
from app.diagnosis.causes import STEP_WORDS, NextStep
from app.diagnosis.link_state import Phase, link_text
from app.modules.names import what_differs
from app.procedures.act import Armed
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.system.uncaught import UncaughtError
from app.text.i18n import tr
from app.text.messages import join_names, join_sentences, labelled
from protocol.translatable import marked
from ui.session.left_active import LeftActiveWatch
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import Remainder, ShownModule, module_label
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

if TYPE_CHECKING:
    from ui.shell.main_window import MainWindow

# Longer than it takes a keyboard to repeat a key that is held, also on a busy computer, where X may call the first
# repetition another press.
AGAIN_S: Final = 2.0
_ASKS_WHY: Final = (Phase.SILENT, Phase.LATE, Phase.OFFLINE, Phase.LOST, Phase.FAILED)


@dataclass(eq=False)
class _Leaving:
    """A person wants to leave `ports`, and is asked about what would be left behind: a module that is ACTIVE, edits."""

    proceed: Callable[[], object]
    ports: tuple[Port, ...]
    is_closing: bool = False
    is_opened_again: bool = False
    is_locking: bool = False


class Attention(QObject):
    """Shows the notices of the window."""

    _failed = Signal(object)

    def __init__(self, window: "MainWindow", ports: Ports, left_active: LeftActiveWatch, armed: Armed) -> None:
        super().__init__(window)
        self._window, self._ports, self._left_active, self._armed = window, ports, left_active, armed
        self._bar = window.notice_bar
        # When somebody last tried to close the window.
        self._tried_at = -inf
        self._leaving: _Leaving | None = None
        self._watched: ShownModule | None = None
        # By key, until a person closes them.
        self._said: dict[str, Notice] = {}
        # Causes whose notice a person has closed, as long as they last.
        self._closed: set[str] = set()
        ports.shown.connect(self._on_another_module)
        for changed in (ports.any_changed, ports.ticked, left_active.changed):
            changed.connect(self.refresh)
        # Queued also in the window's thread: the error may have happened while painting.
        self._failed.connect(self._show_error, Qt.ConnectionType.QueuedConnection)

    def refresh(self) -> None:
        leaving = self._leaving
        if leaving is not None and not leaving.is_locking and self._question(leaving) is None:
            self._leaving = None  # what was asked about is over
        notices = list(self._notices())
        self._closed &= {notice.key for notice in notices}
        self._bar.show_notices([notice for notice in notices if notice.key not in self._closed])

    def say(self, notice: Notice) -> None:
        """Shows a notice until it is closed; it replaces one of the same cause."""

        def withdraw() -> None:
            self._said.pop(notice.key, None)
            self.refresh()

        self._said[notice.key] = notice._replace(dismiss=withdraw)
        self.refresh()

    def report(self, error: UncaughtError) -> None:
        """In any thread: disarms at once, and shows the error from the event loop. One place has one notice."""
        self._armed.act = None
        self._failed.emit(error)

    def _show_error(self, error: UncaughtError) -> None:
        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.thread}\n{error.details}")
            self._window.show_message(tr("Copied."))

        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary)
        choices = (Choice("copy_details", tr("Copy"), copy_details),)
        self.say(Notice(Meaning.ATTENTION, text, choices, cause=error.details))

    def _close(self, cause: str) -> None:
        self._closed.add(cause)
        self.refresh()

    def _on_another_module(self, module: ShownModule) -> None:
        """What a person has seen or was asked was about the former one."""
        if module is not self._watched:  # the same port may be chosen again
            self._watched = module
            module.changed.connect(self.refresh)
        self._leaving = None
        self._closed.clear()
        self.refresh()

    # The list

    def _notices(self) -> Iterator[Notice]:
        port, window = self._ports.current, self._window
        if self._leaving is not None and (question := self._question(self._leaving)) is not None:
            yield question
        if (locking := port.lock.notice()) is not None:
            yield locking._replace(cause="lock")
        every = self._ports.all
        others = [one for one in every if one is not port and one.lock.is_unproven and not one.lock.is_repeating]
        if others and window.shown_page != "fleet":  # which says it itself
            names = join_names(one.module.name or one.connection.port for one in others)
            text = tr("NOT reported, treat as ACTIVE: {names}", names=names)

            def lock_again() -> None:
                for one in others:
                    one.lock.press()

            yield Notice(Meaning.DANGER, text, (Choice("lock_others", tr("LOCK again"), lock_again),))
        yield from self._fired(port)
        left = self._left_active.notices()
        yield from (notice for notice in left if notice.meaning is Meaning.ATTENTION)
        yield from self._said.values()
        if (unrecorded := port.recording.state.trouble) is not None:
            show = Choice("recordings", tr("Recordings"), partial(window.go_to, "logs"))
            close = partial(self._close, "unrecorded")
            yield Notice(Meaning.ATTENTION, unrecorded.translated(), (show,), close, "unrecorded")
        link, phase = self._link(port), port.state.phase
        if link is not None and not (phase is Phase.CLOSED and window.is_choosing):
            yield link
        if (asked := self._which_module(port)) is not None:
            yield asked
        kept = port.interruptions
        for remainder in kept.remainders:
            if not remainder.is_trigger:
                yield self._remainder(port, remainder)
        if kept.last is not None and (link is None or phase is Phase.CLOSED):
            why = kept.last.translated()
            text = tr("Interrupted at {time}: {why}", time=_clock_time(kept.last_at), why=why)
            if kept.count > 1:
                since = _clock_time(kept.first_at)
                text = tr("Interrupted {count} times since {time}, last: {why}", count=kept.count, time=since, why=why)
            check = self._way("after_restart", tr("Pre-flight"), "preflight")
            yield Notice(Meaning.ATTENTION, text, check, kept.close, "interruptions")
        yield from (notice for notice in left if notice.meaning is not Meaning.ATTENTION)

    def _fired(self, port: Port) -> Iterator[Notice]:
        """It reports TRIGGERED, did so before its conversation ended, or may have fired before it restarted."""
        module = port.module
        choices = self._way("after_trigger", tr("Read the record"), "triggers", is_main=True)
        known = module.view.known("triggered", port.now_s)
        if port.is_open and known is not None and known.value is True and not module.is_fired_by_test:
            text = tr("The module has triggered: LOCK, read the record, pack, check again.")
            yield Notice(Meaning.DANGER, text, choices, partial(self._close, "triggered"), "triggered")

        def close(remainder: Remainder | None = None) -> None:
            if remainder is not None:
                port.interruptions.close_remainder(remainder)
            port.firing_doubt.is_to_be_told = False
            port.update_view()
            self.refresh()

        seen = [one for one in port.interruptions.remainders if one.is_trigger]
        for one in seen:
            who, when = module_label(one.module), _clock_time(one.at)
            text = tr("{module} reported TRIGGERED before {time}.", module=who, time=when)
            yield Notice(Meaning.DANGER, text, choices, partial(close, one))
        if not seen and port.firing_doubt.is_to_be_told:
            text = tr("The module may have fired before the restart: read the trigger records.")
            yield Notice(Meaning.DANGER, text, choices, close)

    def _link(self, port: Port) -> Notice | None:
        """The trouble of the link and the step that helps; None while the link is fine."""
        state = port.state
        if state.is_fine:
            return None
        words = link_text(state, port.now_s)
        is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
        parts = ["" if words.what == words.word else words.what, words.next_step]  # the top bar has the word
        if state.was_active and not is_calm:
            parts = [tr(LAST_HEARD_ACTIVE), parts[0], keep_away()]  # no more, so that nothing of it is elided
        steps = [] if words.step is None else [words.step]
        if state.phase in _ASKS_WHY:
            steps.append(NextStep.WHY)
        choices = [Choice(step.value, tr(STEP_WORDS[step]), partial(self._window.take_step, step)) for step in steps]
        if choices and not is_calm:
            choices[0] = choices[0]._replace(is_main=True)
        meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
        return Notice(meaning, join_sentences(parts), tuple(choices), cause=f"link {state.phase.value}")

    def _which_module(self, port: Port) -> Notice | None:
        """Where nothing speaks against a name, one press says it; else a second one is needed, beside what speaks
        against it. Neither is ever the default button."""
        module = port.module
        name = module.doubted_name or ("" if module.name else port.last_name)
        if not name or not module.can_be_named:
            return None
        against, known = module.what_speaks_against(name), module.remembered(name)
        parts = [tr("Is it {module}?", module=name)]
        parts += [tr("Against it: {what}.", what=what.translated()) for what in against]
        differs = [] if known is None else what_differs(known, module.view, module.now_s)
        if differs:
            parts.append(tr("Settings: {what}.", what="; ".join(text.translated() for text in differs)))

        def decline() -> None:
            module.doubted_name = port.last_name = ""
            port.update_view()

        said = marked("It is {module} all the same") if module.doubted_name else marked("It is {module}")
        yes = tr(said, module=name)
        same = Choice("name_same", yes, partial(module.name_it, name), is_step=True)
        meaning = Meaning.ATTENTION if against else Meaning.INFORMATION
        return Notice(meaning, join_sentences(parts), (same, Choice("name_other", tr("Another module"), decline)))

    def _remainder(self, port: Port, remainder: Remainder) -> Notice:
        """A report, or the edits of an ended conversation beside what the module holds now."""
        module, settings = port.module, port.module.settings
        who, when = module_label(remainder.module), _clock_time(remainder.at)
        close = partial(port.interruptions.close_remainder, remainder)
        cause = f"remainder {id(remainder)}"
        if remainder.text is not None:
            text = tr("{module}, interrupted {time}: {what}", module=who, time=when, what=remainder.text.translated())
            return Notice(Meaning.ATTENTION, text, (), close, cause)

        def take_over() -> None:
            if settings.can_edit:
                settings.fill(remainder.drafts or {})
                close()
                self._window.go_to("settings")

        what = settings.beside(remainder)
        text = tr("{module}, interrupted {time}, not written: {what}.", module=who, time=when, what=what)
        is_same = remainder.module in ("", module.name)
        if module.is_read and not is_same:
            text = join_sentences((text, tr("First say that it is {module}.", module=remainder.module)))
        is_possible = module.is_read and is_same and settings.can_edit
        take = Choice("take_over", tr("Take over"), take_over, is_enabled=is_possible)
        return Notice(Meaning.ATTENTION, text, (take,), close, cause)

    def _way(self, key: str, text: str, page: str, *, is_main: bool = False) -> tuple[Choice, ...]:
        """A button that leads to a page; none while that page is shown."""
        if self._window.shown_page == page:
            return ()
        return (Choice(key, text, partial(self._window.go_to, page), is_main=is_main),)

    # Leaving

    def may_close(self, close: Callable[[], object]) -> bool:
        """Whether the window may close now; else asks, and calls `close` where that is the answer.

        A second attempt to close while the question is shown is an answer too, unless it is of a double click or a key
        that is held.
        """
        now, before = self._ports.clock(), self._tried_at
        self._tried_at = now
        if self._leaving is not None and self._leaving.is_closing:
            return now - before >= AGAIN_S
        leaving = _Leaving(close, self._ports.all, is_closing=True)
        if self._question(leaving) is None:
            return True
        self._ask(leaving)
        return False

    def leave_port(
        self, proceed: Callable[[], object], *, port: Port | None = None, is_opened_again: bool = False
    ) -> None:
        """Calls `proceed`; asks before an ACTIVE module is left or edits would be lost. `port`: else the shown one."""
        self._ask(_Leaving(proceed, (port or self._ports.current,), is_opened_again=is_opened_again))

    def stay(self) -> None:
        self._leaving = None
        self.refresh()

    def _ask(self, leaving: _Leaving) -> None:
        if self._question(leaving) is None:
            self._leave(leaving)
            return
        self._leaving = leaving
        self.refresh()
        button = self._bar.button("lock_and_leave") or self._bar.button("stay")
        if button is not None:
            button.setFocus()

    def _leave(self, leaving: _Leaving) -> None:
        self._leaving = None
        for port in leaving.ports:
            port.module.settings.revert()
            if leaving.is_closing or port is not self._ports.current:
                port.interruptions.discard_drafts()
        leaving.proceed()

    def _question(self, leaving: _Leaving) -> Notice | None:
        """One question about all that would be left behind; None where there is nothing."""
        port, is_closing = leaving.ports[0], leaving.is_closing
        is_other = not is_closing and port is not self._ports.current
        count = sum(one.module.settings.count_unsent() for one in leaving.ports)
        if is_closing or is_other:
            count += sum(one.interruptions.count_drafts() for one in leaving.ports)
        parts = [tr("Settings not written: {count}.", count=count)] if count else []
        editor = self._window.findChild(QWidget, "profile_editor")
        if is_closing and editor is not None and editor.isWindowModified():
            parts.append(labelled(tr("Profile"), tr("Unsaved edits.")))
        # A module that is or may be ready to fire, and can still be locked. One that was lost can be locked no more,
        # but the program that could lock it when it is back is not closed without a word.
        is_risky = not leaving.is_opened_again and any(
            (one.is_active and (one.is_open or is_closing)) or (one.is_open and one.lock.is_unproven)
            for one in leaving.ports
        )
        stay, leave = Choice("stay", tr("Cancel"), self.stay), partial(self._leave, leaving)
        if is_risky:
            risk = tr("Treat the module as ACTIVE: it does not report LOCKED.")
            if any(one.is_active for one in leaving.ports):
                risk = tr("The module is ACTIVE: it fires also without this program.")
            parts.insert(0, risk)

            def lock_first() -> None:
                leaving.is_locking = True
                press = self._ports.lock.press_all if is_closing else port.lock.press
                press(then=on_locked)

            def on_locked() -> None:
                """Also later: not if it was cancelled meanwhile."""
                if self._leaving is leaving:
                    leaving.is_locking = False
                    self._ask(leaving)

            lock = Choice("lock_and_leave", tr("LOCK first"), lock_first, is_main=True)
            choices = [lock, Choice("leave_active", tr("Leave it ACTIVE"), leave, is_step=True), stay]
        elif parts:
            drop = Choice("drop_edits", tr("Discard edits"), leave, is_step=True)
            choices = [stay._replace(is_main=True), drop]
        else:
            return None
        text = join_sentences(parts)
        if is_other:
            text = labelled(port.module.name or port.connection.port, text)
        return Notice(Meaning.ATTENTION, text, tuple(choices), cause="leaving")


def _clock_time(at: float) -> str:
    """Of the day, such as 10:02; `at` in seconds since 1970."""
    return time.strftime("%H:%M", time.localtime(at))
