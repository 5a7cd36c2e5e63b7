"""Tells screen readers, once, wherever the focus is: triggered, active, locked, link lost, LOCK failed."""

from typing import Final

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QApplication, QWidget

from app.diagnosis.link_state import Phase, link_text
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, keep_away
from app.text.i18n import tr
from app.text.sentences import join_sentences
from ui.core.connector import Connector
from ui.core.port_connection import PortConnection
from ui.services.lock import LockControl, PortLock

_POLITENESS = QAccessible.AnnouncementPoliteness


class Announcer(QObject):
    """One per application: `announcer()`. For events only, not for values that change all the time."""

    announced = Signal(str, bool)
    """The text, and whether it was urgent."""

    def announce(self, text: str, *, is_urgent: bool = False) -> None:
        """`text` in the language in use. `is_urgent`: it interrupts what is being read."""
        speaker = _speaker()
        if not text or speaker is None:
            return
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
        self.announced.emit(text, is_urgent)


def _speaker() -> QWidget | None:
    """The active window, else the first visible one."""
    front = QApplication.activeWindow()
    return front or next((one for one in QApplication.topLevelWidgets() if one.isVisible()), None)


_one: Announcer | None = None


def announcer() -> Announcer:
    """The application's only `Announcer`."""
    global _one  # noqa: PLW0603  as Qt has one application
    if _one is None:
        _one = Announcer()
    return _one


_STANDS: Final = frozenset({Phase.ONLINE, Phase.LATE})
_LOST: Final = frozenset({Phase.OFFLINE, Phase.LOST, Phase.FAILED})


def announce_states(connector: Connector, lock: LockControl) -> None:
    """Of the modules on all ports, those that are added later too."""

    def add(connection: PortConnection) -> None:
        StateAnnouncer(connection, lock.of(connection), connector)

    for connection in connector.connections:
        add(connection)
    connector.added.connect(add)


class StateAnnouncer(QObject):
    """Each state once, when it becomes so. A doubt alone (an age, a question without an answer) is not told."""

    def __init__(self, connection: PortConnection, lock: PortLock, connector: Connector) -> None:
        super().__init__(connection)
        self._connection, self._lock, self._connector = connection, lock, connector
        self._is_linked = self._is_triggered = self._has_failed = False
        self._activation = Activation.UNKNOWN
        connection.changed.connect(self._poll)
        lock.changed.connect(self._poll)

    def _poll(self) -> None:
        self._announce_link()
        self._announce_trigger()
        self._announce_activation()
        failed, had_failed = self._lock.failed, self._has_failed
        self._has_failed = failed is not None
        if failed is not None and not had_failed:
            self._announce(failed.sentence, is_urgent=True)

    def _announce_link(self) -> None:
        connection = self._connection
        state = connection.state
        was, self._is_linked = self._is_linked, state.phase in _STANDS
        if was and state.phase in _LOST:
            self._activation, self._is_triggered = Activation.UNKNOWN, False  # told again when it answers again
            parts = [link_text(state, connection.clock()).what]
            if connection.is_active:
                parts += [tr(LAST_HEARD_ACTIVE), keep_away()]
            self._announce(join_sentences(parts), is_urgent=True)

    def _announce_trigger(self) -> None:
        is_triggered = self._connection.device.fresh("triggered", self._connection.clock())
        if is_triggered is None:
            return  # what was told stands until it is known
        was, self._is_triggered = self._is_triggered, is_triggered is True
        if self._is_triggered and not was:
            self._announce(tr("TRIGGERED"), is_urgent=True)

    def _announce_activation(self) -> None:
        state = self._connection.activation.state
        if state in (Activation.ACTIVE, Activation.LOCKED) and state is not self._activation:
            self._activation = state
            self._announce(tr("ACTIVE") if state is Activation.ACTIVE else tr("LOCKED"))

    def _announce(self, text: str, *, is_urgent: bool = False) -> None:
        if len(self._connector.connections) > 1 and self._connection.target is not None:
            text = f"{self._connection.target.device}: {text}"
        announcer().announce(text, is_urgent=is_urgent)
