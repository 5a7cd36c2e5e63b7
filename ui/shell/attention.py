"""The window's notices, the gravest first: one list, in which each notice belongs to its cause and goes with it.

What is asked before leaving; a LOCK that is not confirmed; what has fired; what was left ACTIVE; errors of the program;
the link; what an ended conversation left; which module it is; advice.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Final

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
from ui.services.storage import PendingEdits
from ui.session.interruptions import Remainder, RemainderKind
from ui.session.left_active import LeftActiveWatch
from ui.session.name_question import NameQuestion
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule, module_label
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar

# Longer than it takes a keyboard to repeat a key that is held, also on a busy computer, where X may call the first
# repetition another press.
AGAIN_S: Final = 2.0
_ASKS_WHY: Final = (Phase.SILENT, Phase.LATE, Phase.OFFLINE, Phase.LOST, Phase.FAILED)


def link_notice(state: LinkState, now: float, acts: dict[NextStep, Callable[[], None]]) -> Notice | None:
    """The trouble of the link and the step that helps; None while the link is fine."""
    if state.is_fine:
        return None
    words = link_text(state, now)
    is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
    parts = ["" if words.what == words.word else words.what, words.next_step]  # the top bar has the word
    if state.was_active and not is_calm:
        parts = [tr(LAST_HEARD_ACTIVE), parts[0], keep_away()]  # no more, so that nothing of it is elided
    steps: tuple[NextStep, ...] = () if words.step is None else (words.step,)
    if state.phase in _ASKS_WHY:
        steps = (*steps, NextStep.WHY)
    choices = tuple(
        Choice(step.value, tr(STEP_WORDS[step]), acts[step], is_main=step is steps[0] and not is_calm) for step in steps
    )
    meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
    return Notice(meaning, join_sentences(parts), choices, cause=f"link {state.phase.value}")


def is_risky_to_leave(port: Port) -> bool:
    """The module is or may be ready to fire, and can still be locked."""
    return port.is_open and (port.is_active or port.lock.is_unproven)


@dataclass(eq=False)
class _Leaving:
    """A person wants to leave `ports`, and is asked about what would be left behind: a module that is ACTIVE, then
    edits."""

    proceed: Callable[[], object]
    ports: tuple[Port, ...]
    is_closing: bool
    may_stay_active: bool = False
    may_lose_edits: bool = False
    is_locking: bool = False


class Attention(QObject):
    """Shows the notices of the window. `acts` are those of the link's buttons."""

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
        left_active: LeftActiveWatch,
        parent: QObject,
    ) -> None:
        """`go_to` shows the page with this key, `shown_page` is that of the page shown. `is_choosing`: no notice needs
        to lead to the list of ports."""
        super().__init__(parent)
        self._is_choosing, self._left_active = is_choosing, left_active
        self._ports, self._bar, self._acts = ports, bar, acts
        self._pending_edits, self._go_to, self._shown_page = pending_edits, go_to, shown_page
        self._has_read_trigger = False
        # When somebody last tried to close the window.
        self._tried_at = -inf
        self._leaving: _Leaving | None = None
        self._name_question = NameQuestion(ports)
        # Until they are closed, by key; each with whether it ends with another module.
        self._said: dict[str, tuple[Notice, bool]] = {}
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
        self._bar.show_notices(list(self._notices()))

    def say(self, notice: Notice, *, key: str = "", is_of_module: bool = False) -> None:
        """Shows a notice until it is closed. It replaces one of the same `key`, by default its text. One `is_of_module`
        ends with another module."""
        key = key or notice.text
        dismiss = notice.dismiss or partial(self.withdraw, key)
        self._said[key] = notice._replace(dismiss=dismiss, cause=key), is_of_module
        self.refresh()

    def withdraw(self, key: str) -> None:
        self._said.pop(key, None)
        self.refresh()

    def say_unrecorded(self, why: UserMessage) -> None:
        """Recording stopped; of several reasons the last one is said."""
        show = Choice("recordings", tr("Recordings"), lambda: self._go_to("logs"))
        self.say(Notice(Meaning.ATTENTION, why.translated(), (show,)), key="recordings")

    def _on_another_module(self, _module: ShownModule) -> None:
        """What a person has seen or was asked was about the former one."""
        self._said = {key: said for key, said in self._said.items() if not said[1]}
        self._leaving = None
        self._has_read_trigger = False
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
        yield from (notice for notice, _is_of_module in self._said.values())
        link = link_notice(state, port.now_s, self._acts)
        if link is not None and not (state.phase is Phase.CLOSED and self._is_choosing()):
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
        now, before, leaving = self._ports.clock(), self._tried_at, self._leaving
        self._tried_at = now
        if leaving is None or not leaving.is_closing:
            leaving = _Leaving(close, self._ports.all, is_closing=True)
        elif now - before < AGAIN_S:
            return False
        else:
            self._note_answer(leaving)
        if self._leaving_notice(leaving) is None:
            return True
        self._ask(leaving)
        return False

    def leave_port(self, proceed: Callable[[], object], *, port: Port | None = None, only_edits: bool = False) -> None:
        """Calls `proceed`; asks before an ACTIVE module is left or edits would be lost. `port`: else the shown one.
        `only_edits`: the same port is opened again."""
        ports = (port or self._ports.current,)
        self._ask(_Leaving(proceed, ports, is_closing=False, may_stay_active=only_edits))

    def stay(self) -> None:
        """Cancels leaving; nothing is sent."""
        self._leaving = None
        self.refresh()

    def _ask(self, leaving: _Leaving) -> None:
        """Asks what is still to be asked; else leaves."""
        if self._leaving_notice(leaving) is not None:
            self._leaving = leaving
            self.refresh()
            button = self._bar.button("lock_and_leave") or self._bar.button("stay")
            if button is not None:
                button.setFocus()
            return
        self._leaving = None
        for port in leaving.ports:
            port.module.discard_edits()
            if leaving.is_closing or port is not self._ports.current:
                port.interruptions.discard_drafts()
        leaving.proceed()

    def _accept(self, leaving: _Leaving) -> None:
        self._note_answer(leaving)
        self._ask(leaving)

    def _note_answer(self, leaving: _Leaving) -> None:
        """To what is asked now."""
        if self._is_risky(leaving):
            leaving.may_stay_active = True
        else:
            leaving.may_lose_edits = True

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

    def _is_risky(self, leaving: _Leaving) -> bool:
        is_any = any(is_risky_to_leave(port) or (leaving.is_closing and port.is_active) for port in leaving.ports)
        return is_any and not leaving.may_stay_active

    def _leaving_notice(self, leaving: _Leaving) -> Notice | None:
        stays = Choice("stay", tr("Cancel"), self.stay)
        port = leaving.ports[0]
        is_elsewhere = not leaving.is_closing and port is not self._ports.current
        if self._is_risky(leaving):
            text = tr("Treat the module as ACTIVE: it does not report LOCKED.")
            if any(port.is_active for port in leaving.ports):
                text = tr("The module is ACTIVE: it fires also without this program.")
            choices: tuple[Choice, ...] = (
                Choice("lock_and_leave", tr("LOCK first"), partial(self._lock_first, leaving), is_main=True),
                Choice("leave_active", tr("Leave it ACTIVE"), partial(self._accept, leaving), is_step=True),
                stays,
            )
        else:
            text = self._unsent_text(leaving)
            if not text or leaving.may_lose_edits:
                return None
            drop = Choice("drop_edits", tr("Discard edits"), partial(self._accept, leaving), is_step=True)
            choices = (stays._replace(is_main=True), drop)
        if is_elsewhere:
            text = labelled(port.module.name or port.connection.port, text)
        return Notice(Meaning.ATTENTION, text, choices, cause="leaving")

    def _unsent_text(self, leaving: _Leaving) -> str:
        """Of the edits that would be lost; "" where there are none."""
        count = sum(port.module.count_unsent() for port in leaving.ports)
        if leaving.is_closing or leaving.ports[0] is not self._ports.current:
            count += sum(port.interruptions.count_drafts() for port in leaving.ports)
        parts = [tr("Settings not written: {count}.", count=count)] if count else []
        if leaving.is_closing and self._pending_edits.has_profile():
            parts.append(labelled(tr("Profile"), tr("Unsaved edits.")))
        return join_sentences(parts)

    # LOCK, and what has fired

    def _lock_notices(self) -> Iterator[Notice]:
        """Of the shown module, and of others which do not report LOCKED; Fleet says that itself."""
        here = self._ports.current
        if (notice := here.lock.notice()) is not None:
            yield notice._replace(cause="lock")
        ports = [port for port in self._ports.all if port is not here]
        ports = [port for port in ports if port.lock.is_unproven and not port.lock.is_repeating]
        if not ports or self._shown_page() == "fleet":
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
        if known is not None and known.value is False:
            self._has_read_trigger = False
        is_triggered = port.is_open and known is not None and known.value is True
        if is_triggered and not self._has_read_trigger and not module.is_fired_by_test:
            text = tr("The module has triggered: LOCK, read the record, pack, check again.")
            yield Notice(Meaning.DANGER, text, choices, self._dismiss_trigger, "triggered")
        seen = [one for one in port.interruptions.remainders if one.kind is RemainderKind.TRIGGERED]
        for remainder in seen:
            who, when = module_label(remainder.module), clock_time(remainder.at)
            text = tr("{module} reported TRIGGERED before {time}.", module=who, time=when)
            yield Notice(Meaning.DANGER, text, choices, partial(self._close_triggered, port, remainder))
        if not seen and port.firing_doubt.is_to_be_told:
            text = tr("The module may have fired before the restart: read the trigger records.")
            yield Notice(Meaning.DANGER, text, choices, partial(self._close_doubt, port))

    def _dismiss_trigger(self) -> None:
        self._has_read_trigger = True
        self.refresh()

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
        text = tr("Interrupted at {time}: {why}", time=clock_time(kept.last_at), why=last.translated())
        if kept.count > 1:
            text = tr(
                "Interrupted {count} times since {time}, last: {why}",
                count=kept.count,
                time=clock_time(kept.first_at),
                why=last.translated(),
            )
        check = self._page_choices("after_restart", tr("Pre-flight"), "preflight")
        return Notice(Meaning.ATTENTION, text, check, kept.close, "interruptions")

    def _remainder_notice(self, port: Port, remainder: Remainder) -> Notice:
        """A report, or the edits of an ended conversation beside what the module holds now."""
        module = port.module
        who, when = module_label(remainder.module), clock_time(remainder.at)
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
                self._go_to("settings")

        what = module.settings.beside(remainder)
        text = tr("{module}, interrupted {time}, not written: {what}.", module=who, time=when, what=what)
        if module.is_read and not is_same:
            text = join_sentences((text, tr("First say that it is {module}.", module=remainder.module)))
        is_possible = module.is_read and is_same and module.settings.can_edit
        take = Choice("take_over", tr("Take over"), take_over, is_enabled=is_possible)
        return Notice(Meaning.ATTENTION, text, (take,), close, cause)

    def _page_choices(self, key: str, text: str, page: str, *, is_main: bool = False) -> tuple[Choice, ...]:
        """A button that leads to a page; none while that page is shown."""
        if self._shown_page() == page:
            return ()
        return (Choice(key, text, lambda: self._go_to(page), is_main=is_main),)


def clock_time(at: float) -> str:
    """Of the day, such as 10:02; `at` in seconds since 1970."""
    return time.strftime("%H:%M", time.localtime(at))


class UncaughtErrors(QObject):
    """`report` may be called from any thread. Repeated errors share one notice with a count."""

    _reported = Signal(object)

    def __init__(self, attention: Attention, armed: Armed, *, say: Callable[[str], None], parent: QObject) -> None:
        super().__init__(parent)
        self._attention, self._armed, self._say = attention, armed, say
        # By details; those whose notice is open.
        self._counts: dict[str, int] = {}
        # Queued also in the window's thread: the error may have happened while painting.
        self._reported.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def report(self, error: UncaughtError) -> None:
        """Disarms at once, and shows the error from the event loop."""
        self._armed.act = None
        self._reported.emit(error)

    def _show(self, error: UncaughtError) -> None:
        count = self._counts[error.details] = self._counts.get(error.details, 0) + 1
        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary)
        if count > 1:
            text = f"{text} (×{count})"

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.thread}\n{error.details}")
            self._say(tr("Copied."))

        def dismiss() -> None:
            self._counts.pop(error.details, None)
            self._attention.withdraw(error.details)

        choices = (Choice("copy_details", tr("Copy"), copy_details),)
        self._attention.say(Notice(Meaning.ATTENTION, text, choices, dismiss), key=error.details)
