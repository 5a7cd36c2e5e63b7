"""`dps-s serve` before the independent module, whose log says what reached it: readers that ask, and hostile ones."""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import NamedTuple

import pytest

from app import sharing
from protocol.catalogue import COMMANDS
from tests.module.line import Line, now
from tests.module.module import ACTIVATION, BY_PWM, MOST_RECORDS, OUTPUT, RECORDS, STATUS, Module
from tests.module.wire import FROM_HOST, with_sum
from tests.support.cli_line import faults
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, Running, ran, running

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")

LOCK = bytes.fromhex("42 61 10 02 00 12")
STATUS_QUERY, BOOTS_QUERY, RECORDS_QUERY = (with_sum(FROM_HOST + bytes((code, 1, 0))) for code in (0x32, 0x23, 0x35))
ZERO = bytes.fromhex("42 61 25 01 00 26")
SETS = [with_sum(FROM_HOST + bytes((one.code, 2, raw))) for one in COMMANDS for raw in (0, 1, 6, 60)]


class Shared(NamedTuple):
    module: Module
    line: Line
    server: Running
    address: str

    def reader(self) -> socket.socket:
        host, _, port = self.address.removeprefix("shared://").rpartition(":")
        client = socket.create_connection((host, int(port)), PATIENCE_S)
        client.settimeout(PATIENCE_S)
        return client

    def dps_s(self, *words: str) -> "subprocess.CompletedProcess[str]":
        """Run it; again where nobody answered, as on a machine that stood still."""
        for _ in range(5):
            done = ran(*PROGRAM, *words, "--port", self.address, LC_ALL="C.UTF-8")
            if done.returncode != 3:
                break
        return done

    def end(self) -> tuple[int, str, str]:
        self.server.process.send_signal(signal.SIGINT)
        return self.server.end()


@pytest.fixture
def shared() -> Iterator[Shared]:
    module = Module(now=now())
    with (
        Line(module) as line,
        running(*PROGRAM, "serve", "--port", line.port, "--json", LC_ALL="C.UTF-8") as server,
    ):
        yield Shared(module, line, server, json.loads(server.out.readline())["address"])


def ask(client: socket.socket, question: bytes, length: int = 6, *, again_s: float = 3.0) -> bytes:
    """The next answer to it; what else comes is skipped. It is asked again, after longer than a conversation takes to
    end and to begin: on a machine that stood still it has ended, and with it what was asked."""
    heard, ends_at = b"", time.monotonic() + PATIENCE_S
    client.settimeout(again_s)
    client.sendall(question)
    while (at := heard.find(b"\x41\x75" + question[2:3])) < 0 or len(heard) < at + length:
        assert time.monotonic() < ends_at, f"no answer to {question.hex(' ')}"
        try:
            data = client.recv(4096)
        except TimeoutError:
            client.sendall(question)
        else:
            assert data, "the server hung up"
            heard += data
    client.settimeout(PATIENCE_S)
    return heard[at : at + length]


def test_commands_read_a_shared_port_and_change_nothing(shared: Shared) -> None:
    read, watched, history = (
        shared.dps_s(*words.split()) for words in ("read --json", "monitor --seconds 1 --json", "history --json")
    )
    assert (read.returncode, watched.returncode, history.returncode) == (0, 0, 0)
    told = json.loads(read.stdout)
    assert (told["boot_count"], told["settings"]["attitude_threshold_deg"], told["cell_voltage_v"]) == (1, 60, 4.0)
    assert len(watched.stdout.splitlines()) > 3
    assert json.loads(history.stdout)["empty_slots"] == 9
    for words in ("set freefall_time_s=1.4", "activate --yes", "zero --yes", "shutdown --yes"):
        ended = shared.dps_s(*words.split())
        assert ended.returncode == 1
        assert "Shared, read-only" in ended.stdout + ended.stderr
    assert "Shared, read-only" in read.stderr
    assert shared.module.log.sets() == []
    assert shared.module.log.acts() == []


def test_no_set_reaches_the_module_and_each_is_refused_with_its_reason(shared: Shared) -> None:
    with shared.reader() as client:
        for frame in (*SETS, ZERO):
            if frame != LOCK:
                client.sendall(frame)
        ask(client, BOOTS_QUERY)
    code, out, errors = shared.end()
    assert code == 0
    assert shared.module.log.sets() == []
    assert shared.module.log.acts() == []
    for refused in ("10 02 01", "11 02", "12 02", "13 02", "16 02", "17 02", "20 02", "24 02", "25 01"):
        assert f"42 61 {refused}" in errors
    events = [json.loads(line) for line in out.splitlines()]
    assert [fault for event in events for fault in faults("serve", event)] == []
    assert {event["event"] for event in events} - {"ended"} == {"joined", "refused", "left"}


def test_lock_passes_at_once_and_is_told(shared: Shared) -> None:
    shared.module.settings[ACTIVATION] = 1
    done = shared.dps_s("lock")
    assert (done.returncode, done.stdout) == (0, "The module reports LOCKED.\n")
    assert shared.module.settings[ACTIVATION] == 0
    assert {entry.frame for entry in shared.module.log.sets()} == {LOCK}
    told = [line.split(": ", 1) for line in shared.end()[2].splitlines() if ": " in line]
    assert len({reader for reader, _ in told}) == 1
    # It is sent again where the report takes its time, and where the machine stood still another module may answer.
    said = {sentence for _, sentence in told} - {"The module that answers now reports LOCKED."}
    assert said == {"LOCK", "The module reports LOCKED."}


def test_lock_overtakes_a_question_that_is_being_answered(shared: Shared) -> None:
    for _ in range(MOST_RECORDS):
        shared.module.trigger(now(), BY_PWM)
    shared.module.options.record_gap_s = 0.2
    log = shared.module.log
    with shared.reader() as one, shared.reader() as other:
        ask(one, BOOTS_QUERY)
        other.sendall(RECORDS_QUERY)
        while not log.sent(RECORDS):
            time.sleep(0.001)
        ask(one, LOCK)
        while len(log.sent(RECORDS)) < MOST_RECORDS:
            time.sleep(0.01)
    assert log.got(ACTIVATION)[0].at_s < log.sent(RECORDS)[-1].at_s


def test_each_reader_gets_its_own_answers_and_all_get_the_stream(shared: Shared) -> None:
    with shared.reader() as one, shared.reader() as other:
        for _ in range(20):
            assert ask(one, BOOTS_QUERY) == bytes.fromhex("41 75 23 01 01 25")
        heard, questions, ends_at = b"", (BOOTS_QUERY, RECORDS_QUERY, STATUS_QUERY), time.monotonic() + PATIENCE_S
        while not all(b"\x41\x75" + question[2:3] in heard for question in questions):
            assert time.monotonic() < ends_at, "one question keeps another from being asked"
            one.settimeout(3.0)
            one.sendall(b"".join(questions))
            with contextlib.suppress(TimeoutError):  # on a machine that stood still it is asked again
                while len(heard) < 6 + 16 * MOST_RECORDS + 8:
                    heard += one.recv(4096)
        other.settimeout(0.3)
        with pytest.raises(TimeoutError):
            other.recv(1)
        other.settimeout(PATIENCE_S)
        shared.module.settings[OUTPUT] = 1
        for client in (one, other):
            heard = b""
            while heard.count(b"\x41\x75\x32") < 10:
                heard += client.recv(4096)
    assert len(shared.module.log.got(STATUS)) < 5


def test_the_end_of_a_conversation_reaches_every_reader(shared: Shared) -> None:
    """What answers after a silence may be another module: a reader hears nothing for longer than its link waits. The
    silence is longer than the longest that a slow machine makes of the link's round trips."""
    with shared.reader() as client:
        ask(client, BOOTS_QUERY)
        before = time.monotonic()
        shared.module.be_silent(now(), 1.1)
        ask(client, STATUS_QUERY, 8, again_s=0.05)
        assert time.monotonic() - before > 1.5
    assert "The module was silent for a moment." in shared.end()[2]


def test_without_the_port_it_ends(shared: Shared) -> None:
    with shared.reader() as client:
        ask(client, BOOTS_QUERY)
        shared.line.unplug()
        while client.recv(4096):
            pass
    code, _, errors = shared.server.end()
    assert code == 3
    assert "was unplugged" in errors
    assert "Traceback" not in errors


# Hostile readers


HOSTILE: dict[str, bytes] = {
    "garbage": bytes(range(256)) * 400,
    "another protocol": b"GET / HTTP/1.1\r\nHost: x\r\n\r\n" * 1000,
    "questions": (STATUS_QUERY + RECORDS_QUERY) * 200,
    "sets": bytes.fromhex("42 61 10 02 01 13") * 4000,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_reader_holds_up_neither_lock_nor_another_reader(name: str, shared: Shared) -> None:
    shared.module.settings[ACTIVATION] = 1
    with shared.reader() as hostile, shared.reader() as honest:
        with contextlib.suppress(OSError):
            hostile.sendall(HOSTILE[name])
        ask(honest, STATUS_QUERY, 8)
        assert ask(honest, LOCK) == bytes.fromhex("41 75 10 01 00 11")
    assert shared.module.settings[ACTIVATION] == 0
    assert {entry.frame for entry in shared.module.log.sets()} == {LOCK}
    errors = shared.end()[2]
    assert "Traceback" not in errors
    assert errors.count("read-only") <= 1


def test_a_reader_that_does_not_read_is_dropped() -> None:
    told: list[str] = []
    listener, _, _ = sharing.listen_at("127.0.0.1", 0)
    shares = sharing.Sharing(listener, lambda *_: None, lambda _: None, lambda event, *_: told.append(event))
    with socket.create_connection(listener.getsockname()):
        shares.turn(PATIENCE_S)
        for _ in range(100_000):  # the system keeps less for it
            shares._send(shares.readers, bytes(1000))
    shares.close()
    assert told == ["joined", "dropped"]


def test_more_readers_than_there_is_room_for(shared: Shared) -> None:
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(shared.reader()) for _ in range(sharing.MOST_READERS + 4)]
        for client in clients[: sharing.MOST_READERS]:
            ask(client, BOOTS_QUERY)
        for client in clients[sharing.MOST_READERS :]:
            assert client.recv(1) == b""
