"""Tells screen readers, once, wherever the focus is: triggered, active, locked, link lost, LOCK failed.

The first two, and a lost link to an active module, have a sound, too.
"""

from typing import Final

from PySide6.QtCore import QObject

from app.diagnosis.link_state import Phase, link_text
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, keep_away
from app.text.i18n import tr
from app.text.sentences import join_sentences
from ui.session.interruptions import UNTOLD
from ui.session.port import Port
from ui.session.ports import Ports
from ui.shell.sounds import Sound, Sounds
from ui.style.accessible_roles import announce

_LINKED: Final = frozenset({Phase.ONLINE, Phase.LATE})
_LOST: Final = frozenset({Phase.OFFLINE, Phase.LOST, Phase.FAILED})


def announce_states(ports: Ports, sounds: Sounds) -> None:
    """Of the modules on all ports, those that are added later too."""

    def add(port: Port) -> None:
        StateAnnouncer(port, ports, sounds)

    for port in ports.all:
        add(port)
    ports.added.connect(add)


class StateAnnouncer(QObject):
    """Each state once, when it becomes so. A doubt alone (an age, a question without an answer) is not told."""

    def __init__(self, port: Port, ports: Ports, sounds: Sounds) -> None:
        super().__init__(port)
        self._port, self._ports, self._sounds = port, ports, sounds
        self._is_linked = self._has_failed = False
        self._reset()
        port.module_changed.connect(self._reset)
        port.changed.connect(self._poll)
        port.lock.changed.connect(self._poll)

    def _reset(self) -> None:
        """Nothing is told yet of the module that answers from now on."""
        self._activation, self._is_triggered = Activation.UNKNOWN, False

    def _poll(self) -> None:
        self._announce_link()
        self._announce_trigger()
        self._announce_activation()
        failed, had_failed = self._port.lock.failed, self._has_failed
        self._has_failed = failed is not None
        if failed is not None and not had_failed:
            self._announce(failed.sentence, is_urgent=True)

    def _announce_link(self) -> None:
        port = self._port
        state = port.state
        was, self._is_linked = self._is_linked, state.phase in _LINKED
        if was and state.phase in _LOST:
            self._reset()  # told again when it answers again
            if port.module.end is not None and port.module.end.reason in UNTOLD:
                return
            parts = [link_text(state, port.now_s).what]
            if port.is_active:
                parts += [tr(LAST_HEARD_ACTIVE), keep_away()]
                self._sounds.play(Sound.LOST_WHILE_ACTIVE)
            self._announce(join_sentences(parts), is_urgent=True)

    def _announce_trigger(self) -> None:
        is_triggered = self._port.module.view.fresh("triggered", self._port.now_s)
        if is_triggered is None:
            return  # what was told stands until it is known
        was, self._is_triggered = self._is_triggered, is_triggered is True
        if self._is_triggered and not was:
            self._sounds.play(Sound.TRIGGERED)
            self._announce(tr("TRIGGERED"), is_urgent=True)

    def _announce_activation(self) -> None:
        state = self._port.module.activation.state
        if state in (Activation.ACTIVE, Activation.LOCKED) and state is not self._activation:
            self._activation = state
            if state is Activation.ACTIVE:
                self._sounds.play(Sound.ACTIVE)
            self._announce(tr("ACTIVE") if state is Activation.ACTIVE else tr("LOCKED"))

    def _announce(self, text: str, *, is_urgent: bool = False) -> None:
        if len(self._ports.all) > 1 and self._port.target is not None:
            text = f"{self._port.target.device}: {text}"
        announce(text, is_urgent=is_urgent)
