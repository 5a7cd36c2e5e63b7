"""pyserial's `capture://FILE?speed=1`: a port on which a capture is played; see `app.replay`.

No thread: what is due is worked out from the clock whenever somebody reads.
"""

import errno
import time
from pathlib import Path

from serial.serialutil import PortNotOpenError, SerialException

from app.capture import CaptureRefused, read_capture
from app.replay import Player, UrlRefused, parse_url, play, stop_playing
from app.simulator.wireless import WirelessSerial

SHORTEST_SLEEP_S = 0.0005


class Serial(WirelessSerial):
    """A port of pyserial's shape; `open`, `read`, `write` … as there."""

    _player: Player | None = None
    _url = ""
    _received: bytearray = bytearray()

    def open(self) -> None:
        """Raises `SerialException` where the file cannot be read, or is no capture."""
        if self.is_open:
            raise SerialException("Port is already open.")
        self._url = str(self.portstr)
        try:
            order = parse_url(self._url)
            capture = read_capture(Path(order.path))
        except (UrlRefused, CaptureRefused) as error:
            raise SerialException(errno.EINVAL, f"could not open port {self.portstr}: {error}") from error
        except OSError as error:
            raise SerialException(error.errno, f"could not open port {self.portstr}: {error}") from error
        self._received = bytearray()
        self._player = play(self._url, capture, speed=order.speed)
        self.is_open = True

    def close(self) -> None:
        """Idempotent."""
        player, self._player = self._player, None
        self.is_open = False
        if player is not None:
            stop_playing(self._url, player)

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read now."""
        self._received += self._living().read(time.monotonic())
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes, those that came within the time-out."""
        player = self._living()
        deadline_s = time.monotonic() + (self.timeout or 0.0)
        while True:
            now_s = time.monotonic()
            self._received += player.read(now_s)
            if len(self._received) >= size or now_s >= deadline_s:
                break
            due_s = player.next_due()
            ends_s = deadline_s if due_s is None else min(due_s, deadline_s)
            time.sleep(max(SHORTEST_SLEEP_S, ends_s - now_s))
        taken = bytes(self._received[:size])
        del self._received[:size]
        return taken

    def write(self, data: bytes, /) -> int:  # type: ignore[override]
        """Asks the capture."""
        raw = bytes(data)
        self._living().write(raw, time.monotonic())
        return len(raw)

    def flush(self) -> None:
        self._living()

    def reset_input_buffer(self) -> None:
        self._living()
        self._received.clear()

    def reset_output_buffer(self) -> None:
        self._living()

    def _living(self) -> Player:
        if self._player is None or not self.is_open:
            raise PortNotOpenError
        return self._player

    def _reconfigure_port(self) -> None:
        """A capture has the rate at which it was taken."""
