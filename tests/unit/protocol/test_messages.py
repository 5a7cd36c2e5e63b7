"""What module frames mean, with and without what was asked.

Which frames pass, and what a byte can carry. The values themselves: `tests.vendor`.

One-bit and two-bit errors of every frame: what is noticed, and what no host can notice.

An eight-bit sum misses a two-bit error that takes from one byte what it gives to the sum.
"""

import math
from collections.abc import Iterator
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.catalogue import (
    BAUD,
    BY_CODE,
    BY_NAME,
    CELL_VOLT,
    CENTISECOND,
    COMMANDS,
    COUNT,
    DEGREE,
    FLAG,
    INVERTED,
    RECORD_CODE,
    STATUS_CODE,
    TENTH_G,
    TENTH_VOLT,
    Request,
)
from protocol.fields import Done, Field, Quantity, Value, ValueRefused
from protocol.messages import (
    Acknowledgement,
    Direction,
    EmptySlot,
    Frame,
    Reading,
    Reason,
    Status,
    TriggerRecord,
    answers,
    check_host,
    check_module,
    checksum,
    decode,
    decode_record,
    encode_long,
    encode_reply,
)
from protocol.stream import StreamParser
from tests.support.line.reference_decoder import REPLIES, REQUESTS
from tests.vendor.frames import FROM_MODULE, VALID, Vector


def record(data: bytes) -> TriggerRecord:
    decoded = decode_record(encode_long(RECORD_CODE, b"\1" + data))
    assert isinstance(decoded, TriggerRecord)
    return decoded


@given(st.integers(0, 255), st.integers(0, 255), st.booleans(), st.booleans())
def test_a_status_survives_the_way_there_and_back(tilt: int, tenths: int, triggered: bool, active: bool) -> None:
    status = Status(tilt, tenths / 10, triggered, active)
    assert decode(status.encode()) == status


@pytest.mark.parametrize("filling", [0x00, 0xFF])
def test_e07_a_slot_of_all_00_or_all_ff_is_empty_and_no_trigger(filling: int) -> None:
    raw = encode_long(RECORD_CODE, b"\1" + bytes((filling,)) * 11)
    assert decode(raw) == EmptySlot(raw)


@pytest.mark.parametrize(
    ("cell", "charging", "implausible"),
    [
        (0xEB, 1, ("cell_voltage_v",)),  # the table's example: 4.70 V, no external power
        (0xEB, 0, ()),  # the charging voltage
        (0xD2, 1, ()),  # 4.20 V
        (0xD3, 1, ("cell_voltage_v",)),
        (0x7D, 1, ()),  # 2.50 V
        (0x7C, 1, ("cell_voltage_v",)),
    ],
)
def test_e12_what_came_is_shown_and_an_impossible_voltage_is_marked(
    cell: int, charging: int, implausible: tuple[str, ...]
) -> None:
    one = record(bytes((1, 0, 108, 2, 60, 5, 160, 0, charging, 12, cell)))
    assert (one.cell_voltage_v, one.implausible) == (cell / 50, implausible)


@pytest.mark.parametrize("vector", FROM_MODULE, ids=lambda vector: vector.id)
def test_a_reply_answers_its_own_request_and_no_other(vector: Vector) -> None:
    assert vector.means is not None
    means = vector.means["command"]
    for command in COMMANDS:
        requests = [] if command.query_data is None else [command.query()]
        if command.write is not None:
            requests += [Request(command, 0x02, raw) for raw in sorted(command.write.allowed)[:2]]
        for asked in requests:
            is_shared = vector.raw[2] == 0x16 and command.name in ("attitude_trigger", "freefall_trigger")
            assert answers(vector.raw, asked) is (command.name == means or is_shared)


@pytest.mark.parametrize(
    ("asked", "raw", "is_echo", "is_accepted"),
    [
        (BY_NAME["freefall_time"].set(1.6), 0xA0, True, True),
        (BY_NAME["freefall_time"].set(1.6), 0x01, False, True),
        (BY_NAME["freefall_time"].set(1.6), 0x9F, False, False),
        (BY_NAME["freefall_acceleration"].set(0.5), 0x01, False, True),
        (BY_NAME["baud_rate"].set(115200), 0x01, False, True),
        (BY_NAME["attitude_threshold"].set(60), 0x3C, True, True),
        (BY_NAME["attitude_threshold"].set(60), 0x01, False, False),
        (BY_NAME["activation"].set(True), 0x00, False, False),
        (BY_NAME["activation"].set(False), 0x01, False, False),
        (BY_NAME["zero_sensor"].query(), 0x01, False, True),
        (BY_NAME["shutdown"].set(True), 0x01, True, True),
    ],
)
def test_e02_what_counts_as_acknowledged(asked: Request, raw: int, is_echo: bool, is_accepted: bool) -> None:
    message = decode(encode_reply(asked.command.code, raw), asked)
    assert isinstance(message, Acknowledgement)
    assert (message.request, message.is_echo, message.is_accepted) == (asked, is_echo, is_accepted)


def test_exactly_the_requests_of_the_table_pass() -> None:
    """All 2^24 host frames by their three free bytes would take long: every code and control, edges and all of D4."""
    for code in range(256):
        for control in (0, 1, 2, 3, 0xA5, 0xFF):
            for data in range(256) if (code, control) in REQUESTS else (0, 1, 2, 0x5A, 0xFF):
                body = bytes((code, control, data))
                is_valid = check_host(b"Ba" + body + bytes((checksum(body),))) is None
                assert is_valid is (data in REQUESTS.get((code, control), set()))


def test_exactly_the_replies_of_the_table_pass() -> None:
    for code in BY_CODE:
        if code in (STATUS_CODE, 0x01):
            continue
        for data in range(256):
            is_valid = check_module(encode_reply(code, data)) is None
            assert is_valid is (code == RECORD_CODE or data in REPLIES[code])


@pytest.mark.parametrize("position", [11, 12])
def test_a_record_flag_that_is_neither_00_nor_01_is_rejected(position: int) -> None:
    data = bytearray(bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB"))
    data[position] = 0x02
    assert check_module(bytes(data) + bytes((checksum(bytes(data[2:])),))) is Reason.VALUE


def test_a_record_with_another_control_byte_is_rejected() -> None:
    assert check_module(encode_long(RECORD_CODE, b"\2" + bytes(11))) is Reason.CONTROL


# What a byte can carry


QUANTITIES = [TENTH_VOLT, CELL_VOLT, TENTH_G, CENTISECOND, DEGREE, COUNT]


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        (CENTISECOND, 1.605, "1.605: the nearest steps are 1.60 s and 1.61 s"),
        (TENTH_G, -0.1, "-0.1 is outside 0.0 g to 25.5 g"),
        (DEGREE, 256, "256 is outside 0° to 255°"),
        *((DEGREE, value, "a number is needed") for value in (True, math.nan, math.inf)),
        *((field, value, "expected true, false") for field, value in ((FLAG, 1), (INVERTED, 0))),
        *((BAUD, value, f"{value} is not one of ") for value in (115201, True)),
        *((Done(), value, "expected true") for value in (False, 1)),
    ],
)
def test_what_a_byte_cannot_carry_is_refused_with_what_it_can(field: Field, value: Value, said: str) -> None:
    with pytest.raises(ValueRefused, match=said):
        field.encode(value)


@pytest.mark.parametrize("field", QUANTITIES, ids=str)
@given(value=st.floats(allow_nan=True, allow_infinity=True) | st.integers())
def test_a_number_is_carried_exactly_or_refused(field: Quantity, value: float) -> None:
    try:
        raw = field.encode(value)
    except ValueRefused:
        assert value not in map(field.decode, range(256))
    else:
        assert field.decode(raw) == value


def corruptions(raw: bytes, bits: int) -> Iterator[bytes]:
    """`raw` with every choice of `bits` different bits flipped."""
    number = int.from_bytes(raw)
    for positions in combinations(range(8 * len(raw)), bits):
        yield (number ^ sum(1 << position for position in positions)).to_bytes(len(raw))


def frames_in(raw: bytes, asked: Request | None) -> list[Frame]:
    parser = StreamParser(asked=asked)
    return [piece for piece in parser.feed(raw) + parser.flush() if isinstance(piece, Frame)]


def request_for(name: str, raw: bytes) -> Request:
    """What the host sent to get this reply."""
    command = BY_NAME[name]
    if command.query_data is not None:
        return command.query()
    assert command.write is not None
    return command.set(command.write.decode(raw[4]))


@pytest.mark.parametrize("vector", VALID, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_e13_no_one_bit_error_goes_unnoticed(vector: Vector) -> None:
    asked = BY_NAME[vector.while_asked].query() if vector.while_asked == "cell_voltage" else None
    assert all(not frames_in(corrupted, asked) for corrupted in corruptions(vector.raw, 1))


@pytest.mark.parametrize("vector", FROM_MODULE, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_a_corrupted_reply_never_answers_for_another_command(vector: Vector) -> None:
    assert vector.means is not None
    asked = request_for(str(vector.means["command"]), vector.raw)
    for corrupted in corruptions(vector.raw, 2):
        for frame in frames_in(corrupted, asked):
            if frame.direction is Direction.MODULE_TO_HOST and answers(frame.raw, asked):
                message = decode(frame.raw, asked)
                if isinstance(message, Reading | Acknowledgement):
                    told = message.command if isinstance(message, Reading) else message.request.command
                    assert told is asked.command
