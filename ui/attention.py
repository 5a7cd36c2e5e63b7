"""What needs a person now: a question before an ACTIVE module is left, a lock that did not work, a link in trouble."""

from collections.abc import Callable

from PySide6.QtCore import QObject

from app.i18n import tr
from app.procedures.lock import Locked
from ui.connector import Connector
from ui.keeping import Unsent
from ui.link_state import Phase, Step
from ui.notice_bar import Notice, NoticeBar
from ui.notices import leaving_notice, link_notice, lock_notice, unsent_notice


class Attention(QObject):
    """Keeps the notice bar at what matters most: the question first, then the last lock, then the link.

    `say` is given words that need nobody; `acts` is what the link's buttons do.
    """

    def __init__(
        self,
        connector: Connector,
        bar: NoticeBar,
        *,
        say: Callable[[str], None],
        acts: dict[Step, Callable[[], None]],
        unsent: Unsent | None = None,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.is_choosing = False
        """The ports are in sight, so nobody needs to be sent there."""
        self.find_identity: Callable[[], Notice | None] = lambda: None
        """The question which module it is, where that has to be decided."""
        self._connector, self._bar, self._say, self._acts = connector, bar, say, acts
        self._unsent = unsent or Unsent()
        self._question: Callable[[], Notice] | None = None
        self._is_still_asked: Callable[[], bool] = bool
        self._is_about_closing = False
        self._told: list[Callable[[], Notice]] = []
        self._message: Callable[[], Notice | None] | None = None
        self._locks = 0
        """How often LOCK was sent off."""
        self._locks_under_way: set[int] = set()
        self._locks_done = 0
        """Up to this one all is said."""
        self._after_lock: list[Callable[[], None]] = []
        """What waits for it."""

    @property
    def is_risky_to_leave(self) -> bool:
        """The module is, or may be, ready to fire, and can still be told not to."""
        return self._connector.is_open and self._connector.is_active

    @property
    def has_unsent(self) -> bool:
        """There are edits that leaving would lose."""
        return self._unsent.count() > 0

    def may_close(self, close: Callable[[], object]) -> bool:
        """Whether nothing stands against closing now; else it is asked, and `close` called where that is the answer.

        A second attempt while the question stands is an answer too.
        """
        is_asked = self._question is not None and self._is_about_closing
        asks_of_edits = is_asked and self._is_still_asked == self._has_unsent_now
        if is_asked and not (asks_of_edits and self.is_risky_to_leave):
            return True
        if asks_of_edits:
            self._leave_active(close, is_closing=True)
            return False
        if not self.is_risky_to_leave and not self.has_unsent:
            return True
        self.leave(close, is_closing=True)
        return False

    def tell(self, make: Callable[[], Notice]) -> None:
        """Say something that can wait until nothing more urgent is to be said, and stays until it is closed."""
        self._told.append(make)
        self.refresh()

    def forget_told(self) -> None:
        """The first thing that was told has been read."""
        del self._told[:1]
        self.refresh()

    def lock(self) -> None:
        """Put the module into standby, and say what the module says of it."""
        self._lock_then(lambda: None)

    def leave(self, leave: Callable[[], object], *, is_closing: bool = False) -> None:
        """Do it; but where edits would be lost or an ACTIVE module left, ask before."""
        self._message = None
        if not self.has_unsent:
            self._leave_active(leave, is_closing=is_closing)
            return

        def go() -> None:
            self._unsent.discard()
            self._leave_active(leave, is_closing=is_closing)

        self._ask(
            lambda: unsent_notice(self._unsent.count(), go, self.stay, is_closing=is_closing),
            self._has_unsent_now,
            is_closing=is_closing,
            main="stay",
        )

    def _leave_active(self, leave: Callable[[], object], *, is_closing: bool) -> None:
        if not self.is_risky_to_leave:
            self._question = None
            leave()
            return

        def go() -> None:
            self._question = None
            leave()

        self._ask(
            lambda: leaving_notice(lambda: self._lock_then(go), go, self.stay, is_closing=is_closing),
            self._is_risky_now,
            is_closing=is_closing,
            main="lock_and_leave",
        )

    def _ask(
        self, question: Callable[[], Notice], is_still_asked: Callable[[], bool], *, is_closing: bool, main: str
    ) -> None:
        self._question, self._is_still_asked, self._is_about_closing = question, is_still_asked, is_closing
        self.refresh()
        button = self._bar.button(main)
        if button is not None:
            button.setFocus()

    def _has_unsent_now(self) -> bool:
        return self.has_unsent

    def _is_risky_now(self) -> bool:
        return self.is_risky_to_leave or bool(self._after_lock)

    def stay(self) -> None:
        """Do not leave after all; nothing is sent."""
        self._question = None
        self.refresh()

    def refresh(self) -> None:
        if self._question is not None and not self._is_still_asked():
            self._question = None
        self._bar.show_notice(self._notice())

    def _notice(self) -> Notice | None:
        if self._question is not None:
            return self._question()
        if self._message is not None:
            return self._message()
        asked = self.find_identity()
        if asked is not None:
            return asked
        connector = self._connector
        state = connector.state
        if state.phase is Phase.CLOSED and self.is_choosing and not self._told:
            return None
        said = link_notice(state, connector.clock(), self._acts, was_active=connector.is_active)
        if connector.is_recording and state.trouble is None:
            said = None  # a recording that falls silent needs nobody; its own bar says that it has ended
        if self._told and (said is None or state.phase is Phase.CLOSED):
            return self._told[0]()
        return said

    def _lock_then(self, then: Callable[[], None]) -> None:
        """Pressed again while one is under way, it goes out again: the first may have been lost on the line. One that
        the module confirms is enough; that none was is said when the last has ended."""
        if not self._connector.is_open:
            return
        self._after_lock.append(then)
        self._locks += 1
        number = self._locks
        self._locks_under_way.add(number)
        self._message = None
        self._say(tr("Locking …"))

        def end(locked: Locked | None) -> None:
            self._locks_under_way.discard(number)
            is_locked = lock_notice(locked, self.lock, self._forget) is None
            is_told_later = not is_locked and any(one > self._locks_done for one in self._locks_under_way)
            if number <= self._locks_done or is_told_later:
                return
            self._locks_done = self._locks
            waiting, self._after_lock = self._after_lock, []
            if is_locked:
                self._say(tr("LOCKED: the module says so."))
                for one in waiting:
                    one()
            else:
                self._question = None
                self._message = lambda: lock_notice(locked, self.lock, self._forget)
                self._say("")
            self.refresh()

        self._connector.lock(end)

    def _forget(self) -> None:
        self._message = None
        self.refresh()
