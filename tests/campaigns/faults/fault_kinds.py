"""The faults of docs/internals/line-faults.md, each as a change to a `FakePort`."""

import errno
import itertools
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import serial

from protocol.catalogue import BAUD, BY_NAME, STATUS
from protocol.frame import encode_reply
from protocol.messages import Status
from tests.campaigns.faults.faulty_port import Arrival, FakePort, every_other, one_shot, spread

if sys.platform != "win32":
    import termios

if TYPE_CHECKING:
    from tests.campaigns.faults.fault_table import Cell

LOGIN = b"\r\nDebian GNU/Linux 12 raspberrypi ttyS0\r\n\r\nraspberrypi login: "
PROBER = b"AT\r" * 3 + b"ATE0\r" + b"\x7e\x00\x78\xf0\x7e"
HALF_A_FRAME = Status(65, 11.7, triggered=True, active=True).encode()[:5]
LINE_BYTES_PER_S = 11520
STREAM_HZ = 400.0
"""A full line (1,440) runs the same code and takes four times as long; tests/unit/engine/test_worker.py has one."""
GARBAGE_EVERY_S = 0.01
CHARGING = BY_NAME["charging"]


Begin = Callable[["Cell", FakePort], None]


class End:
    """What ends the session."""

    PROCEDURE = "procedure"
    CLOSED = "closed"
    CANCELLED = "cancelled"


@dataclass(frozen=True, slots=True)
class FaultKind:
    """A fault; `name` is its row in docs/internals/line-faults.md, `begin` starts it."""

    name: str
    behaviour: str
    """How the program reacts."""
    begin: Begin
    is_of_port: bool = False
    """The port is gone or unusable: the session ends with a `PortError`."""
    hides: frozenset[str] = frozenset()
    """Keys of what the fault changes without a sign."""


def _all_fail(make: Callable[[], Exception]) -> Begin:
    def begin(_cell: "Cell", port: FakePort) -> None:
        port.read_fails = port.waiting_fails = port.write_fails = port.reset_fails = make

    return begin


def _waiting_fails(make: Callable[[], Exception]) -> Begin:
    """Reading one byte works; asking for the count of waiting bytes fails."""

    def begin(_cell: "Cell", port: FakePort) -> None:
        port.waiting_fails = port.reset_fails = make
        port.write_fails = make

    return begin


def _driver_error() -> Exception:
    return OSError(errno.EIO, "Input/output error")


def _terminal_error() -> Exception:
    return termios.error(errno.EIO, "Input/output error") if sys.platform != "win32" else _driver_error()


def _serial_error() -> Exception:
    return serial.SerialException("device reports readiness to read but returned no data (multiple access on port?)")


def _type_error() -> Exception:
    return TypeError("'NoneType' object cannot be interpreted as an integer")


def _blocks(_cell: "Cell", port: FakePort) -> None:
    port.write_takes_s = 0.3
    port.write_fails = lambda: serial.SerialTimeoutException("Write timeout")
    port.drop_pending()
    port.shape = lambda _data, _now_s: []


def _ends(end: str) -> Begin:
    def begin(cell: "Cell", _port: FakePort) -> None:
        cell.wanted_end = end

    return begin


def _change(**values: object) -> Begin:
    def begin(_cell: "Cell", port: FakePort) -> None:
        port.bench.change(**values)

    return begin


def _mute(_cell: "Cell", port: FakePort) -> None:
    port.drop_pending()
    port.bench.change(mute=True)


def _lose_request(_cell: "Cell", port: FakePort) -> None:
    port.loses_requests = 1


def _once(change: Callable[[bytes], bytes]) -> Begin:
    """The next reply arrives changed."""
    return lambda _cell, port: one_shot(port, change)


def _arrive(shape: Callable[[bytes, float], list[Arrival]]) -> Begin:
    """When, and how often, which bytes arrive."""

    def begin(_cell: "Cell", port: FakePort) -> None:
        port.shape = shape

    return begin


def _in_blocks(every_s: float) -> Begin:
    return _arrive(lambda data, now_s: [Arrival((int(now_s / every_s) + 1) * every_s, data)])


def _delay(seconds: float) -> Begin:
    return _arrive(lambda data, now_s: [Arrival(now_s + seconds, data)])


def _wrong_rate(_cell: "Cell", port: FakePort) -> None:
    module = port.bench.module
    module.memory.baud_code = BAUD.encode(19200)
    module.baud_rate = 19200


def _inject(data: bytes, times: int = 1) -> Begin:
    def begin(_cell: "Cell", port: FakePort) -> None:
        for number in range(times):
            port.inject(data, after_s=0.4 * number)

    return begin


def _restart(_cell: "Cell", port: FakePort) -> None:
    port.drop_pending()
    port.bench.restart()


def _endless_stream(_cell: "Cell", port: FakePort) -> None:
    bench = port.bench
    bench.change(rate=STREAM_HZ)
    bench.module.state.serial_output_is_on = True
    bench.module.start_stream(bench.clock())


def _endless_garbage(_cell: "Cell", port: FakePort) -> None:
    """Garbage fills the line from now on, between the module's frames."""
    began_s = port.clock.now_s
    state = {"until_s": began_s}

    pump = port._pump

    def fill() -> None:
        now_s = port.clock.now_s
        if now_s - state["until_s"] >= GARBAGE_EVERY_S:
            count = min(4096, int((now_s - state["until_s"]) * LINE_BYTES_PER_S))
            state["until_s"] = now_s
            port._arrivals.append(Arrival(now_s, bytes(port.random.choices(range(0x20, 0x41), k=count))))
        pump()

    port._pump = fill  # type: ignore[method-assign]


def _leap(_cell: "Cell", port: FakePort) -> None:
    port.clock.now_s += 3600


def _second_reader(_cell: "Cell", port: FakePort) -> None:
    counter = itertools.count()
    port.shape = lambda data, now_s: [Arrival(now_s, every_other(data, counter))]


def _second_writer(_cell: "Cell", port: FakePort) -> None:
    """Another program sends requests, too, and the replies arrive here."""
    for command in (STATUS, BY_NAME["cell_voltage"], BY_NAME["attitude_threshold"]):
        port.bench.wire.write(command.query().encode(), port.clock.now_s)


def _foreign_frames(_cell: "Cell", port: FakePort) -> None:
    """Valid frames that are not replies to the pending request."""
    for number in range(3):
        port.inject(encode_reply(CHARGING.code, 0x01), after_s=0.3 * number)


FAULTS: tuple[FaultKind, ...] = (
    FaultKind("unplugged", "ends with the port's error", _all_fail(_serial_error), is_of_port=True),
    FaultKind("driver error (OSError)", "ends with the port's error", _waiting_fails(_driver_error), is_of_port=True),
    FaultKind(
        "driver error (termios.error)", "ends with the port's error", _waiting_fails(_terminal_error), is_of_port=True
    ),
    FaultKind("driver error (TypeError)", "ends with the port's error", _all_fail(_type_error), is_of_port=True),
    FaultKind("a write that blocks", "ends with the port's error (stuck)", _blocks, is_of_port=True),
    FaultKind("window closed", "closes cleanly", _ends(End.CLOSED)),
    FaultKind("cancelled", "undoes its changes, then ends", _ends(End.CANCELLED)),
    FaultKind("module silent", "the conversation ends, and with it what runs; never repeats a set", _mute),
    FaultKind("reply lost", "repeats a query; never repeats a set", _once(lambda _data: b"")),
    FaultKind("request lost", "repeats a query; never repeats a set", _lose_request),
    FaultKind(
        "reply corrupted", "rejects it; repeats the query", _once(lambda data: data[:-1] + bytes((data[-1] ^ 0x10,)))
    ),
    FaultKind("reply cut off", "rejects it; repeats the query", _once(lambda data: data[: len(data) // 2])),
    FaultKind("replies in pieces", "reassembles them", _arrive(lambda data, now_s: spread(data, now_s, 0.02))),
    FaultKind("replies in bursts", "waits for them", _in_blocks(0.2)),
    FaultKind("adapter holds bytes for 16 ms", "waits for them", _in_blocks(0.016)),
    FaultKind("replies 700 ms late", "the conversation ends; then sends only questions and LOCK", _delay(0.7)),
    FaultKind("replies 1.4 s late", "the conversation ends, and none begins; LOCK works", _delay(1.4)),
    FaultKind(
        "replies doubled",
        "uses the first; sends nothing dangerous, and calls no trigger enabled",
        _arrive(lambda data, now_s: [Arrival(now_s, data)] * 2),
    ),
    FaultKind("echo of its own bytes", "tells the echo from replies", _change(echo=True)),
    FaultKind("wrong rate", "rejects everything", _wrong_rate, hides=frozenset({"baud_rate"})),
    FaultKind("login prompt", "rejects it", _inject(LOGIN, 3)),
    FaultKind("modem prober", "rejects it", _inject(PROBER, 3)),
    FaultKind("half a frame", "rejects it", _inject(HALF_A_FRAME)),
    FaultKind("module restarts", "the conversation ends, and with it every value", _restart),
    FaultKind("module switched off", "the conversation ends", lambda _cell, port: port.bench.power_off()),
    FaultKind("a stream that does not stop", "works alongside it", _endless_stream),
    FaultKind("garbage that does not stop", "rejects it; accepts replies in between", _endless_garbage),
    FaultKind("clock leaps an hour", "the conversation ends, as after a sleep", _leap),
    FaultKind("a second program reads", "rejects incomplete frames", _second_reader),
    FaultKind("a second program asks", "ignores replies to the other program", _second_writer),
    FaultKind(
        "frames of another conversation",
        "ignores frames that it did not request",
        _foreign_frames,
        hides=frozenset({CHARGING.key}),  # asked in that very moment, it cannot be told apart
    ),
    FaultKind("5 % of all bytes lost", "repeats the query", _change(lose=0.05)),
    FaultKind("2 % of all bytes corrupted", "repeats the query", _change(corrupt=0.02)),
)
BY_NAME_OF_FAULT: Mapping[str, FaultKind] = MappingProxyType({fault.name: fault for fault in FAULTS})
