"""Each kind of address against what may stand at its other end, with the command line in a process of its own."""

import json
import select
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import SimpleNamespace

import pytest
import serial
import serial.rfc2217

from tests.module.line import Line, now
from tests.module.module import Module
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, ran

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="the peers have pseudo-terminals"),
    pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),  # pyserial's
]
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
            manager = serial.rfc2217.PortManager(port, SimpleNamespace(write=client.sendall)) if is_rfc2217 else None  # type: ignore[arg-type]
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


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_a_module_behind_a_serial_server_is_read_set_and_locked(scheme: str) -> None:
    module = Module(now=now())
    module.settings[0x10] = 1
    with Line(module) as line, serial_server(line.port, is_rfc2217=scheme == "rfc2217") as address:
        port = f"{scheme}://{address}"
        locked = ran(*PROGRAM, "lock", "--port", port)
        assert locked.returncode == 0, locked.stderr
        written = ran(*PROGRAM, "set", "freefall_time_s=0.90", "--port", port)
        assert written.returncode == 0, written.stderr
        read = ran(*PROGRAM, "read", "--json", "--port", port)
    assert read.returncode == 0, read.stderr
    assert json.loads(read.stdout)["settings"]["freefall_time_s"] == 0.9
    assert module.settings[0x10] == 0


def test_behind_a_plain_socket_the_rate_is_neither_found_nor_changed() -> None:
    """Whatever rate the port is opened with, the module answers; changing it would cut the link for good."""
    module = Module(now=now())
    with Line(module) as line, serial_server(line.port) as address:
        port = f"socket://{address}"
        found = ran(*PROGRAM, "find", "--json", "--port", port)
        read = ran(*PROGRAM, "read", "--json", "--port", port)
        changed = ran(*PROGRAM, "set", "baud_rate=9600", "--accept-risk", "--port", port)
    assert found.returncode == 2
    assert read.returncode == 0
    assert json.loads(read.stdout)["settings"]["baud_rate"] is None
    assert "other end" in found.stderr
    assert changed.returncode == 1
    assert "other end" in changed.stdout + changed.stderr
    assert module.log.sets(0x24) == []


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_what_is_no_serial_server_is_said_of_the_address(scheme: str) -> None:
    with serving(closing) as address:
        port = f"{scheme}://{address}"
        ended = ran(*PROGRAM, "read", "--port", port)
    assert ended.returncode == 3, ended.stderr
    assert ended.stderr.count("\n") == 1, ended.stderr
    assert port in ended.stderr
