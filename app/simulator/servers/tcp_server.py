"""Serves the simulated module on a TCP socket, for pyserial's `socket://` (every platform)."""

import socket
from contextlib import suppress

READ_CHUNK = 65536


class TcpEndpoint:
    """Serves one client at a time; the next one waits."""

    def __init__(self, host: str, port: int) -> None:
        """Port 0 picks a free port. Raises OSError, also `socket.gaierror`, if it cannot listen."""
        self._host = host
        self._listener: socket.socket | None = None
        self._client: socket.socket | None = None
        self._port = port
        self._listen()

    @property
    def address(self) -> str | None:
        """A URL that pyserial opens."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"socket://{host}:{self._port}" if self._listener is not None else None

    @property
    def port(self) -> int:
        return self._port

    def plug(self) -> None:
        if self._listener is None:
            self._listen()

    def unplug(self) -> None:
        """Idempotent."""
        self._disconnect()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    def files(self) -> list[int]:
        if self._client is not None:
            return [self._client.fileno()]
        return [] if self._listener is None else [self._listener.fileno()]

    def host_baud(self) -> int | None:
        """Unknown: a socket has no rate."""
        return None

    def receive(self, ready: list[int]) -> bytes:
        if self._client is None:
            if self._listener is not None and self._listener.fileno() in ready:
                self._accept(self._listener)
            return b""
        if self._client.fileno() not in ready:
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

    def _listen(self) -> None:
        family, _, _, _, address = socket.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(address)
            listener.listen(1)
            listener.setblocking(False)
        except OSError:
            listener.close()
            raise
        self._listener = listener
        self._port = listener.getsockname()[1]

    def _accept(self, listener: socket.socket) -> None:
        with suppress(OSError):
            self._client, _ = listener.accept()
            self._client.setblocking(False)
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
