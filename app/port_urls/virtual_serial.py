"""Modem-line methods that pyserial expects of a port, for ports without wires."""

from serial.serialutil import SerialBase


class VirtualSerial(SerialBase):
    """Modem lines that are as if somebody were there, and cannot be changed."""

    BAUDRATES = tuple(rate for rate in SerialBase.BAUDRATES if rate >= 1200)

    def _update_rts_state(self) -> None:
        """No such wire."""

    def _update_dtr_state(self) -> None:
        """No such wire."""

    def _update_break_state(self) -> None:
        """No such wire."""

    @property
    def cts(self) -> bool:
        return True

    @property
    def dsr(self) -> bool:
        return True

    @property
    def ri(self) -> bool:
        return False

    @property
    def cd(self) -> bool:
        return True
