"""Sounds for what concerns people near a module, played by the system's own player: off until a person chooses them.

No window waits for a player: one that fails is followed by the next, and the last by the system's bell.
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

from ui.core.background_task import BackgroundTask
from ui.core.preferences import Preferences

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
