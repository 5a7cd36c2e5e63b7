"""What module frames mean, with and without what was asked."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.catalogue import BY_NAME, COMMANDS, RECORD_CODE, Request
from protocol.messages import (
    Acknowledgement,
    EmptySlot,
    Status,
    TriggerRecord,
    answers,
    decode,
    decode_record,
    encode_long,
    encode_reply,
)
from tests.vendor.frames import FROM_MODULE, Vector


def record(data: bytes) -> TriggerRecord:
    decoded = decode_record(encode_long(RECORD_CODE, b"\1" + data))
    assert isinstance(decoded, TriggerRecord)
    return decoded


@given(st.integers(0, 255), st.integers(0, 255), st.booleans(), st.booleans())
def test_a_status_survives_the_way_there_and_back(tilt: int, tenths: int, triggered: bool, active: bool) -> None:
    status = Status(tilt, tenths / 10, triggered, active)
    assert decode(status.encode()) == status


@pytest.mark.parametrize(
    ("byte", "sources"),
    [(0x00, ()), (0x0A, ("attitude", "freefall")), (0x90, ("bit4", "bit7"))],
)
def test_sources_lowest_bit_first_unknown_bits_by_number(byte: int, sources: tuple[str, ...]) -> None:
    assert record(bytes((1, 0, 1, byte, 60, 5, 160, 0, 1, 12, 200))).sources == sources


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
