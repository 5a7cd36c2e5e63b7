"""Short alert tones, generated here and played by a program of the system."""

import math
import shutil
import struct
import subprocess
import sys
import tempfile
import wave
from enum import Enum
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Final

RATE_HZ: Final = 22_050
_VOLUME: Final = 0.5
_FADE_S: Final = 0.01
_PLAYERS: Final = ("pw-play", "paplay", "aplay", "afplay")


class Tone(Enum):
    """Notes of each tone: frequency in Hz, duration in seconds. All are distinguishable."""

    TRIGGERED = ((988.0, 0.12), (988.0, 0.12), (1319.0, 0.3))
    LOST = ((523.0, 0.18), (349.0, 0.28))
    RESTARTED = ((523.0, 0.12), (659.0, 0.12))


@cache
def wav(tone: Tone) -> bytes:
    """The tone as a WAV file: one channel, 16 bits."""
    samples: list[int] = []
    for hertz, seconds in tone.value:
        count = round(RATE_HZ * seconds)
        fade = round(RATE_HZ * _FADE_S)
        for number in range(count):
            edge = min(1.0, number / fade, (count - 1 - number) / fade)
            samples.append(round(32_767 * _VOLUME * edge * math.sin(math.tau * hertz * number / RATE_HZ)))
    target = BytesIO()
    with wave.open(target, "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(struct.pack(f"<{len(samples)}h", *samples))
    return target.getvalue()


class TonePlayer:
    """Plays asynchronously."""

    def __init__(self) -> None:
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._running: list[subprocess.Popen[bytes]] = []

    def play(self, tone: Tone) -> bool:
        """Return whether the system has a player."""
        path = self._file(tone)
        if path is None:
            return False
        if sys.platform == "win32":
            import winsound

            winsound.PlaySound(str(path), winsound.SND_FILENAME | winsound.SND_ASYNC | winsound.SND_NODEFAULT)
            return True
        player = next((found for name in _PLAYERS if (found := shutil.which(name)) is not None), None)
        if player is None:
            return False
        self._running = [one for one in self._running if one.poll() is None]
        try:
            self._running.append(
                subprocess.Popen(  # noqa: S603  a program of the system, found by name, on a file of ours
                    [player, str(path)],
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )
            )  # fmt: skip
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Delete the files without waiting for a tone."""
        for one in self._running:
            one.kill()
            one.wait()
        self._running.clear()
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def _file(self, tone: Tone) -> Path | None:
        try:
            if self._folder is None:
                self._folder = tempfile.TemporaryDirectory(prefix="dps-s-tones-", ignore_cleanup_errors=True)
            path = Path(self._folder.name) / f"{tone.name.lower()}.wav"
            if not path.exists():
                path.write_bytes(wav(tone))
        except OSError:
            return None
        return path
