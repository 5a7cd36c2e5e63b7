"""A serial port with a call that does not return."""

import threading
from typing import Any

import serial

READ_S = 0.01


class StubbornPort:
    """Stands in for pyserial's port. The call `sticks_in` blocks until `release`; no data ever arrives."""

    def __init__(self, sticks_in: str) -> None:
        self._sticks_in = sticks_in
        self._may_go_on = threading.Event()
        self.is_stuck = threading.Event()
        """Set once the call blocks."""
        self.baudrate = 115200
        self.exclusive = self.dtr = self.rts = False
        self.timeout = READ_S

    def __call__(self, _port: str, **options: Any) -> "StubbornPort":
        """Stand in for `serial_for_url`."""
        self.baudrate = options["baudrate"]
        return self

    def release(self) -> None:
        self._may_go_on.set()

    def _call(self, name: str) -> None:
        if name == self._sticks_in and not self._may_go_on.is_set():
            self.is_stuck.set()
            self._may_go_on.wait()
            raise serial.SerialException("the driver gave up")

    def open(self) -> None:
        self._call("open")

    @property
    def in_waiting(self) -> int:
        self._call("in_waiting")
        return 0

    def read(self, _size: int = 1) -> bytes:
        self._call("read")
        self._may_go_on.wait(0 if self._may_go_on.is_set() else self.timeout)
        return b""

    def write(self, data: bytes) -> int:
        self._call("write")
        return len(data)

    def reset_input_buffer(self) -> None:
        self._call("reset_input_buffer")

    def reset_output_buffer(self) -> None:
        self._call("reset_output_buffer")

    def cancel_read(self) -> None:
        """Has no effect, as on a driver that hangs."""

    def cancel_write(self) -> None:
        """Has no effect, as on a driver that hangs."""

    def close(self) -> None:
        self._call("close")
