"""Chooses the one notice that needs attention.

In this order: a question about leaving an ACTIVE module, LOCK that failed, a bad link, a module that has fired, which
module it is, what was interrupted. An uncaught error disarms and is shown, too.
"""

import time
from collections.abc import Callable, Mapping
from functools import partial
from math import inf
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QGuiApplication

from app import version
from app.diagnosis.causes import STEP_WORDS, NextStep
from app.diagnosis.link_state import LinkState, Phase, link_text
from app.procedures.act import Armed
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.system.uncaught import UncaughtError
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import join_names, join_sentences, labelled
from protocol.fields import Value
from ui.services.storage import PendingEdits
from ui.session.interruptions import Remainder, RemainderKind
from ui.session.name_question import NameQuestion
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule, module_label
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar


def clock_time(at: float) -> str:
    """Of the day, such as 10:02; `at` in seconds since 1970."""
    return time.strftime("%H:%M", time.localtime(at))


AGAIN_S: Final = 2.0
"""Longer than it takes a keyboard to repeat a key that is held, also on a busy computer, where X may call the first
repetition another press."""


_ASKS_WHY = (Phase.SILENT, Phase.LATE, Phase.OFFLINE, Phase.LOST, Phase.FAILED)


def link_notice(
    state: LinkState, now: float, acts: dict[NextStep, Callable[[], None]], *, is_unlocked: bool = False
) -> Notice | None:
    """The trouble of the link and the step that helps; None while the link is fine. `is_unlocked`: LOCK was not
    confirmed, which another sentence beside this one says."""
    if state.is_fine:
        return None
    words = link_text(state, now)
    is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
    if is_unlocked or (state.was_active and not is_calm):
        words = words._replace(next_step=keep_away())  # alone, so that nothing of it is elided
    parts = ["" if words.what == words.word else words.what, words.next_step]  # the top bar has the word
    if state.was_active and not is_unlocked and not is_calm:
        parts.insert(0, tr(LAST_HEARD_ACTIVE))
    steps: tuple[NextStep, ...] = () if words.step is None else (words.step,)
    if state.phase in _ASKS_WHY:
        steps = (*steps, NextStep.WHY)
    choices = tuple(
        Choice(step.value, tr(STEP_WORDS[step]), acts[step], is_main=step is steps[0] and not is_calm) for step in steps
    )
    meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
    return Notice(meaning, join_sentences(parts), choices)


_GRAVEST_FIRST = (RemainderKind.TRIGGERED, RemainderKind.REPORT, RemainderKind.DRAFTS)


def is_risky_to_leave(port: Port) -> bool:
    """The module is or may be ready to fire, and can still be locked."""
    return port.is_open and (port.is_active or port.lock.is_unproven)


class _Question(NamedTuple):
    """A question about leaving, shown as long as it `is_open`."""

    make: Callable[[], Notice]
    is_open: Callable[[], bool]
    is_about_closing: bool
    is_about_edits: bool = False


class Attention(QObject):
    """Shows the most important notice: a question first, then LOCK, then the link. `acts` are those of the link's
    buttons."""

    def __init__(
        self,
        ports: Ports,
        bar: NoticeBar,
        *,
        acts: dict[NextStep, Callable[[], None]],
        pending_edits: PendingEdits,
        go_to: Callable[[str], None],
        shown_page: Callable[[], str],
        is_choosing: Callable[[], bool],
        find_left: Callable[[], Notice | None],
        parent: QObject,
    ) -> None:
        """`go_to` shows the page with this key, `shown_page` is that of the page shown. `is_choosing`: no notice needs
        to lead to the list of ports. `find_left`: what is said of a module left ACTIVE before."""
        super().__init__(parent)
        self._is_choosing, self._find_left = is_choosing, find_left
        self._ports, self._bar, self._acts = ports, bar, acts
        self._unsent, self._go_to, self._shown_page = pending_edits, go_to, shown_page
        self._has_read_trigger = False
        self._tried_at = -inf
        """When somebody last tried to close the window."""
        self._question: _Question | None = None
        self._answered: _Question | None = None
        """The last question, until it is cancelled: what its answer began may still lead to leaving."""
        self._name_question = NameQuestion(ports)
        self._queued: dict[str, tuple[Notice, bool]] = {}
        """By key, each with whether it ends with another module; the first one is shown first."""
        ports.shown.connect(self._on_another_module)
        for changed in (ports.any_changed, ports.lock_changed, ports.ticked, self._name_question.changed):
            changed.connect(self.refresh)
        for port in ports.all:
            port.interruptions.changed.connect(self.refresh)
        ports.added.connect(lambda port: port.interruptions.changed.connect(self.refresh))

    @property
    def is_risky_to_close(self) -> bool:
        """Like `is_risky_to_leave`, for the modules on all ports."""
        return is_risky_to_leave(self._ports.current) or self._ports.is_any_active

    def _unsent_text(self, *, is_closing: bool, port: Port | None = None) -> str:
        """Of the edits that leaving the module would lose, or closing the window; "" where there are none. `port`: one
        that is not shown, and is closed for good with what is kept there."""
        count = self._ports.module.count_unsent()
        if is_closing or port is not None:
            ports = self._ports.all if port is None else (port,)
            count = sum(one.module.count_unsent() + one.interruptions.count_drafts() for one in ports)
        is_profile_lost = is_closing and self._unsent.has_profile()
        parts = [tr("Settings not written: {count}.", count=count)] if count else []
        text = join_sentences([*parts, labelled(tr("Profile"), tr("Unsaved edits.")) if is_profile_lost else ""])
        return labelled(port.module.name or port.connection.port, text) if text and port is not None else text

    def may_close(self, close: Callable[[], object]) -> bool:
        """Whether the window may close now; else asks, and calls `close` where that is the answer.

        A second attempt to close while the question is shown is an answer too, unless it is of a double click or a key
        that is held.
        """
        question, now, before = self._question, self._ports.clock(), self._tried_at
        self._tried_at = now
        if question is not None and question.is_about_closing:
            if now - before < AGAIN_S:
                return False
            if not question.is_about_edits or not self.is_risky_to_close:
                return True
            self._leave_active(close, self._ports.current, is_closing=True)
            return False
        if not self.is_risky_to_close and not self._unsent_text(is_closing=True):
            return True
        self.leave_port(close, is_closing=True)
        return False

    def queue_notice(self, notice: Notice, *, key: str = "", is_of_module: bool = False) -> None:
        """Queues a notice, which is shown until it is closed, when nothing is more urgent; what offers no choice can be
        closed. It replaces one of the same `key`, by default its text. One `is_of_module` ends with another module."""
        self._queued[key or notice.text] = notice, is_of_module
        self.refresh()

    def _on_another_module(self, _module: ShownModule) -> None:
        """What a person has seen or was asked was about the former one."""
        self._queued = {key: queued for key, queued in self._queued.items() if not queued[1]}
        self._question = self._answered = None
        self._has_read_trigger = False
        self.refresh()

    def dismiss_queued(self) -> None:
        if self._queued:
            del self._queued[next(iter(self._queued))]
        self.refresh()

    def leave_port(self, proceed: Callable[[], object], *, port: Port | None = None, is_closing: bool = False) -> None:
        """Calls `proceed`; asks before edits would be lost or an ACTIVE module left. `port`: else the shown one."""
        go = partial(self._leave_active, proceed, port or self._ports.current, is_closing=is_closing)
        self.leave_edits(go, port=None if port is self._ports.current else port, is_closing=is_closing)

    def leave_edits(self, proceed: Callable[[], object], *, port: Port | None = None, is_closing: bool = False) -> None:
        """Calls `proceed`; asks before edits would be lost, and no longer once another module may be there. `port`: one
        that is not shown."""
        module = self._ports.module if port is None else port.module
        find_text = partial(self._unsent_text, is_closing=is_closing, port=port)
        if not find_text():
            proceed()
            return

        def go() -> None:
            self._question = None
            module.discard_edits()
            if is_closing or port is not None:
                for one in self._ports.all if port is None else (port,):
                    one.module.discard_edits()
                    one.interruptions.discard_drafts()
            proceed()

        def notice() -> Notice:
            stays = Choice("stay", tr("Cancel"), self.stay, is_main=True)
            drops = Choice("drop_edits", tr("Discard edits"), go, is_step=True)
            return Notice(Meaning.ATTENTION, find_text(), (stays, drops))

        def is_open() -> bool:
            return bool(find_text()) and (is_closing or port is not None or self._ports.module is module)

        self._ask(_Question(notice, is_open, is_about_closing=is_closing, is_about_edits=True), focused="stay")

    def _leave_active(self, proceed: Callable[[], object], port: Port, *, is_closing: bool) -> None:
        def is_risky() -> bool:
            return self.is_risky_to_close if is_closing else is_risky_to_leave(port)

        def go() -> None:
            """Also later, when LOCK is confirmed: not if it was cancelled meanwhile."""
            if self._answered is question:
                self._question = None
                proceed()

        if not is_risky():
            self._question = None
            proceed()
            return
        question = _Question(partial(self._leaving_notice, go, port, is_closing=is_closing), is_risky, is_closing)
        self._ask(question, focused="lock_and_leave")

    def _ask(self, question: "_Question", *, focused: str) -> None:
        self._question = self._answered = question
        self.refresh()
        if (button := self._bar.button(focused)) is not None:
            button.setFocus()

    def stay(self) -> None:
        """Cancels leaving; nothing is sent."""
        self._question = self._answered = None
        self.refresh()

    def refresh(self) -> None:
        if self._question is not None and not self._question.is_open():
            self._question = None
        self._bar.show_notice(self._notice())

    def _notice(self) -> Notice | None:
        if self._question is not None:
            return self._question.make()
        port = self._ports.current
        state = port.state
        left = self._find_left()
        if state.phase is Phase.CLOSED and self._is_choosing() and not self._queued:
            return left
        # Which says itself how to treat the module.
        is_unlocked = port.lock.failed is not None or port.lock.owed is not None
        link = link_notice(state, port.now_s, self._acts, is_unlocked=is_unlocked)
        locking = self._lock_notice(link.choices if link is not None else ())
        if locking is not None:
            return locking if link is None else locking._replace(text=join_sentences([locking.text, link.text]))
        if left is not None and link is not None:
            choices = (*left.choices, *link.choices)
            return left._replace(text=join_sentences([left.text, link.text]), choices=choices)
        if left is not None:
            return self._trigger_notice() or left
        if self._queued and (link is None or state.phase is Phase.CLOSED):
            notice, _ = next(iter(self._queued.values()))
            return notice if notice.choices else notice._replace(dismiss=self.dismiss_queued)
        return link or self._trigger_notice() or self._name_question.notice() or self._interruption_notice(port)

    def _lock_notice(self, more: tuple[Choice, ...] = ()) -> Notice | None:
        """LOCK of the shown module, else that of others which do not report it; Fleet says it itself."""
        here, others = self._ports.current, self._ports.all
        ports = [port for port in others if port is not here and port.lock.is_unproven and not port.lock.is_repeating]
        if (notice := here.lock.notice(more)) is not None or not ports or self._shown_page() == "fleet":
            return notice
        names = join_names(port.module.name or port.connection.port for port in ports)

        def press() -> None:
            for port in ports:
                port.lock.press()

        again = Choice("lock_others", tr("LOCK again"), press)
        return Notice(Meaning.DANGER, tr("NOT reported, treat as ACTIVE: {names}", names=names), (again, *more))

    def _interruption_notice(self, port: Port) -> Notice | None:
        """What stays of the conversations that ended at this port, until a person closes it; the gravest first."""
        kept = port.interruptions
        for remainder in sorted(kept.remainders, key=lambda one: _GRAVEST_FIRST.index(one.kind)):
            close = partial(kept.close_remainder, remainder)
            who, when = module_label(remainder.module), clock_time(remainder.at)
            if remainder.kind is RemainderKind.TRIGGERED:
                text = tr("{module} reported TRIGGERED before {time}.", module=who, time=when)
                choices = self._page_choices("after_trigger", tr("Read the record"), "triggers", is_main=True)
                return Notice(Meaning.DANGER, text, choices, dismiss=partial(self._close_triggered, port, close))
            if remainder.kind is RemainderKind.REPORT and remainder.text is not None:
                text = tr(
                    "{module}, interrupted {time}: {what}", module=who, time=when, what=remainder.text.translated()
                )
                return Notice(Meaning.ATTENTION, text, dismiss=close)
            if remainder.drafts is not None:
                return self._drafts_notice(port, remainder, remainder.drafts)
        if port.firing_doubt.is_to_be_told:
            text = tr("The module may have fired before the restart: read the trigger records.")
            choices = self._page_choices("after_restart", tr("Read the record"), "triggers", is_main=True)
            return Notice(Meaning.DANGER, text, choices, dismiss=partial(self._close_doubt, port))
        if kept.last is None:
            return None
        why = kept.last.translated()
        if kept.count == 1:
            text = tr("Interrupted at {time}: {why}", time=clock_time(kept.last_at), why=why)
        else:
            since = clock_time(kept.first_at)
            text = tr("Interrupted {count} times since {time}, last: {why}", count=kept.count, time=since, why=why)
        check = self._page_choices("after_restart", tr("Pre-flight"), "preflight")
        return Notice(Meaning.ATTENTION, text, check, dismiss=kept.close)

    def _drafts_notice(self, port: Port, remainder: Remainder, drafts: Mapping[str, Value]) -> Notice:
        """Offers the edits of an ended conversation: what the module holds now, and what was to be written."""
        module = port.module
        is_same = remainder.module in ("", module.name)
        close = partial(port.interruptions.close_remainder, remainder)

        def take_over() -> None:
            if module.settings.can_edit:
                module.settings.fill(drafts)
                close()
                self._go_to("settings")

        who, when = module_label(remainder.module), clock_time(remainder.at)
        what = module.settings.beside(drafts)
        text = tr("{module}, interrupted {time}, not written: {what}.", module=who, time=when, what=what)
        if module.is_read and not is_same:
            text = join_sentences((text, tr("First say that it is {module}.", module=remainder.module)))
        is_possible = module.is_read and is_same and module.settings.can_edit
        take = Choice("take_over", tr("Take over"), take_over, is_enabled=is_possible)
        return Notice(Meaning.ATTENTION, text, (take,), dismiss=close)

    def _close_triggered(self, port: Port, close: Callable[[], None]) -> None:
        self._close_doubt(port)
        close()

    def _close_doubt(self, port: Port) -> None:
        port.firing_doubt.note_closed()
        port.update_view()
        self.refresh()

    def _trigger_notice(self) -> Notice | None:
        """What comes next, as long as the module reports that it has triggered."""
        port, module = self._ports.current, self._ports.module
        known = module.view.known("triggered", port.now_s)
        if known is not None and known.value is False:
            self._has_read_trigger = False
        is_triggered = port.is_open and known is not None and known.value is True
        if not is_triggered or self._has_read_trigger or module.is_fired_by_test:
            return None
        text = tr("The module has triggered: LOCK, read the record, pack, check again.")
        choices = self._page_choices("after_trigger", tr("Read the record"), "triggers", is_main=True)
        return Notice(Meaning.DANGER, text, choices, dismiss=self._dismiss_trigger)

    def say_unrecorded(self, why: UserMessage) -> None:
        """Recording stopped; of several reasons the last one is said."""
        show = Choice("recordings", tr("Recordings"), lambda: self._go_to("recordings"))
        notice = Notice(Meaning.ATTENTION, why.translated(), (show,), self.dismiss_queued)
        self.queue_notice(notice, key="recordings")

    def _page_choices(self, key: str, text: str, page: str, *, is_main: bool = False) -> tuple[Choice, ...]:
        """A button that leads to a page; none while that page is shown."""
        if self._shown_page() == page:
            return ()
        return (Choice(key, text, lambda: self._go_to(page), is_main=is_main),)

    def _dismiss_trigger(self) -> None:
        self._has_read_trigger = True
        self.refresh()

    def _leaving_notice(self, go: Callable[[], None], port: Port, *, is_closing: bool) -> Notice:
        """Asked before leaving a module that is ACTIVE or does not report LOCKED."""

        def lock() -> None:
            if is_closing:
                self._ports.lock.press_all(then=go)
            else:
                port.lock.press(then=go)

        text = tr("Treat the module as ACTIVE: it does not report LOCKED.")
        if self._ports.is_any_active if is_closing else port.is_active:
            text = tr("The module is ACTIVE: it fires also without this program.")
        if port is not self._ports.current:
            text = labelled(port.module.name or port.connection.port, text)
        locking = port.lock.notice()
        choices = (
            Choice("lock_and_leave", tr("LOCK first"), lock, is_main=True),
            Choice("leave_active", tr("Leave it ACTIVE"), go, is_step=True),
            Choice("stay", tr("Cancel"), self.stay),
        )
        return Notice(Meaning.ATTENTION, text if locking is None else join_sentences([locking.text, text]), choices)


class UncaughtErrors(QObject):
    """`report` may be called from any thread. Repeated errors share one notice with a count."""

    _reported = Signal(object)

    def __init__(self, attention: Attention, armed: Armed, *, say: Callable[[str], None], parent: QObject) -> None:
        super().__init__(parent)
        self._attention, self._armed, self._say = attention, armed, say
        self._counts: dict[str, int] = {}
        """By details; those whose notice is shown or queued."""
        # Queued also in the window's thread: the error may have happened while painting.
        self._reported.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def report(self, error: UncaughtError) -> None:
        """Disarms at once, and shows the error from the event loop."""
        self._armed.act = None
        self._reported.emit(error)

    def _show(self, error: UncaughtError) -> None:
        self._say(tr("Unexpected error: {error}. Nothing is armed.", error=error.summary))
        self._counts[error.details] = self._counts.get(error.details, 0) + 1
        self._attention.queue_notice(self._notice(error), key=error.details)

    def _notice(self, error: UncaughtError) -> Notice:
        count = self._counts[error.details]
        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary) + f" (×{count})" * (count > 1)

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.thread}\n{error.details}")
            self._say(tr("Copied."))

        def dismiss() -> None:
            self._counts.pop(error.details, None)
            self._attention.dismiss_queued()

        choices = (Choice("copy_details", tr("Copy"), copy_details),)
        return Notice(Meaning.ATTENTION, text, choices, dismiss=dismiss)
