"""The window's notices, the gravest first: one list, in which each notice belongs to its cause and goes with it.

What is asked before leaving; a LOCK that is not confirmed; what has fired; what was left ACTIVE; errors of the program;
the link; what an ended conversation left; which module it is; advice.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QGuiApplication

from app import version
from app.diagnosis.causes import STEP_WORDS, NextStep
from app.diagnosis.link_state import LinkState, Phase, link_text
from app.procedures.act import Armed
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.system.uncaught import UncaughtError
from app.text.i18n import tr
from app.text.messages import UserMessage, join_names, join_sentences, labelled
from ui.session.interruptions import Remainder, RemainderKind
from ui.session.left_active import LeftActiveWatch
from ui.session.name_question import NameQuestion
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule, module_label
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar

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

    def __init__(self, window: "MainWindow", ports: Ports, left_active: LeftActiveWatch) -> None:
        super().__init__(window)
        self._window, self._ports, self._left_active = window, ports, left_active
        self._bar: NoticeBar = window.notice_bar
        # When somebody last tried to close the window.
        self._tried_at = -inf
        self._leaving: _Leaving | None = None
        self._name_question = NameQuestion(ports)
        # By key, until a person closes them.
        self._said: dict[str, Notice] = {}
        # Causes whose notice a person has closed, as long as they last.
        self._closed: set[str] = set()
        ports.shown.connect(self._on_another_module)
        for changed in (ports.any_changed, ports.ticked, self._name_question.changed, left_active.changed):
            changed.connect(self.refresh)
        for port in ports.all:
            port.interruptions.changed.connect(self.refresh)
        ports.added.connect(lambda port: port.interruptions.changed.connect(self.refresh))

    def refresh(self) -> None:
        leaving = self._leaving
        if leaving is not None and not leaving.is_locking and self._leaving_notice(leaving) is None:
            self._leaving = None  # what was asked about is over
        notices = list(self._notices())
        self._closed &= {notice.key for notice in notices}
        self._bar.show_notices([notice for notice in notices if notice.key not in self._closed])

    def say(self, notice: Notice) -> None:
        """Shows a notice until it is closed; it replaces one of the same cause."""
        self._said[notice.key] = notice._replace(dismiss=notice.dismiss or partial(self.withdraw, notice.key))
        self.refresh()

    def withdraw(self, key: str) -> None:
        self._said.pop(key, None)
        self.refresh()

    def _close(self, cause: str) -> None:
        self._closed.add(cause)
        self.refresh()

    def _on_another_module(self, _module: ShownModule) -> None:
        """What a person has seen or was asked was about the former one."""
        self._leaving = None
        self._closed.clear()
        self.refresh()

    def _notices(self) -> Iterator[Notice]:
        port = self._ports.current
        state = port.state
        if self._leaving is not None and (question := self._leaving_notice(self._leaving)) is not None:
            yield question
        yield from self._lock_notices()
        yield from self._fired_notices(port)
        left = self._left_active.notices()
        yield from (notice for notice in left if notice.meaning is Meaning.ATTENTION)
        yield from self._said.values()
        unrecorded = port.recording.state.trouble
        if unrecorded is not None:
            show = Choice("recordings", tr("Recordings"), partial(self._window.go_to, "logs"))
            close = partial(self._close, "unrecorded")
            yield Notice(Meaning.ATTENTION, unrecorded.translated(), (show,), close, "unrecorded")
        link = self._link_notice(state, port.now_s)
        if link is not None and not (state.phase is Phase.CLOSED and self._window.is_choosing):
            yield link
        if (asked := self._name_question.notice()) is not None:
            yield asked
        for remainder in port.interruptions.remainders:
            if remainder.kind is not RemainderKind.TRIGGERED:
                yield self._remainder_notice(port, remainder)
        if port.interruptions.last is not None and (link is None or state.phase is Phase.CLOSED):
            yield self._interruptions_notice(port, port.interruptions.last)
        yield from (notice for notice in left if notice.meaning is not Meaning.ATTENTION)

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
        if self._leaving_notice(leaving) is None:
            return True
        self._ask(leaving)
        return False

    def leave_port(
        self, proceed: Callable[[], object], *, port: Port | None = None, is_opened_again: bool = False
    ) -> None:
        """Calls `proceed`; asks before an ACTIVE module is left or edits would be lost. `port`: else the shown one."""
        self._ask(_Leaving(proceed, (port or self._ports.current,), is_opened_again=is_opened_again))

    def stay(self) -> None:
        """Cancels leaving; nothing is sent."""
        self._leaving = None
        self.refresh()

    def _ask(self, leaving: _Leaving) -> None:
        """Asks what is to be asked; else leaves."""
        if self._leaving_notice(leaving) is None:
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
            port.module.discard_edits()
            if leaving.is_closing or port is not self._ports.current:
                port.interruptions.discard_drafts()
        leaving.proceed()

    def _lock_first(self, leaving: _Leaving) -> None:
        leaving.is_locking = True

        def on_locked() -> None:
            """Also later: not if it was cancelled meanwhile."""
            if self._leaving is leaving:
                leaving.is_locking = False
                self._ask(leaving)

        if leaving.is_closing:
            self._ports.lock.press_all(then=on_locked)
        else:
            leaving.ports[0].lock.press(then=on_locked)

    def _leaving_notice(self, leaving: _Leaving) -> Notice | None:
        """One question about all that would be left behind; None where there is nothing."""
        stays = Choice("stay", tr("Cancel"), self.stay)
        leave = partial(self._leave, leaving)
        text = self._unsent_text(leaving)
        if _is_risky(leaving):
            risk = tr("Treat the module as ACTIVE: it does not report LOCKED.")
            if any(port.is_active for port in leaving.ports):
                risk = tr("The module is ACTIVE: it fires also without this program.")
            text = join_sentences((risk, text))
            choices: tuple[Choice, ...] = (
                Choice("lock_and_leave", tr("LOCK first"), partial(self._lock_first, leaving), is_main=True),
                Choice("leave_active", tr("Leave it ACTIVE"), leave, is_step=True),
                stays,
            )
        elif text:
            drop = Choice("drop_edits", tr("Discard edits"), leave, is_step=True)
            choices = (stays._replace(is_main=True), drop)
        else:
            return None
        port = leaving.ports[0]
        if not leaving.is_closing and port is not self._ports.current:
            text = labelled(port.module.name or port.connection.port, text)
        return Notice(Meaning.ATTENTION, text, choices, cause="leaving")

    def _unsent_text(self, leaving: _Leaving) -> str:
        """Of the edits that would be lost; "" where there are none."""
        count = sum(port.module.count_unsent() for port in leaving.ports)
        if leaving.is_closing or leaving.ports[0] is not self._ports.current:
            count += sum(port.interruptions.count_drafts() for port in leaving.ports)
        return tr("Settings not written: {count}.", count=count) if count else ""

    # The link

    def _link_notice(self, state: LinkState, now: float) -> Notice | None:
        """The trouble of the link and the step that helps; None while the link is fine."""
        if state.is_fine:
            return None
        words = link_text(state, now)
        is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
        parts = ["" if words.what == words.word else words.what, words.next_step]  # the top bar has the word
        if state.was_active and not is_calm:
            parts = [tr(LAST_HEARD_ACTIVE), parts[0], keep_away()]  # no more, so that nothing of it is elided
        steps = [] if words.step is None else [words.step]
        if state.phase in _ASKS_WHY:
            steps.append(NextStep.WHY)
        choices = tuple(
            Choice(step.value, tr(STEP_WORDS[step]), partial(self._window.take_step, step), is_main=is_main)
            for step, is_main in zip(steps, (not is_calm, False), strict=False)
        )
        meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
        return Notice(meaning, join_sentences(parts), choices, cause=f"link {state.phase.value}")

    # LOCK, and what has fired

    def _lock_notices(self) -> Iterator[Notice]:
        """Of the shown module, and of others which do not report LOCKED; Fleet says that itself."""
        here = self._ports.current
        if (notice := here.lock.notice()) is not None:
            yield notice._replace(cause="lock")
        ports = [port for port in self._ports.all if port is not here]
        ports = [port for port in ports if port.lock.is_unproven and not port.lock.is_repeating]
        if not ports or self._window.shown_page == "fleet":
            return
        names = join_names(port.module.name or port.connection.port for port in ports)

        def press() -> None:
            for port in ports:
                port.lock.press()

        again = Choice("lock_others", tr("LOCK again"), press)
        yield Notice(Meaning.DANGER, tr("NOT reported, treat as ACTIVE: {names}", names=names), (again,))

    def _fired_notices(self, port: Port) -> Iterator[Notice]:
        """It reports TRIGGERED, did so before its conversation ended, or may have fired before it restarted."""
        module = port.module
        choices = self._page_choices("after_trigger", tr("Read the record"), "triggers", is_main=True)
        known = module.view.known("triggered", port.now_s)
        if port.is_open and known is not None and known.value is True and not module.is_fired_by_test:
            text = tr("The module has triggered: LOCK, read the record, pack, check again.")
            yield Notice(Meaning.DANGER, text, choices, partial(self._close, "triggered"), "triggered")
        seen = [one for one in port.interruptions.remainders if one.kind is RemainderKind.TRIGGERED]
        for remainder in seen:
            who, when = module_label(remainder.module), _clock_time(remainder.at)
            text = tr("{module} reported TRIGGERED before {time}.", module=who, time=when)
            yield Notice(Meaning.DANGER, text, choices, partial(self._close_triggered, port, remainder))
        if not seen and port.firing_doubt.is_to_be_told:
            text = tr("The module may have fired before the restart: read the trigger records.")
            yield Notice(Meaning.DANGER, text, choices, partial(self._close_doubt, port))

    def _close_triggered(self, port: Port, remainder: Remainder) -> None:
        port.interruptions.close_remainder(remainder)
        self._close_doubt(port)

    def _close_doubt(self, port: Port) -> None:
        port.firing_doubt.note_closed()
        port.update_view()
        self.refresh()

    # What stays of the conversations that ended at this port

    def _interruptions_notice(self, port: Port, last: UserMessage) -> Notice:
        kept = port.interruptions
        text = tr("Interrupted at {time}: {why}", time=_clock_time(kept.last_at), why=last.translated())
        if kept.count > 1:
            text = tr(
                "Interrupted {count} times since {time}, last: {why}",
                count=kept.count,
                time=_clock_time(kept.first_at),
                why=last.translated(),
            )
        check = self._page_choices("after_restart", tr("Pre-flight"), "preflight")
        return Notice(Meaning.ATTENTION, text, check, kept.close, "interruptions")

    def _remainder_notice(self, port: Port, remainder: Remainder) -> Notice:
        """A report, or the edits of an ended conversation beside what the module holds now."""
        module = port.module
        who, when = module_label(remainder.module), _clock_time(remainder.at)
        close = partial(port.interruptions.close_remainder, remainder)
        cause = f"remainder {id(remainder)}"
        if remainder.kind is RemainderKind.REPORT:
            what = "" if remainder.text is None else remainder.text.translated()
            text = tr("{module}, interrupted {time}: {what}", module=who, time=when, what=what)
            return Notice(Meaning.ATTENTION, text, (), close, cause)
        is_same = remainder.module in ("", module.name)

        def take_over() -> None:
            if module.settings.can_edit:
                module.settings.take_over(remainder)
                close()
                self._window.go_to("settings")

        what = module.settings.beside(remainder)
        text = tr("{module}, interrupted {time}, not written: {what}.", module=who, time=when, what=what)
        if module.is_read and not is_same:
            text = join_sentences((text, tr("First say that it is {module}.", module=remainder.module)))
        is_possible = module.is_read and is_same and module.settings.can_edit
        take = Choice("take_over", tr("Take over"), take_over, is_enabled=is_possible)
        return Notice(Meaning.ATTENTION, text, (take,), close, cause)

    def _page_choices(self, key: str, text: str, page: str, *, is_main: bool = False) -> tuple[Choice, ...]:
        """A button that leads to a page; none while that page is shown."""
        if self._window.shown_page == page:
            return ()
        return (Choice(key, text, partial(self._window.go_to, page), is_main=is_main),)


def _clock_time(at: float) -> str:
    """Of the day, such as 10:02; `at` in seconds since 1970."""
    return time.strftime("%H:%M", time.localtime(at))


def _is_risky(leaving: _Leaving) -> bool:
    """A module is or may be ready to fire, and can still be locked."""
    if leaving.is_opened_again:
        return False
    return any(
        (port.is_active and (port.is_open or leaving.is_closing)) or (port.is_open and port.lock.is_unproven)
        for port in leaving.ports
    )


class UncaughtErrors(QObject):
    """`report` may be called from any thread. Errors of the same place share one notice."""

    _reported = Signal(object)

    def __init__(self, attention: Attention, armed: Armed, *, say: Callable[[str], None], parent: QObject) -> None:
        super().__init__(parent)
        self._attention, self._armed, self._say = attention, armed, say
        # Queued also in the window's thread: the error may have happened while painting.
        self._reported.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def report(self, error: UncaughtError) -> None:
        """Disarms at once, and shows the error from the event loop."""
        self._armed.act = None
        self._reported.emit(error)

    def _show(self, error: UncaughtError) -> None:
        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary)

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.thread}\n{error.details}")
            self._say(tr("Copied."))

        choices = (Choice("copy_details", tr("Copy"), copy_details),)
        self._attention.say(Notice(Meaning.ATTENTION, text, choices, cause=error.details))
