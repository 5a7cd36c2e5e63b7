"""Faults of the port itself, on real pseudo-terminals, processes and devices: closed in time, said in our own words."""

import errno
import os
import select
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
import serial

from app import ports, transport
from app.ports import PortInfo, PortsUnknown, list_ports
from app.procedure import Ask, Procedure
from app.procedures.greet import greet
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from app.transport import PortError, PortTrouble, open_line
from app.worker import Batch, Job, PortState, Worker
from protocol.catalogue import BY_NAME, STATUS
from protocol.events import OutcomeUnknown, Rejected
from protocol.link_states import Presence
from protocol.messages import Status
from tests.batches import Batches
from tests.processes import ENVIRONMENT, PROGRAM, ROOT, RunningModule, run_module
from tests.terminals import CLOSING_S, Terminal, in_time

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")

ENOUGH_STOLEN = 12
NOBODY = 65534
"""A user that every system has and that may do nothing."""
ANSWER = Status(5, 1.0, triggered=False, active=False).encode()


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    made = Terminal()
    yield made
    made.hang_up()


@pytest.fixture
def batches() -> Batches:
    return Batches()


@pytest.fixture
def worker(batches: Batches) -> Iterator[Worker]:
    made = Worker(batches)
    made.start()
    yield made
    assert made.stop(2.0)


@pytest.fixture
def module() -> Iterator[RunningModule]:
    with run_module("--uptime", "60", "--rate", "100") as running:
        yield running


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


def trouble_of(batch: Batch) -> PortTrouble | None:
    return None if batch.connection.trouble is None else batch.connection.trouble.trouble


def is_online(batch: Batch) -> bool:
    return is_open(batch) and batch.device.presence is Presence.ONLINE


def has_trouble(batches: Batches) -> bool:
    return batches.last is not None and batches.last.connection.trouble is not None


# Opening


@pytest.mark.parametrize(
    ("number", "trouble"),
    [
        (errno.EACCES, PortTrouble.NOT_ALLOWED),
        (errno.EPERM, PortTrouble.NOT_ALLOWED),
        (errno.EBUSY, PortTrouble.BUSY),
        (errno.ENOENT, PortTrouble.MISSING),
        (errno.ENXIO, PortTrouble.MISSING),
        (errno.EINVAL, PortTrouble.UNUSABLE),
        (errno.ENOTTY, PortTrouble.UNUSABLE),
    ],
)
def test_what_the_system_refuses_has_a_name(
    number: int, trouble: PortTrouble, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_serial: serial.Serial) -> None:
        raise serial.SerialException(number, f"could not open port: {os.strerror(number)}")

    monkeypatch.setattr(serial.Serial, "open", refuse)
    with pytest.raises(PortError) as refused:
        open_line(terminal.name, 115200)
    assert refused.value.trouble is trouble


def test_a_port_without_permission(terminal: Terminal) -> None:
    """To the administrator nothing is forbidden, so then the child becomes somebody else first."""
    Path(terminal.name).chmod(0)
    code = (
        "import os, sys\nfrom app.transport import PortError, open_line\n"
        "nobody = int(sys.argv[2])\n"
        "if os.geteuid() == 0:\n    os.setgroups([])\n    os.setgid(nobody)\n    os.setuid(nobody)\n"
        "try:\n    open_line(sys.argv[1], 115200)\nexcept PortError as error:\n    print(error.trouble.value)"
    )
    ran = subprocess.run(
        [sys.executable, "-B", "-c", code, terminal.name, str(NOBODY)],
        cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True, timeout=30, check=False,
    )  # fmt: skip
    assert ran.stdout.strip() == "not allowed", ran.stderr


def test_two_copies_of_the_program_do_not_share_a_port(module: RunningModule) -> None:
    command = [*PROGRAM, "monitor", "--port", module.port, "--seconds", "8", "--json"]
    with subprocess.Popen(
        command, cwd=ROOT, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as first:
        try:
            assert first.stdout is not None
            assert first.stdout.readline()  # it works
            with pytest.raises(PortError) as refused:
                open_line(module.port, 115200)
            assert refused.value.trouble is PortTrouble.BUSY
            holder = refused.value.holder
            if sys.platform.startswith("linux"):
                assert holder is not None
                assert holder.pid in (first.pid, module.process.pid)  # the simulated module has it open too
        finally:
            first.terminate()
            first.communicate(timeout=10)


def test_kill_minus_nine_leaves_a_port_that_can_be_opened(module: RunningModule) -> None:
    command = [*PROGRAM, "monitor", "--port", module.port, "--seconds", "30"]
    with subprocess.Popen(
        command, cwd=ROOT, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as first:
        assert first.stdout is not None
        assert first.stdout.readline()
        first.kill()
        first.communicate(timeout=10)
    line = open_line(module.port, 115200)
    line.close()


def test_sigterm_ends_in_time_and_switches_the_stream_off(module: RunningModule) -> None:
    command = [*PROGRAM, "monitor", "--port", module.port, "--seconds", "30"]
    with subprocess.Popen(
        command, cwd=ROOT, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as first:
        assert first.stdout is not None
        assert first.stdout.readline()
        with in_time(2.0):
            first.send_signal(signal.SIGTERM)
            _, said = first.communicate(timeout=10)
    assert "Traceback" not in said
    line = open_line(module.port, 115200)
    try:
        end_s = time.monotonic() + 0.3
        came = b""
        while time.monotonic() < end_s:
            came += line.read(0.01, 0.0)
        assert len(came) <= 2 * len(ANSWER)  # the stream is off; at most what was on its way
    finally:
        line.close()


# Open


def test_unplugged_in_the_middle_of_everything(worker: Worker, batches: Batches, module: RunningModule) -> None:
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(is_online)
    job = worker.submit(Job(read_everything()))
    module.tell("unplug")
    lost = batches.until(lambda batch: trouble_of(batch) is PortTrouble.LOST)
    assert all(known.is_stale for known in lost.device.values.values())
    assert job.wait(1)


def test_a_write_that_blocks_ends_as_stuck_and_closes_in_time(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    terminal.choke()
    with in_time():
        job = worker.submit(Job(greet()))
        batches.until(lambda batch: trouble_of(batch) is PortTrouble.STUCK)
    assert job.wait(1)
    assert isinstance(job.run.error, PortError)


def test_the_window_closes_in_time_while_a_write_blocks(batches: Batches, terminal: Terminal) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(terminal.name, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.link is not None and batch.link.counters.sent > 0)
    terminal.choke()
    worker.submit(Job(read_everything()))
    with in_time():
        assert worker.stop(2.0)


def test_closed_while_a_stream_and_a_procedure_are_under_way(batches: Batches, module: RunningModule) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    job = worker.submit(Job(read_everything()))
    with in_time():
        assert worker.stop(2.0)
    assert job.is_done
    last = batches.last
    assert last is not None
    assert all(known.is_stale for known in last.device.values.values())


def test_bytes_after_closing_are_nobodys(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    batches.mark()
    worker.close()
    closed = batches.until(lambda batch: batch.connection.state is PortState.CLOSED)
    terminal.send(ANSWER * 10)
    worker.open(terminal.name, 115200)
    batches.mark()
    batches.until(is_open)
    terminal.send(b"\x00")
    seen = batches.until(lambda batch: any(isinstance(event, Rejected) for event in batch.events), limit_s=2)
    assert closed.device.values == {}
    assert seen.device.known("tilt_deg", seen.at) is None


def test_half_a_frame_at_opening_is_rejected_and_the_next_one_read(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    terminal.send(ANSWER[3:] + ANSWER)
    seen = batches.until(lambda batch: batch.device.fresh("tilt_deg", batch.at) == 5)
    assert seen.link is not None
    assert seen.link.counters.rejected == len(ANSWER) - 3


def test_a_login_prompt_is_noise_and_no_module(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    job = worker.submit(Job(greet()))
    terminal.send(b"\r\nDebian GNU/Linux 12 ttyS0\r\n\r\nlogin: ")
    assert job.wait(4)
    assert not job.outcome().is_answered
    last = batches.last
    assert last is not None
    assert last.device.presence is Presence.OFFLINE


def test_an_echo_is_no_module(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    is_over = threading.Event()

    def echo() -> None:
        while not is_over.wait(0.01):
            try:
                terminal.send(os.read(terminal.master, 4096))
            except BlockingIOError:
                continue
            except OSError:
                return

    thread = threading.Thread(target=echo)
    thread.start()
    try:
        worker.open(terminal.name, 115200)
        job = worker.submit(Job(greet()))
        assert job.wait(4)
        silence = job.outcome().silence
        assert silence is not None
        assert silence.value == "echo"
    finally:
        is_over.set()
        thread.join()


def test_a_second_program_that_reads_too_does_no_harm(worker: Worker, batches: Batches, module: RunningModule) -> None:
    """Linux does not keep a program out that does not ask: every byte goes to one of the two."""
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    thief = os.open(module.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        end_s = time.monotonic() + 5.0
        stolen = 0
        while stolen < ENOUGH_STOLEN and time.monotonic() < end_s:
            if not has_trouble(batches):
                select.select([thief], [], [], 0.05)
            with suppress(BlockingIOError):
                stolen += len(os.read(thief, 3))
        assert stolen >= ENOUGH_STOLEN
    finally:
        os.close(thief)
    last = batches.last
    assert last is not None
    if trouble_of(last) is not None:  # the driver may take the other reader for an unplugged cable
        assert trouble_of(last) is PortTrouble.LOST
        worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.mark()
    seen = batches.until(
        lambda batch: is_online(batch) and batch.device.fresh("tilt_deg", batch.at) is not None, limit_s=10
    )
    assert seen.device.fresh("tilt_deg", seen.at) == 0


def test_an_unanswered_act_is_of_unknown_outcome_and_not_sent_again(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    def activate() -> Procedure[object]:
        return (yield Ask(BY_NAME["activation"].set(True), is_deliberate=True))

    worker.open(terminal.name, 115200)
    batches.until(is_open)
    job = worker.submit(Job(activate()))
    assert job.wait(3)
    assert isinstance(job.outcome(), OutcomeUnknown)
    sent = os.read(terminal.master, 4096)
    assert sent.count(BY_NAME["activation"].set(True).encode()) == 1


# The four exceptions of one pulled cable


@pytest.mark.parametrize(
    "error",
    [
        serial.SerialException("device reports readiness to read but returned no data"),
        OSError(errno.EIO, "Input/output error"),
        termios.error(errno.EIO, "Input/output error"),
        TypeError("'NoneType' object cannot be interpreted as an integer"),
        ValueError("file descriptor cannot be a negative integer (-1)"),
    ],
    ids=["SerialException", "OSError", "termios.error", "TypeError", "ValueError"],
)
@pytest.mark.parametrize("where", ["read", "in_waiting", "write", "reset_input_buffer", "close"])
def test_whatever_pyserial_raises_is_a_lost_port(
    where: str, error: Exception, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = open_line(terminal.name, 115200)

    def fail(*_: object) -> object:
        raise error

    is_property = where == "in_waiting"
    with monkeypatch.context() as patch:
        patch.setattr(serial.Serial, where, property(fail) if is_property else fail)
        terminal.send(ANSWER)
        match where:
            case "close":
                line.close()  # never raises
            case "write":
                with pytest.raises(PortError):
                    line.write(STATUS.query().encode())
            case "reset_input_buffer":
                with pytest.raises(PortError):
                    line.use_rate(9600)
            case _:
                with pytest.raises(PortError) as lost:
                    line.read(0.01, 0.0)
                assert lost.value.trouble is PortTrouble.LOST
    line.close()
    line.close()


# The list of ports


def test_a_list_that_takes_ten_seconds_is_given_up_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    is_over = threading.Event()

    def scan() -> list[PortInfo]:
        is_over.wait(10)
        return []

    monkeypatch.setattr(ports, "scan", scan)
    try:
        with in_time(0.3), pytest.raises(PortsUnknown):
            ports._scan_in_thread(0.3)
    finally:
        is_over.set()


def test_the_list_works_as_it_is() -> None:
    assert isinstance(list_ports(5.0), list)


def test_the_limits_of_writing_and_closing_fit_into_half_a_second() -> None:
    from app.worker import CLOSING_LIMIT_S

    assert transport.WRITE_LIMIT_S <= CLOSING_S - 0.1
    assert CLOSING_LIMIT_S <= CLOSING_S - 0.05


def test_a_clock_that_leaps_does_not_hurt_the_worker(batches: Batches, module: RunningModule) -> None:
    """As a monotonic clock does that counts the time asleep."""
    leap = {"s": 0.0}
    worker = Worker(batches, clock=lambda: time.monotonic() + leap["s"])
    worker.start()
    try:
        worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
        batches.until(lambda batch: batch.device.is_streaming)
        leap["s"] = 3600.0
        batches.mark()
        batches.until(lambda batch: is_online(batch) and batch.device.fresh("tilt_deg", batch.at) is not None)
    finally:
        assert worker.stop(2.0)
