"""What is told at once: announcements of screen readers, and sounds.

No window waits for a player: one that fails is followed by the next, and the last by the system's bell.

The first two, and a lost link to an active module, have a sound, too.
"""

import math
import shutil
import subprocess
import sys
import tempfile
import wave
from enum import Enum
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from app.diagnosis.link_state import Phase, link_text
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, keep_away
from app.text.i18n import tr
from app.text.messages import join_sentences
from ui.core.background_task import BackgroundTask
from ui.core.preferences import Preferences
from ui.session.interruptions import UNTOLD
from ui.session.port import Port
from ui.session.ports import Ports
from ui.style.appearance import announce

_PLAYERS: Final = (("afplay",), ("pw-play",), ("paplay",), ("aplay", "-q"))
# A sound server that does not answer keeps its player waiting.
LIMIT_S: Final = 5.0
_RATE: Final = 16_000
_TONE_S: Final = 0.15
_LOUDNESS: Final = 24_000


class Sound(Enum):
    """The value is its tones in Hz."""

    TRIGGERED = (1175, 880, 1175, 880, 1175, 880)
    ACTIVE = (660, 880)
    LOST_WHILE_ACTIVE = (880, 440, 880, 440)


class Sounds(QObject):
    def __init__(self, preferences: Preferences, parent: QObject) -> None:
        super().__init__(parent)
        self._preferences = preferences

    def play(self, sound: Sound) -> None:
        if self._preferences.has_sounds:
            task: BackgroundTask[bool] = BackgroundTask("dps-s sound", self, for_once=True)
            task.run(lambda _running: is_played(sound), _beep_unless, _fail)


def _beep_unless(has_played: bool) -> None:
    if not has_played:
        QApplication.beep()


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
        for name, *options in _PLAYERS:
            program = shutil.which(name)
            if program is not None and _has_run([program, *options, str(path)]):
                return True
    return False


def _has_run(command: list[str]) -> bool:
    try:
        # A program of the system with constant arguments.
        done = subprocess.run(  # noqa: S603
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=LIMIT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def write_tones(path: Path, tones: tuple[int, ...]) -> None:
    """Raises OSError."""
    count = int(_RATE * _TONE_S)
    data = bytearray()
    for tone in tones:
        for place in range(count):
            swell = math.sin(math.pi * place / count)  # without a click at either end
            value = round(_LOUDNESS * swell * math.sin(2 * math.pi * tone * place / _RATE))
            data += value.to_bytes(2, "little", signed=True)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(_RATE)
        file.writeframes(bytes(data))


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
