"""Tells screen readers what becomes of the module: triggered, active, locked, link lost, LOCK failed."""

from typing import Final

from PySide6.QtCore import QObject

from app.diagnosis.link_state import Phase, words
from app.safety.last_known import Activation
from app.text.i18n import tr
from app.text.sentences import together
from ui.core.announcer import announcer
from ui.core.connector import Connector
from ui.services.lock import LockControl

_STANDS: Final = frozenset({Phase.ONLINE, Phase.LATE})
_LOST: Final = frozenset({Phase.OFFLINE, Phase.LOST, Phase.FAILED})


class StateAnnouncer(QObject):
    """Each once, when it becomes so. A doubt alone (an age, a question without an answer) is not told."""

    def __init__(self, connector: Connector, lock: LockControl, parent: QObject) -> None:
        super().__init__(parent)
        self._connector, self._lock = connector, lock
        self._is_linked = self._is_triggered = self._has_failed = False
        self._activation = Activation.UNKNOWN
        connector.changed.connect(self._look)
        lock.changed.connect(self._look)

    def _look(self) -> None:
        if self._connector.is_recording:
            return  # nothing of it is so now
        self._look_at_trigger()
        self._look_at_activation()
        self._look_at_link()
        failed, had_failed = self._lock.failed, self._has_failed
        self._has_failed = failed is not None
        if failed is not None and not had_failed:
            announcer().say(failed.sentence, is_urgent=True)

    def _look_at_trigger(self) -> None:
        known = self._connector.device.fresh("triggered", self._connector.clock())
        if known is None:
            return  # what it was stands until it is known
        was, self._is_triggered = self._is_triggered, known is True
        if self._is_triggered and not was:
            announcer().say(tr("TRIGGERED"), is_urgent=True)

    def _look_at_activation(self) -> None:
        state = self._connector.activation.state
        if state not in (Activation.ACTIVE, Activation.LOCKED):
            return
        was, self._activation = self._activation, state
        if state is not was:
            announcer().say(tr("ACTIVE") if state is Activation.ACTIVE else tr("LOCKED"))

    def _look_at_link(self) -> None:
        connector = self._connector
        state = connector.state
        if self._is_linked and state.phase in _LOST:
            self._activation, self._is_triggered = Activation.UNKNOWN, False  # told again when it answers again
            said = words(state, connector.clock())
            parts = [said.what]
            if connector.is_active:
                parts.append(tr("The module was ACTIVE when it was last heard: treat it as ready to fire."))
            announcer().say(together(parts), is_urgent=True)
        if state.phase in _STANDS or state.phase in _LOST or state.phase is Phase.CLOSED:
            self._is_linked = state.phase in _STANDS
