"""The window's notices, the gravest first: one list, in which each notice belongs to its cause and goes with it."""

import time
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QGuiApplication

from app import version
from app.diagnosis.causes import NextStep
from app.diagnosis.link_state import Phase
from app.modules.names import what_differs
from app.procedures.act import Armed
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.system.uncaught import UncaughtError
from app.text.i18n import tr
from app.text.messages import join_names, join_sentences
from protocol.translatable import marked
from ui.session.left_active import LeftActiveWatch
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import Remainder, ShownModule, module_label
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice, NoticeList

if TYPE_CHECKING:
    from ui.shell.main_window import MainWindow

_ASKS_WHY: Final = (Phase.SILENT, Phase.LATE, Phase.OFFLINE, Phase.LOST, Phase.FAILED)


class Attention(QObject):
    """Shows them in the bar at the foot of the window."""

    _failed = Signal(object)

    def __init__(self, window: "MainWindow", ports: Ports, left_active: LeftActiveWatch, armed: Armed) -> None:
        super().__init__(window)
        self._window, self._ports, self._left_active, self._armed = window, ports, left_active, armed
        self._watched: ShownModule | None = None
        # What is said until a person closes it.
        self.said = NoticeList(self)
        # The keys of those that a person has closed, as long as their causes last.
        self._closed: set[str] = set()
        ports.shown.connect(self._on_another_module)
        for changed in (ports.any_changed, left_active.changed, window.leaving.asked, self.said.changed):
            changed.connect(self.refresh)
        # Queued also in the window's thread: the error may have happened while painting.
        self._failed.connect(self._show_error, Qt.ConnectionType.QueuedConnection)

    def refresh(self) -> None:
        notices = list(self._notices())
        self._closed &= {notice.key for notice in notices}
        self._window.notice_bar.show_notices([notice for notice in notices if notice.key not in self._closed])

    def report(self, error: UncaughtError) -> None:
        """Disarm at once, and show the error from the event loop; from any thread. One place has one notice."""
        self._armed.act = None
        self._failed.emit(error)

    def _show_error(self, error: UncaughtError) -> None:
        self._ports.failed.emit()

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.details}")
            self._window.notice_bar.show_passing(tr("Copied."))

        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary)
        choices = (Choice("copy_details", tr("Copy"), copy_details),)
        notice = Notice(Meaning.ATTENTION, text, choices, self.said.dismiss, error.details)
        self.said.set_notice(notice, error.details)

    def _closable(self, notice: Notice) -> Notice:
        """Return it with a button to close it, until it has another cause."""

        def close() -> None:
            self._closed.add(notice.key)
            self.refresh()

        return notice._replace(dismiss=close)

    def _on_another_module(self, module: ShownModule) -> None:
        """Forget what a person has closed: it was about the former module."""
        if module is not self._watched:  # the same port may be chosen again
            self._watched = module
            module.changed.connect(self.refresh)
        self._closed.clear()
        self.refresh()

    # The list

    def _notices(self) -> Iterator[Notice]:
        """The gravest first."""
        port, left = self._ports.current, self._left_active.notices()
        yield from filter(None, (self._window.leaving.notice(), port.lock.notice(), self._locks_elsewhere()))
        yield from self._fired(port)
        yield from (notice for notice in left if notice.meaning is Meaning.ATTENTION)
        yield from self.said.said
        if (unrecorded := port.recording.state.trouble) is not None:
            show = Choice("recordings", tr("Recordings"), partial(self._window.go_to, "logs"))
            yield self._closable(Notice(Meaning.ATTENTION, unrecorded.translated(), (show,), cause="unrecorded"))
        yield from filter(None, (self._link(port), self._which_module(port)))
        yield from (self._remainder(port, one) for one in port.interruptions.remainders if not one.is_trigger)
        yield from self._interruptions(port)
        yield from (notice for notice in left if notice.meaning is not Meaning.ATTENTION)

    def _locks_elsewhere(self) -> Notice | None:
        """Modules that are not shown, and do not report LOCKED."""
        others = [one for one in self._ports.lock.others if one.lock.is_unproven and not one.lock.is_repeating]
        if not others or self._window.shown_page == "fleet":  # which says it itself
            return None
        names = join_names(one.module.name or one.connection.port for one in others)
        text = tr("NOT reported, treat as ACTIVE: {names}", names=names)

        def lock_again() -> None:
            for one in others:
                one.lock.press()

        return Notice(Meaning.DANGER, text, (Choice("lock_others", tr("LOCK again"), lock_again),), cause="others")

    def _fired(self, port: Port) -> Iterator[Notice]:
        """It reports TRIGGERED, did so before its conversation ended, or may have fired before it restarted."""
        module = port.module
        choices = self._way("after_trigger", tr("Read the record"), "triggers", is_main=True)
        known = module.view.known("triggered", port.now_s)
        if port.is_open and known is not None and known.value is True and not module.is_fired_by_test:
            text = tr("The module has triggered: LOCK, read the record, pack, check again.")
            yield self._closable(Notice(Meaning.DANGER, text, choices, cause="triggered"))

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
        """The trouble of the link and the step that helps; None while the link is fine, or the page itself leads to the
        list of ports."""
        state = port.state
        if state.is_fine or (state.phase is Phase.CLOSED and self._window.is_choosing):
            return None
        is_calm = state.phase in (Phase.CLOSED, Phase.SWITCHED_OFF)
        parts = ["" if state.what == state.word else state.what, state.next_step]  # the top bar has the word
        if port.is_active and not is_calm:
            parts = [tr(LAST_HEARD_ACTIVE), parts[0], keep_away()]  # no more, so that nothing of it is elided
        steps = [] if state.step is None else [state.step]
        if state.phase in _ASKS_WHY:
            steps.append(NextStep.WHY)
        choices = [Choice(step.name.lower(), tr(step.value), partial(self._window.take_step, step)) for step in steps]
        if choices and not is_calm:
            choices[0] = choices[0]._replace(is_main=True)
        meaning = Meaning.INFORMATION if is_calm else Meaning.ATTENTION
        return Notice(meaning, join_sentences(parts), tuple(choices), cause=f"link {state.phase.value}")

    def _which_module(self, port: Port) -> Notice | None:
        """Ask which module it is. Where nothing speaks against a name, one press says it; else a second one is needed,
        beside what speaks against it. Neither is ever the default button."""
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

        said = marked("It is {module} all the same") if module.doubted_name else marked("It is {module}")
        yes = tr(said, module=name)
        same = Choice("name_same", yes, partial(module.name_it, name), is_step=True)
        meaning = Meaning.ATTENTION if against else Meaning.INFORMATION
        # What is known so far may have been taken for the former one's: all of it is read again.
        other = Choice("name_other", tr("Another module"), port.treat_as_another)
        return Notice(meaning, join_sentences(parts), (same, other))

    def _interruptions(self, port: Port) -> Iterator[Notice]:
        """Give one notice of all conversations that ended, once the link's own notice no longer says it."""
        kept = port.interruptions
        if kept.last is None or not (port.state.is_fine or port.state.phase is Phase.CLOSED):
            return
        why, time_ = kept.last.translated(), _clock_time(kept.last_at)
        text = tr("Interrupted at {time}: {why}", time=time_, why=why)
        if kept.count > 1:
            since = _clock_time(kept.first_at)
            text = tr("Interrupted {count} times since {time}, last: {why}", count=kept.count, time=since, why=why)
        check = self._way("after_restart", tr("Pre-flight"), "preflight")
        yield Notice(Meaning.ATTENTION, text, check, kept.close, "interruptions")

    def _remainder(self, port: Port, remainder: Remainder) -> Notice:
        """A report, or the edits of an ended conversation beside what the module holds now."""
        module, settings = port.module, port.module.settings
        who, when = module_label(remainder.module), _clock_time(remainder.at)
        close = partial(port.interruptions.close_remainder, remainder)
        cause = f"remainder {id(remainder)}"
        if remainder.text is not None:
            text = tr("{module}, {time}: {what}", module=who, time=when, what=remainder.text.translated())
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


def _clock_time(at: float) -> str:
    """Return the time of the day, such as 10:02; `at` is in seconds since 1970."""
    return time.strftime("%H:%M", time.localtime(at))
