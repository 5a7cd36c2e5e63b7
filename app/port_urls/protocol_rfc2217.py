"""pyserial URL handler for `rfc2217://HOST:PORT`: pyserial's, with a limit of writing and a reader that ends quietly.

pyserial's refuses every `write_timeout`, lets a write wait for five seconds, and prints what ended its reading thread.
"""

import logging
import socket

import serial.rfc2217

_log = logging.getLogger(__name__)


class Rfc2217Port(serial.rfc2217.Serial):
    _write_timeout: float | None
    _socket: socket.socket | None

    def _reconfigure_port(self) -> None:
        limit_s = self._write_timeout
        self._write_timeout = None  # else it raises NotImplementedError
        try:
            super()._reconfigure_port()  # type: ignore[misc]
        finally:
            self._write_timeout = limit_s
        if self._socket is not None:
            self._socket.settimeout(limit_s)

    def _telnet_read_loop(self) -> None:
        try:
            super()._telnet_read_loop()  # type: ignore[misc]
        except Exception as error:  # noqa: BLE001  pyserial's, of what is no RFC 2217; reading says that the thread ended
            _log.warning("the answers of %s are no RFC 2217: %r", self.portstr, error)


def serial_class_for_url(url: str) -> tuple[str, type[Rfc2217Port]]:
    return url, Rfc2217Port
