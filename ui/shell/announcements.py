"""Tells screen readers, once, wherever the focus is: triggered, active, locked, link lost, LOCK failed; and plays the
sounds for what concerns people near a module, which are off until a person chooses them."""

import math
import shutil
import sys
import tempfile
from enum import Enum
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from app.diagnosis.link_state import Phase
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, keep_away
from app.text.i18n import tr
from app.text.messages import join_sentences
from ui.core.background_task import BackgroundTask
from ui.core.preferences import Preferences
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.shown_module import UNTOLD
from ui.style.appearance import announce

_LINKED: Final = (Phase.ONLINE, Phase.LATE)
_LOST: Final = (Phase.OFFLINE, Phase.LOST, Phase.FAILED)
_PLAYERS: Final = (("afplay",), ("pw-play",), ("paplay",), ("aplay", "-q"))
_RATE: Final = 16_000


class Sound(Enum):
    """The value is its tones in Hz."""

    TRIGGERED = (1175, 880, 1175, 880, 1175, 880)
    ACTIVE = (660, 880)
    LOST_WHILE_ACTIVE = (880, 440, 880, 440)


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
                    parts = [state.what]
                    if port.is_active:
                        parts += [tr(LAST_HEARD_ACTIVE), keep_away()]
                        self.play(Sound.LOST_WHILE_ACTIVE)
                    say(join_sentences(parts), is_urgent=True)
            was_triggered, triggered = is_triggered, module.view.fresh("triggered", port.now_s)
            if triggered is not None:  # else what was told stands
                is_triggered = triggered is True
            if is_triggered and not was_triggered:
                self.play(Sound.TRIGGERED)
                say(tr("TRIGGERED"), is_urgent=True)
            activation = module.activation.state
            if activation in (Activation.ACTIVE, Activation.LOCKED) and activation is not told:
                told = activation
                if activation is Activation.ACTIVE:
                    self.play(Sound.ACTIVE)
                say(tr("ACTIVE") if activation is Activation.ACTIVE else tr("LOCKED"))
            failed, had_failed = port.lock.failed, has_failed
            has_failed = failed is not None
            if failed is not None and not had_failed:
                say(failed.sentence, is_urgent=True)

        port.module_changed.connect(reset)
        port.changed.connect(poll)
        port.lock.changed.connect(poll)

    def play(self, sound: Sound) -> None:
        """No window waits for a player: one that fails is followed by the next, and the last by the system's bell."""
        if self._preferences.has_sounds:
            task: BackgroundTask[bool] = BackgroundTask("dps-s sound", self, for_once=True)
            task.run(lambda _running: is_played(sound), lambda has_played: has_played or QApplication.beep(), _fail)


def _fail(error: Exception) -> None:
    QApplication.beep()
    if not isinstance(error, OSError | RuntimeError):  # a full disk; no device to play on
        raise error


def is_played(sound: Sound) -> bool:
    """Play it with the first player that works; whether one did. Takes as long as the sound. Raises OSError."""
    with tempfile.TemporaryDirectory(prefix="dps-s-", ignore_cleanup_errors=True) as folder:
        path = Path(folder) / f"{sound.name.lower()}.wav"
        write_tones(path, sound.value)
        if sys.platform == "win32":
            import winsound

            winsound.PlaySound(str(path), winsound.SND_FILENAME)
            return True
        import subprocess  # the first paint does not wait for it

        nothing = subprocess.DEVNULL
        for name, *options in _PLAYERS:
            program = shutil.which(name)
            if program is None:
                continue
            command = [program, *options, str(path)]
            try:
                # A program of the system with constant arguments; a sound server that does not answer keeps it waiting.
                done = subprocess.run(  # noqa: S603
                    command, stdin=nothing, stdout=nothing, stderr=nothing, timeout=5.0, check=False
                )
            except (OSError, subprocess.TimeoutExpired):
                continue
            if done.returncode == 0:
                return True
    return False


def write_tones(path: Path, tones: tuple[int, ...]) -> None:
    """Write the files of the sounds. Raises OSError."""
    import wave

    count = int(_RATE * 0.15)  # s for each tone
    data = bytearray()
    for tone in tones:
        for place in range(count):
            swell = math.sin(math.pi * place / count)  # without a click at either end
            value = round(24_000 * swell * math.sin(2 * math.pi * tone * place / _RATE))
            data += value.to_bytes(2, "little", signed=True)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(_RATE)
        file.writeframes(bytes(data))
