"""Serves the simulated module on a TCP socket, for pyserial's `socket://` (every platform)."""

import socket
from contextlib import suppress

READ_CHUNK = 65536


class TcpEndpoint:
    """Serves one client at a time; the next one waits."""

    def __init__(self, host: str, port: int) -> None:
        """Port 0 picks a free port. Raises OSError, also `socket.gaierror`, if it cannot listen."""
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        self._client: socket.socket | None = None
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._listener.bind(address)
            self._listener.listen(1)
            self._listener.setblocking(False)
        except OSError:
            self._listener.close()
            raise
        self.port: int = self._listener.getsockname()[1]
        shown_host = f"[{host}]" if ":" in host else host
        self.address = f"socket://{shown_host}:{self.port}"
        """A URL that pyserial opens."""

    def close(self) -> None:
        """Idempotent."""
        self._disconnect()
        self._listener.close()

    def files(self) -> list[int]:
        return [(self._client or self._listener).fileno()]

    def host_baud(self) -> int | None:
        """Unknown: a socket has no rate."""
        return None

    def receive(self, ready: list[int]) -> bytes:
        if self.files()[0] not in ready:
            return b""
        if self._client is None:
            with suppress(OSError):
                self._client, _ = self._listener.accept()
                self._client.setblocking(False)
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        try:
            data = self._client.recv(READ_CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._disconnect()
        return data

    def send(self, data: bytes) -> None:
        """Bytes that no client takes are lost."""
        if self._client is None:
            return
        try:
            self._client.send(data)
        except BlockingIOError:
            pass
        except OSError:
            self._disconnect()

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
