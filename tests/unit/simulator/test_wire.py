"""Faults of the line: each does what it says, and the same again for the same seed."""

from typing import Any

import pytest

from app.simulator.module import Physics, SimulatedModule
from app.simulator.setup import Setup
from protocol.catalogue import BY_NAME, STATUS
from protocol.messages import Frame
from protocol.stream import StreamParser
from tests.support.line.odd_module import HonestWire as Wire
from tests.support.line.simulated import tick

ASK = STATUS.query().encode()
ANSWER = bytes.fromhex("41 75 32 00 0a 00 00 3c")
BYTE_S = 10 / 115200


def wire(*, seed: int = 1, host_baud: int | None = None, **faults: Any) -> Wire:
    module = SimulatedModule(Physics(), Setup(seed=seed, **faults))
    module.power_on(-60.0)
    tick(module, 0.0)
    return Wire(module, host_baud=host_baud)


def conversation(line: Wire, count: int = 200) -> list[bytes]:
    """What comes back to each of `count` requests, 50 ms apart."""
    answers = []
    for number in range(count):
        line.write(ASK, number * 0.05)
        answers.append(line.read(number * 0.05 + 0.049))
    return answers


def test_frames_take_their_time() -> None:
    line = wire()
    line.write(ASK, 0.0)
    assert line.next_due(0.0) == pytest.approx(6 * BYTE_S)
    assert line.read(6 * BYTE_S - 1e-6) == b""
    assert line.read(14 * BYTE_S - 1e-6) == b""
    assert line.next_due(14 * BYTE_S - 1e-6) == pytest.approx(14 * BYTE_S)
    assert line.read(14 * BYTE_S + 1e-9) == ANSWER
    assert line.next_due(1.0) is None


def test_drop_takes_whole_answers() -> None:
    answers = conversation(wire(drop=0.3))
    assert set(answers) == {b"", ANSWER}
    assert 30 <= answers.count(b"") <= 90


def test_corrupt_turns_single_bits() -> None:
    wrong = [answer for answer in conversation(wire(corrupt=0.02)) if answer != ANSWER]
    assert wrong
    for answer in wrong:
        assert {(a ^ b).bit_count() for a, b in zip(answer, ANSWER, strict=True)} <= {0, 1}


@pytest.mark.parametrize("rate", [9600, 0], ids=["another", "none that a module has"])
def test_at_the_wrong_rate_nothing_is_understood(rate: int) -> None:
    line = wire(host_baud=rate)
    assert b"Au" not in b"".join(conversation(line, 20))
    line.module.start_stream(1.0)
    garbled = line.read(2.0)
    assert garbled
    assert not [piece for piece in StreamParser().feed(garbled) if isinstance(piece, Frame)]
    line.host_baud = 115200
    line.clear(2.0)
    assert ANSWER in line.read(2.5)


def test_what_was_on_its_way_at_the_opening_is_lost() -> None:
    line = wire()
    line.write(ASK, 0.0)
    line.clear(1.0)
    assert line.read(2.0) == b""


def test_lag_delays_everything_in_order_and_not_what_the_module_hears() -> None:
    line = wire(lag_ms=900.0)
    line.module.change(rate=10.0)
    line.module.start_stream(0.0)
    line.write(BY_NAME["attitude_threshold"].set(70).encode(), 0.25)
    assert line.read(0.9) == b""
    assert line.module.memory.attitude_threshold == 70
    assert line.next_due(0.9) == pytest.approx(1.0, abs=0.001), "the module has something to send"
    assert line.read(0.999) == b""
    assert line.read(1.101) == 2 * ANSWER
    line.module.change(lag_ms=0.0)
    line.read(1.15)
    line.module.world.tilt_deg = 7.0
    later = line.read(3.0)
    assert later.startswith(bytes.fromhex("41 75 20 01 46 67"))
    assert later[6:].startswith(9 * ANSWER), "what set out later does not overtake"
    assert later.endswith(bytes.fromhex("41 75 32 07 0a 00 00 43"))
