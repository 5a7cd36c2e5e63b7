"""What may stand at the other end of a network address: serial servers that work, and such as do not. POSIX only."""

import select
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import SimpleNamespace

import serial
import serial.rfc2217

from tests.support.patience import PATIENCE_S

Handler = Callable[[socket.socket, threading.Event], None]
"""Serves one client until it leaves or the event is set."""
_SLICE_S = 0.02
CHUNK = 4096


@contextmanager
def serving(handler: Handler) -> Iterator[str]:
    """Serve one client after the other on a free port; the value is `HOST:PORT`."""
    ended = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def run() -> None:
            while not ended.is_set():
                if select.select([listener], [], [], _SLICE_S)[0]:
                    client, _ = listener.accept()
                    with client, suppress(ConnectionError):
                        handler(client, ended)

        thread = threading.Thread(target=run, name="tcp peer")
        thread.start()
        try:
            yield f"127.0.0.1:{listener.getsockname()[1]}"
        finally:
            ended.set()
            thread.join(PATIENCE_S)


def closing(client: socket.socket, _ended: threading.Event) -> None:
    """Close the connection at the first bytes."""
    client.recv(CHUNK)


class _WithoutLines(serial.Serial):
    """A pseudo-terminal has no modem lines, and pyserial's server asks for and sets all."""

    cts = dsr = ri = cd = False
    dtr = rts = False


@contextmanager
def serial_server(device: str, *, is_rfc2217: bool = False) -> Iterator[str]:
    """Hand bytes on between a client and a serial port as ser2net's raw mode, or by RFC 2217 with pyserial's own
    server, where the client sets the rate and the lines of the port."""
    with _WithoutLines(device, 115200, timeout=0) as port:

        def serve(client: socket.socket, ended: threading.Event) -> None:
            manager = serial.rfc2217.PortManager(port, SimpleNamespace(write=client.sendall)) if is_rfc2217 else None
            while not ended.is_set():
                ready, _, _ = select.select([client.fileno(), port.fileno()], [], [], _SLICE_S)
                if client.fileno() in ready:
                    data = client.recv(CHUNK)
                    if not data:
                        return
                    port.write(data if manager is None else b"".join(manager.filter(data)))
                if port.fileno() in ready:
                    data = port.read(CHUNK)
                    client.sendall(data if manager is None else b"".join(manager.escape(data)))

        with serving(serve) as address:
            yield address
