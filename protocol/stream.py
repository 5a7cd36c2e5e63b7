"""Incremental parser of the serial line: bytes in, frames and rejected bytes out.

Rules:

- A frame needs a header, its length, the right checksum and an allowed value. Header bytes also occur in data (41 is
  65°, 75 is 11.7 g), so where no frame begins only one byte is rejected, and the search goes on after it.
- How the stream was cut into pieces changes neither the frames nor the number of bytes rejected for each reason.
- Every byte ends up in exactly one frame or one `Noise`, in order.
- Fewer than `MAX_FRAME_LENGTH` bytes are kept between two calls.
- The meaning of a code-35 frame depends on the request (E3): `41 75 35 01 CA 00` begins a record and is also a valid
  voltage. While a cell voltage is asked for, six bytes are enough; while records are asked for, they never are.
  Otherwise the parser waits for sixteen bytes, and takes six only where another header or silence (`flush`) follows:
  a record that broke off or was corrupted after its sixth byte must not become a voltage.
"""

import re

from protocol.catalogue import (
    BY_CODE,
    CELL_VOLTAGE,
    HOST_HEADER,
    MODULE_HEADER,
    QUERY,
    RECORD_CODE,
    TRIGGER_RECORDS,
    Layout,
    Request,
)
from protocol.messages import (
    HOST_FRAME_LENGTH,
    MAX_FRAME_LENGTH,
    Direction,
    Frame,
    Noise,
    Reason,
    check_host,
    check_module,
    decode_request,
)

_HEADER = re.compile(b"Au|Ba")
_HEADER_STARTS = b"AB"
_SHORT_LENGTH = Layout.SHORT.value
_AFTER_A_FRAME = (b"", MODULE_HEADER, HOST_HEADER)
_TO_HOST = Direction.MODULE_TO_HOST

Piece = Frame | Noise


class StreamParser:
    """Incremental parser of one line; see the module's docstring.

    `asked` is the request in flight, or None. With `follows_host` it is taken from the host's frames in the stream
    (a capture of both directions).
    """

    def __init__(self, *, asked: Request | None = None, follows_host: bool = False) -> None:
        self.asked = asked
        self._follows_host = follows_host
        self._pending = b""
        self._offset = 0
        # Why the bytes are rejected that come before the next frame, or pause.
        self._reason = Reason.NO_HEADER

    @property
    def end(self) -> int:
        """Offset behind the last byte so far."""
        return self._offset + len(self._pending)

    @property
    def pending(self) -> int:
        """The number of bytes kept until more arrive, 0 … 15."""
        return len(self._pending)

    def feed(self, data: bytes) -> list[Piece]:
        """Return the frames and rejected bytes that `data` completes."""
        return self._parse(self._pending + data, is_final=False)

    def flush(self) -> list[Piece]:
        """Decide about the pending bytes: the line has been quiet, so nothing more belongs to them."""
        pieces = self._parse(self._pending, is_final=True) if self._pending else []
        self._reason = Reason.NO_HEADER  # bytes after a pause do not belong to the frame that broke off
        return pieces

    def _parse(self, data: bytes, *, is_final: bool) -> list[Piece]:
        pieces: list[Piece] = []
        position = rejected_from = 0

        def reject() -> None:
            """The bytes since the last frame, or since they are rejected for another reason."""
            if rejected_from < position:
                raw = data[rejected_from:position]
                pieces.append(Noise(raw, self._reason, self._offset + rejected_from))

        while position < len(data):
            header = _HEADER.search(data, position)
            if header is None:
                keeps_last = not is_final and data[-1] in _HEADER_STARTS
                position = len(data) - 1 if keeps_last else len(data)
                break
            position = header.start()
            outcome = self._candidate(data, position, is_final=is_final)
            if outcome is None:
                break
            if isinstance(outcome, Frame):
                reject()
                pieces.append(outcome)
                self._reason = Reason.NO_HEADER
                if self._follows_host and outcome.direction is Direction.HOST_TO_MODULE:
                    self.asked = decode_request(outcome.raw)
                position = rejected_from = position + len(outcome.raw)
            else:
                if outcome is not self._reason:
                    reject()
                    self._reason, rejected_from = outcome, position
                position += 1
        reject()
        self._pending = data[position:]
        self._offset += position
        return pieces

    def _candidate(self, data: bytes, position: int, *, is_final: bool) -> Frame | Reason | None:
        """The frame at this header, why there is none, or None while more bytes are needed."""
        needs = Reason.INCOMPLETE if is_final else None
        available = len(data) - position
        offset = self._offset + position
        if data[position : position + 2] != MODULE_HEADER:
            if available < HOST_FRAME_LENGTH:
                return needs
            raw = data[position : position + HOST_FRAME_LENGTH]
            return check_host(raw) or Frame(Direction.HOST_TO_MODULE, raw, offset)
        if available < 3:
            return needs
        code = data[position + 2]
        if code not in BY_CODE:
            return Reason.UNKNOWN_CODE
        if code == RECORD_CODE:
            return self._record_or_voltage(data[position : position + MAX_FRAME_LENGTH], offset, is_final=is_final)
        length = BY_CODE[code].layout.value
        if available < length:
            return needs
        raw = data[position : position + length]
        return check_module(raw) or Frame(_TO_HOST, raw, offset)

    def _record_or_voltage(self, raw: bytes, offset: int, *, is_final: bool) -> Frame | Reason | None:
        asked = self.asked.command if self.asked is not None else None
        if len(raw) > 3 and raw[3] != QUERY:
            return Reason.CONTROL
        voltage = raw[:_SHORT_LENGTH]
        if len(voltage) < _SHORT_LENGTH:
            return Reason.INCOMPLETE if is_final else None
        not_voltage = check_module(voltage)
        if not_voltage is None and asked is CELL_VOLTAGE:
            return Frame(_TO_HOST, voltage, offset)
        if len(raw) < MAX_FRAME_LENGTH and not is_final:
            return None
        # Only with a frame or silence after the six bytes can they be a late voltage.
        stands_alone = asked is not TRIGGER_RECORDS and raw[_SHORT_LENGTH : _SHORT_LENGTH + 2] in _AFTER_A_FRAME
        if not_voltage is None and stands_alone:
            return Frame(_TO_HOST, voltage, offset)
        not_record = check_module(raw) if len(raw) == MAX_FRAME_LENGTH else Reason.INCOMPLETE
        if not_record is None:
            return Frame(_TO_HOST, raw, offset)
        is_short = asked is CELL_VOLTAGE or len(raw) == _SHORT_LENGTH
        return not_voltage if is_short and not_voltage is not None else not_record
