"""Simulated module: bytes and time in, bytes out, as the vendor's table says.

    power_on -> two heartbeats 50 ms apart -> answers, streams while serial output is on -> shut_down -> silence

No clock and no thread: every method takes `now_s`, seconds of one monotonic clock. The sensor is evaluated 200 times a
second, also afterwards, up to `MAX_WATCH_S` back.

Where the table does not tell, this module: answers `11 01` with 00 while it is locked, and does not fire; ends
"triggered" at the reset angle after an attitude trigger, and with `10 00`, `11 00` or a restart after others; blocks
all triggers from `11 00` until `11 01`, `10` or a restart; sends the oldest record first; does not answer invalid
frames.
"""

import math

from app.simulator.answers import answer
from app.simulator.hardware import Hardware, SentBytes
from protocol.catalogue import Request
from protocol.frame import requests_in

BROKEN_OFF_S = 0.1
"""After this much silence, a part of a frame is discarded."""


class SimulatedModule(Hardware):
    _heard = b""
    _last_byte_s = -math.inf

    def _clear(self) -> None:
        super()._clear()
        self._heard, self._last_byte_s = b"", -math.inf

    def receive(self, data: bytes, now_s: float) -> list[SentBytes]:
        """Takes bytes from the host; returns what is sent by now."""
        sent = self.collect(now_s)
        if not self.is_on:
            return sent
        for request in self._requests(data, now_s):
            if self.is_on:
                self.heard_s = now_s
                self.obey(request, now_s)
        return sent + self.collect(now_s)

    def obey(self, request: Request, now_s: float) -> None:
        """Carry out a request and queue the reply, unless it ignores the command."""
        if request.command.code not in self.setup.mute_codes:
            answer(self, request, now_s)

    def _requests(self, data: bytes, now_s: float) -> list[Request]:
        """The valid host frames that `data` completes; other bytes are skipped."""
        if now_s - self._last_byte_s > BROKEN_OFF_S:
            self._heard = b""
        self._last_byte_s = now_s
        requests, self._heard = requests_in(self._heard + data)
        return requests
