"""Frames as this module understands them, written from the vendor's table and not from the product."""

from typing import NamedTuple

FROM_HOST = b"\x42\x61"
FROM_MODULE = b"\x41\x75"
HEARTBEAT_BODY = b"\xa5\x5a"
SET = 0x02
HOST_FRAME_BYTES = 6
RATES = {1: 4800, 2: 9600, 3: 19200, 4: 38400, 5: 57600, 6: 115200}


class Question(NamedTuple):
    """One frame of the host: its code (D2), control byte (D3) and value (D4)."""

    code: int
    control: int
    value: int

    @property
    def is_set(self) -> bool:
        return self.control == SET

    @property
    def frame(self) -> bytes:
        return with_sum(FROM_HOST + bytes(self))


def with_sum(frame: bytes) -> bytes:
    """Add the low 8 bits of the sum of D2 onwards."""
    return frame + bytes((sum(frame[2:]) % 256,))


def answer(code: int, body: bytes) -> bytes:
    """Return a frame of the module; `body` is what stands between the code and the sum."""
    return with_sum(FROM_MODULE + bytes((code,)) + body)


class Ear:
    """Finds the host's frames in what arrives, in any pieces. Of what is no frame it gives up one byte at a time."""

    def __init__(self) -> None:
        self._waiting = bytearray()
        self.dropped = bytearray()

    def hear(self, data: bytes) -> list[Question]:
        """Return the frames that are complete now; what was no frame is added to `dropped`."""
        self._waiting += data
        found: list[Question] = []
        while len(self._waiting) >= HOST_FRAME_BYTES:
            frame = bytes(self._waiting[:HOST_FRAME_BYTES])
            if frame[:2] == FROM_HOST and with_sum(frame[:-1]) == frame:
                found.append(Question(frame[2], frame[3], frame[4]))
                del self._waiting[:HOST_FRAME_BYTES]
            else:
                self.dropped.append(self._waiting.pop(0))
        return found

    def forget(self) -> None:
        self._waiting.clear()
