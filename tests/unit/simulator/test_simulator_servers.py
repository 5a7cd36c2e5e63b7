"""The simulated module behind a pseudo-terminal and a TCP socket, and `dps-s simulate`."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial

from app.cli import simulate
from app.cli.commands import BY_NAME
from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import Endpoint, TcpEndpoint, serve
from app.terminal.console import Refused
from app.text.messages import ErrorCode
from protocol.catalogue import STATUS
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, running

ASK = STATUS.query().encode()
ANSWER = bytes.fromhex("41 75 32 00 0a 00 00 3c")
posix_only = pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")


@contextmanager
def serving(bench: SimulatedBench, endpoint: Endpoint) -> Iterator[str]:
    """Runs a loop in a thread; yields the address."""
    is_stopped = threading.Event()
    thread = threading.Thread(target=serve, args=(bench, endpoint, is_stopped))
    thread.start()
    try:
        yield endpoint.address
    finally:
        is_stopped.set()
        thread.join(PATIENCE_S)
        assert not thread.is_alive()
        endpoint.close()


def exchange(address: str) -> bytes:
    with serial.serial_for_url(address, baudrate=115200, timeout=PATIENCE_S) as port:
        port.write(ASK)
        return bytes(port.read(8))


def test_tcp_serves_one_client_after_the_other() -> None:
    with serving(SimulatedBench(), TcpEndpoint("127.0.0.1", 0)) as address:
        assert address.startswith("socket://127.0.0.1:")
        assert [exchange(address) for _ in range(3)] == [ANSWER] * 3


def pty(link: Path | None = None) -> Endpoint:
    from app.simulator.endpoints import PtyEndpoint

    return PtyEndpoint(link)


@posix_only
def test_pty_serves_a_host_at_its_rate_only() -> None:
    with serving(SimulatedBench(), pty()) as address:
        assert exchange(address) == ANSWER
        with serial.Serial(address, 9600, timeout=0.1) as port:
            port.write(ASK)
            assert port.read(8) != ANSWER
        assert exchange(address) == ANSWER


@posix_only
def test_pty_never_takes_the_place_of_a_file(tmp_path: Path) -> None:
    taken = tmp_path / "precious"
    taken.write_text("data", encoding="utf-8")
    with pytest.raises(FileExistsError):
        pty(taken)
    assert taken.read_text(encoding="utf-8") == "data"


def test_no_port_to_be_had_is_code_3() -> None:
    endpoint = TcpEndpoint("127.0.0.1", 0)
    try:
        args = BY_NAME["simulate"].parse_words(["--tcp", f"127.0.0.1:{endpoint.port}"])
        with pytest.raises(Refused) as refused:
            simulate.run(args)
    finally:
        endpoint.close()
    assert refused.value.code is ErrorCode.NO_PORT
    assert f"127.0.0.1:{endpoint.port}: " in refused.value.sentence


@posix_only
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_the_program_prints_the_port_and_ends_cleanly(tmp_path: Path, number: signal.Signals) -> None:
    link = tmp_path / "module"
    link.symlink_to("/nowhere")
    with running(*PROGRAM, "simulate", "--link", link, "--tilt", "7") as program:
        assert Path(program.out.readline().strip()).exists()
        with serial.Serial(str(link), 115200, timeout=PATIENCE_S) as port:
            port.write(ASK)
            assert port.read(8).hex(" ") == "41 75 32 07 0a 00 00 43"
        program.process.send_signal(number)
        assert program.process.wait(PATIENCE_S) == 0
        assert program.errors.read() == ""
    assert not link.is_symlink()
