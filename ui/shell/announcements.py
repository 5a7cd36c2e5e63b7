"""Tells screen readers, once, wherever the focus is: triggered, active, locked, link lost, LOCK failed. The system's
bell rings for what concerns people near a module, once a person has chosen that."""

from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from app.diagnosis.link_state import Phase, link_text
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, keep_away
from app.text.i18n import tr
from app.text.messages import join_sentences
from ui.core.preferences import Preferences
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import UNTOLD
from ui.style.appearance import announce

_LINKED: Final = (Phase.ONLINE, Phase.LATE)
_LOST: Final = (Phase.OFFLINE, Phase.LOST, Phase.FAILED)


class StateAnnouncer(QObject):
    """It announces the states of the modules on all ports. Each state once, when it becomes so: a doubt alone (an age,
    a question without an answer) is not told."""

    def __init__(self, ports: Ports, preferences: Preferences) -> None:
        super().__init__(ports)
        self._ports, self._preferences = ports, preferences
        for port in ports.all:
            self._add(port)
        ports.added.connect(self._add)

    def _add(self, port: Port) -> None:
        """What was told of this port is kept in here."""
        told, is_triggered, is_linked, has_failed = Activation.UNKNOWN, False, False, False

        def reset() -> None:
            """Nothing is told yet of the module that answers from now on."""
            nonlocal told, is_triggered
            told, is_triggered = Activation.UNKNOWN, False

        def say(text: str, *, is_urgent: bool = False) -> None:
            if len(self._ports.all) > 1 and port.target is not None:
                text = f"{port.target.device}: {text}"
            announce(text, is_urgent=is_urgent)

        def poll() -> None:
            nonlocal told, is_triggered, is_linked, has_failed
            module, state = port.module, port.state
            was_linked, is_linked = is_linked, state.phase in _LINKED
            if was_linked and state.phase in _LOST:
                reset()  # told again when it answers again
                if module.end is None or module.end.reason not in UNTOLD:
                    parts = [link_text(state, port.now_s).what]
                    if port.is_active:
                        parts += [tr(LAST_HEARD_ACTIVE), keep_away()]
                        self._ring()
                    say(join_sentences(parts), is_urgent=True)
            was_triggered, triggered = is_triggered, module.view.fresh("triggered", port.now_s)
            if triggered is not None:  # else what was told stands
                is_triggered = triggered is True
            if is_triggered and not was_triggered:
                self._ring()
                say(tr("TRIGGERED"), is_urgent=True)
            activation = module.activation.state
            if activation in (Activation.ACTIVE, Activation.LOCKED) and activation is not told:
                told = activation
                if activation is Activation.ACTIVE:
                    self._ring()
                say(tr("ACTIVE") if activation is Activation.ACTIVE else tr("LOCKED"))
            failed, had_failed = port.lock.failed, has_failed
            has_failed = failed is not None
            if failed is not None and not had_failed:
                say(failed.sentence, is_urgent=True)

        port.module_changed.connect(reset)
        port.changed.connect(poll)
        port.lock.changed.connect(poll)

    def _ring(self) -> None:
        if self._preferences.has_sounds:
            QApplication.beep()
