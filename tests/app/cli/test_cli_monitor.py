"""`dps-s monitor`, and what all read-only commands put onto the wire: nothing that changes it but the stream."""

import json
import socket
import threading
import time

import pytest

import app.__main__ as program
from app.engine import transport
from app.engine.procedure import Ask, Cancelled, Inspect
from app.engine.worker import Worker
from app.procedures import stream
from protocol.catalogue import SERIAL_OUTPUT
from tests.support.cli_line import Printed, bench_of, falls_after, is_one_sentence, run_here
from tests.support.line.sim_line import engine_view

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


FORBIDDEN = {0x10, 0x11, 0x12, 0x24, 0x25}


def test_monitor_switches_the_stream_on_and_off(
    port: str, hasty: None, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    assert program.main(["monitor", "--port", f"{port}?rate=200", "--seconds", "0.8", "--json"]) == 0
    lines = [json.loads(line) for line in Printed(capsys).out.splitlines()]
    assert lines[0] == {"t_s": 0.0, "tilt_deg": 0, "acceleration_g": 1.0, "triggered": False, "active": False}
    assert len(lines) > 50
    times = [line["t_s"] for line in lines]
    assert times == sorted(times)
    assert 0.6 < times[-1] <= 0.8
    sets = [frame for frame in wire if frame[2] == SERIAL_OUTPUT.code]
    assert sets == [SERIAL_OUTPUT.set(True).encode(), SERIAL_OUTPUT.set(False).encode()]
    assert not bench_of(port).state().is_streaming


def test_monitor_leaves_a_stream_that_was_on(
    port: str, hasty: None, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    url = f"{port}?stream_at_boot=yes&rate=100"
    assert program.main(["monitor", "--port", url, "--seconds", "0.8", "--json"]) == 0
    assert [frame for frame in wire if frame[2] == SERIAL_OUTPUT.code] == []
    assert bench_of(port).state().is_streaming
    assert 40 < len(Printed(capsys).out.splitlines()) <= 82


@pytest.mark.parametrize("quirks", ["stream=acknowledged", "stream=silent"])
def test_monitor_polls_what_does_not_stream(
    port: str, hasty: None, quirks: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    printed = run_here(capsys, ["monitor", "--port", f"{port}?{quirks}", "--seconds", "1.5"])
    assert len(printed.out.splitlines()) >= 3
    assert "not triggered   locked" in printed.out
    assert wire[-1] == SERIAL_OUTPUT.set(False).encode()


def test_monitor_goes_on_after_a_sleep_and_leaves_the_module_silent(
    port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ended, said that the module had stopped answering, and left it streaming."""
    slept = {"s": 0.0}
    defaults = Worker.__init__.__kwdefaults__
    assert defaults is not None
    monkeypatch.setitem(defaults, "with_sleep", lambda: time.monotonic() + slept["s"])
    timer = threading.Timer(1.0, slept.update, [{"s": 60.0}])
    timer.start()
    printed = run_here(capsys, ["monitor", "--port", f"{port}?rate=100", "--seconds", "2", "--json"])
    timer.join()
    times = [json.loads(line)["t_s"] for line in printed.out.splitlines()]
    assert times[-1] > 1.8
    assert printed.err == ""
    assert wire[-1] == SERIAL_OUTPUT.set(False).encode()
    assert not bench_of(port).state().is_streaming


def test_monitor_says_when_the_port_goes(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    bench = bench_of(port)
    with falls_after(bench, 9, bench.unplug):
        assert program.main(["monitor", "--port", port, "--json"]) == 3
    printed = Printed(capsys)
    assert len(printed.out.splitlines()) >= 1
    assert "unplugged" in printed.err
    assert is_one_sentence(printed.err)


def test_the_stream_is_switched_off_though_its_answer_was_not_awaited() -> None:
    """Ctrl-C between the switching on and its acknowledgement."""
    procedure = stream.watch(stream.StreamSwitch(), read_all=False)
    want = next(procedure)
    assert isinstance(want, Inspect)
    sight = engine_view(10.0)
    assert procedure.send(sight) == Ask(SERIAL_OUTPUT.set(True))
    cleaning = procedure.throw(Cancelled())
    assert isinstance(cleaning, Ask)
    assert cleaning.request == SERIAL_OUTPUT.set(False)
    procedure.close()


def test_a_stream_over_tcp_comes_whole_and_at_once() -> None:
    """A socket tells of one waiting byte at most; taken singly, a stream would come ever later."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        line = transport.open_line(f"socket://127.0.0.1:{listener.getsockname()[1]}", 115200)
        with listener.accept()[0] as module:
            module.sendall(bytes(range(250)) * 20)
            received, reads = b"", 0
            while len(received) < 5000 and reads < 100:
                received += line.read(0.01, 0.008)
                reads += 1
            line.close()
    assert received == bytes(range(250)) * 20
    assert reads < 20


DIALECTS = (
    "",
    "ack=one&voltage_code=34",
    "ack=echo&voltage_code=35&freefall_ack=17",
    "light_inverted=yes&odd_voltage=yes&remembers=yes",
    "echo=yes",
    "double=1",
)


@pytest.mark.parametrize("quirks", DIALECTS)
def test_reading_sends_nothing_that_changes(
    port: str, quirks: str, wire: list[bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    for command in ("read", "find"):
        program.main([command, "--port", f"{port}?{quirks}", "--json"])
    assert {frame[2] for frame in wire} == {0x01, 0x14, 0x15, 0x20, 0x21, 0x22, 0x23, 0x32, 0x33, 0x34}
    assert {frame[3] for frame in wire if frame[2] != 0x01} == {0x01}


@pytest.mark.parametrize("quirks", ["records=spaced&history=3", "empty_slots=zeros", "history=9&double=0.3&seed=3"])
def test_history_sends_nothing_but_its_question(
    port: str, hasty: None, quirks: str, wire: list[bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    program.main(["history", "--port", f"{port}?{quirks}", "--json"])
    assert {frame[2] for frame in wire} <= {0x01, 0x35}
    assert {frame[3] for frame in wire if frame[2] == 0x35} == {0x01}


@pytest.mark.parametrize("quirks", ["", "stream=silent&drop=0.3&seed=5", "remembers=yes&corrupt=0.05"])
def test_monitor_sends_only_the_switch_besides(
    port: str, hasty: None, quirks: str, wire: list[bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    program.main(["monitor", "--port", f"{port}?{quirks}", "--seconds", "0.6", "--json"])
    sets = {frame[2] for frame in wire if frame[2] != 0x01 and frame[3] == 0x02}
    assert sets <= {SERIAL_OUTPUT.code}
    assert not FORBIDDEN & {frame[2] for frame in wire}
