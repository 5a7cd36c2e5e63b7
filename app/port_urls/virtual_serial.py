"""Modem-line methods that pyserial expects of a port, for ports without wires."""

from abc import abstractmethod

from serial.serialutil import SerialBase


class VirtualSerial(SerialBase):
    """A port whose modem lines are constant, and whose writes never wait."""

    BAUDRATES = tuple(rate for rate in SerialBase.BAUDRATES if rate >= 1200)

    @abstractmethod
    def _source(self) -> object:
        """What the port leads to. Raises `SerialException` if it is closed or dead."""

    def flush(self) -> None:
        self._source()

    def reset_output_buffer(self) -> None:
        self._source()

    def cancel_write(self) -> None:
        """Nothing to cancel."""

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
