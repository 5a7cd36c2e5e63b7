"""What module frames mean, with and without what was asked."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.catalogue import (
    BY_NAME,
    CELL_VOLT,
    CENTISECOND,
    COMMANDS,
    DEGREE,
    INVERTED,
    RECORD_CODE,
    TENTH_G,
    TENTH_VOLT,
    Request,
)
from protocol.frame import encode_long, encode_reply
from protocol.messages import Acknowledgement, Source, Status, TriggerRecord, answers, decode, decode_record
from tests.vendor.frames import FROM_MODULE, Vector


def record(data: bytes) -> TriggerRecord:
    decoded = decode_record(encode_long(RECORD_CODE, b"\1" + data))
    assert isinstance(decoded, TriggerRecord)
    return decoded


@given(st.integers(0, 255), st.integers(0, 255), st.booleans(), st.booleans())
def test_a_status_survives_the_way_there_and_back(tilt: int, tenths: int, triggered: bool, active: bool) -> None:
    status = Status(tilt, tenths / 10, triggered, active)
    assert decode(status.encode()) == status


@given(
    st.binary(min_size=7, max_size=7),
    st.sampled_from([0, 1]),
    st.sampled_from([0, 1]),
    st.binary(min_size=2, max_size=2),
)
def test_e14_every_value_of_a_record_is_the_byte_it_came_from(head: bytes, link: int, charge: int, tail: bytes) -> None:
    data = head + bytes((link, charge)) + tail
    if data == bytes(11):
        return
    one = record(data)
    again = bytes(
        (
            one.boot_count,
            *one.uptime_s.to_bytes(2),
            sum(Source[name.upper()].value for name in one.sources),
            DEGREE.encode(one.attitude_threshold_deg),
            TENTH_G.encode(one.freefall_acceleration_g),
            CENTISECOND.encode(one.freefall_time_s),
            INVERTED.encode(one.serial_connected),
            INVERTED.encode(one.charging),
            TENTH_VOLT.encode(one.light_v),
            CELL_VOLT.encode(one.cell_voltage_v),
        )
    )
    assert again == data


@pytest.mark.parametrize(
    ("byte", "sources"),
    [
        (0x00, ()),
        (0x01, ("serial",)),
        (0x02, ("attitude",)),
        (0x04, ("pwm",)),
        (0x08, ("freefall",)),
        (0x0A, ("attitude", "freefall")),
        (0x90, ("bit4", "bit7")),
        (0xFF, ("serial", "attitude", "pwm", "freefall", "bit4", "bit5", "bit6", "bit7")),
    ],
)
def test_sources_lowest_bit_first_unknown_bits_by_number(byte: int, sources: tuple[str, ...]) -> None:
    assert record(bytes((1, 0, 1, byte, 60, 5, 160, 0, 1, 12, 200))).sources == sources


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
