"""pyserial URL handler for `capture://FILE?speed=1`; see `app.captures.player`.

No thread: each read computes what is due by the clock, and reads the file a little ahead.
"""

import errno
import threading
import time
from pathlib import Path
from typing import BinaryIO, Final

from serial.serialutil import PortNotOpenError, SerialException

from app.captures.player import Player, UrlRefused, parse_url, play, stop_playing
from app.captures.reader import CaptureRefused, OpenCapture
from app.captures.script import Script
from app.port_urls.virtual_serial import VirtualSerial
from app.system.gil_yield import GilYield

SHORTEST_SLEEP_S: Final = 0.0005
READING_TO_OPEN_S: Final = 0.1
"""How long opening reads the file; enough to answer the first query of a usual capture."""
READING_AT_ONCE_S: Final = 0.002


class Serial(VirtualSerial):
    """A port of pyserial's shape; `open`, `read`, `write` … as there."""

    _player: Player | None = None
    _file: BinaryIO | None = None
    _url = ""
    _received: bytearray = bytearray()
    _cancelled = threading.Event()

    def open(self) -> None:
        """Raises `SerialException` if the file cannot be read or is no capture."""
        if self.is_open:
            raise SerialException("Port is already open.")
        self._url = str(self.portstr)
        self._received = bytearray()
        self._cancelled = threading.Event()
        try:
            order = parse_url(self._url)
            self._file = Path(order.path).open("rb")  # noqa: SIM115  it is read until `close`
            capture = OpenCapture(self._file)
            script = Script(capture.steps(), lambda: capture.expected_s)
            self._player = play(self._url, script, speed=order.speed)
            self.is_open = True
            self._read_ahead(self._player, READING_TO_OPEN_S)
        except (UrlRefused, CaptureRefused) as error:
            self.close()
            raise SerialException(errno.EINVAL, f"could not open port {self.portstr}: {error}") from error
        except OSError as error:
            self.close()
            raise SerialException(error.errno, f"could not open port {self.portstr}: {error}") from error

    def close(self) -> None:
        """Idempotent."""
        player, self._player = self._player, None
        file, self._file = self._file, None
        self.is_open = False
        if player is not None:
            stop_playing(self._url, player)
        if file is not None:
            file.close()

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read now."""
        self._received += self._source().read(time.monotonic())
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes that arrive within the time-out. Raises `SerialException` if the file cannot be read."""
        player = self._source()
        deadline_s = time.monotonic() + (self.timeout or 0.0)
        while True:
            try:
                has_read = self._read_ahead(player, READING_AT_ONCE_S)
            except (CaptureRefused, OSError) as error:
                raise SerialException(errno.EIO, f"{self.portstr}: {error}") from error
            now_s = time.monotonic()
            self._received += player.read(now_s)
            if len(self._received) >= size or now_s >= deadline_s or self._cancelled.is_set():
                break
            due_s = now_s if has_read else player.next_due()
            ends_s = deadline_s if due_s is None else min(due_s, deadline_s)
            self._cancelled.wait(max(SHORTEST_SLEEP_S, ends_s - now_s))
        self._cancelled.clear()
        taken = bytes(self._received[:size])
        del self._received[:size]
        return taken

    def write(self, data: bytes, /) -> int:  # type: ignore[override]
        """Answer requests from the capture."""
        raw = bytes(data)
        self._source().write(raw, time.monotonic())
        return len(raw)

    def reset_input_buffer(self) -> None:
        self._source()
        self._received.clear()

    def cancel_read(self) -> None:
        """End a pending read, or the next one. Thread-safe."""
        self._cancelled.set()

    def _read_ahead(self, player: Player, longest_s: float) -> bool:
        """Read for about `longest_s`; whether there was something to read."""
        pace, ends_s, has_read = GilYield(), time.monotonic() + longest_s, False
        while (now_s := time.monotonic()) < ends_s and player.read_ahead(now_s):
            has_read = True
            pace.checkpoint()
        return has_read

    def _source(self) -> Player:
        if self._player is None or not self.is_open:
            raise PortNotOpenError
        return self._player

    def _reconfigure_port(self) -> None:
        """A capture has a fixed rate."""
