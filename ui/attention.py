"""What needs a person now: a question before an ACTIVE module is left, a lock that did not work, a link in trouble."""

from collections.abc import Callable

from PySide6.QtCore import QObject

from app.i18n import tr
from app.procedures.lock import Locked
from ui.connector import Connector
from ui.link_state import Phase, Step
from ui.notice_bar import Notice, NoticeBar
from ui.notices import leaving_notice, link_notice, lock_notice


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
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.is_choosing = False
        """The ports are in sight, so nobody needs to be sent there."""
        self._connector, self._bar, self._say, self._acts = connector, bar, say, acts
        self._question: Callable[[], Notice] | None = None
        self._is_about_closing = False
        self._message: Callable[[], Notice | None] | None = None
        self._is_locking = False

    @property
    def is_risky_to_leave(self) -> bool:
        """The module is, or may be, ready to fire, and can still be told not to."""
        return self._connector.is_open and self._connector.is_active

    @property
    def asks_about_closing(self) -> bool:
        return self._question is not None and self._is_about_closing

    def lock(self) -> None:
        """Put the module into standby, and say what the module says of it."""
        self._lock_then(lambda: None)

    def leave(self, leave: Callable[[], object], *, is_closing: bool = False) -> None:
        """Do it; but where an ACTIVE module would be left, ask before."""
        self._message = None
        if not self.is_risky_to_leave:
            self._question = None
            leave()
            return

        def go() -> None:
            self._question = None
            leave()

        self._is_about_closing = is_closing
        self._question = lambda: leaving_notice(
            lambda: self._lock_then(go), go, self.stay, is_closing=is_closing
        )
        self.refresh()
        main = self._bar.button("lock_and_leave")
        if main is not None:
            main.setFocus()

    def stay(self) -> None:
        """Do not leave after all; nothing is sent."""
        self._question = None
        self.refresh()

    def refresh(self) -> None:
        if self._question is not None and not self.is_risky_to_leave and not self._is_locking:
            self._question = None
        self._bar.show_notice(self._notice())

    def _notice(self) -> Notice | None:
        if self._question is not None:
            return self._question()
        if self._message is not None:
            return self._message()
        connector = self._connector
        state = connector.state
        if state.phase is Phase.CLOSED and self.is_choosing:
            return None
        return link_notice(state, connector.clock(), self._acts, was_active=connector.is_active)

    def _lock_then(self, then: Callable[[], None]) -> None:
        if self._is_locking or not self._connector.is_open:
            return
        self._is_locking = True
        self._message = None
        self._say(tr("Locking …"))

        def end(locked: Locked | None) -> None:
            self._is_locking = False
            if lock_notice(locked, self.lock, self._forget) is None:
                self._say(tr("LOCKED: the module says so."))
                then()
            else:
                self._question = None
                self._message = lambda: lock_notice(locked, self.lock, self._forget)
                self._say("")
            self.refresh()

        self._connector.lock(end)

    def _forget(self) -> None:
        self._message = None
        self.refresh()
