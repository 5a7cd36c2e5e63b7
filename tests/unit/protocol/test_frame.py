"""Which frames pass, and what a byte can carry. The values themselves: `tests.vendor`."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.catalogue import (
    BAUD,
    BY_CODE,
    CELL_VOLT,
    CENTISECOND,
    COUNT,
    DEGREE,
    FLAG,
    INVERTED,
    RECORD_CODE,
    STATUS_CODE,
    TENTH_G,
    TENTH_VOLT,
)
from protocol.fields import Done, Field, Quantity, Value, ValueRefused
from protocol.messages import Reason, check_host, check_module, checksum, encode_long, encode_reply
from tests.support.line.reference_decoder import REPLIES, REQUESTS, sum_is_right
from tests.vendor.frames import VECTORS, Vector


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


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
def test_a_wrong_sum_is_rejected(vector: Vector) -> None:
    raw = vector.raw[:-1] + bytes((vector.raw[-1] ^ 0x80,))
    assert not sum_is_right(raw)
    assert (check_host(raw) if vector.is_from_host else check_module(raw)) is Reason.CHECKSUM


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
    ("field", "raw", "text"),
    [
        (CELL_VOLT, 0xBE, "3.80 V"),
        (TENTH_G, 0x05, "0.5 g"),
        (CENTISECOND, 0xA0, "1.60 s"),
        (DEGREE, 0x3C, "60°"),
        (COUNT, 0x25, "37"),
        (INVERTED, 0, "yes"),
        (BAUD, 6, "115200 baud"),
        (Done(), 1, "done"),
    ],
)
def test_a_value_is_shown_with_every_step_and_its_unit(field: Field, raw: int, text: str) -> None:
    assert field.text(raw) == text


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        (CENTISECOND, 1.605, "1.605: the nearest steps are 1.60 s and 1.61 s"),
        (CELL_VOLT, 3.81, "3.81: the nearest steps are 3.80 V and 3.82 V"),
        (DEGREE, 60.5, "60.5: the nearest steps are 60° and 61°"),
        (TENTH_G, -0.1, "-0.1 is outside 0.0 g to 25.5 g"),
        (TENTH_G, 25.6, "25.6 is outside 0.0 g to 25.5 g"),
        (DEGREE, 256, "256 is outside 0° to 255°"),
        *((DEGREE, value, "a number is needed") for value in (True, math.nan, math.inf)),
        (FLAG, 1, "expected true, false"),
        (INVERTED, 0, "expected true, false"),
        (BAUD, 115201, "115201 is not one of 4800, 9600, 19200, 38400, 57600, 115200"),
        (BAUD, True, "True is not one of 4800, 9600, 19200, 38400, 57600, 115200"),
        *((Done(), value, "expected true") for value in (False, 1)),
    ],
)
def test_what_a_byte_cannot_carry_is_refused_with_what_it_can(field: Field, value: Value, said: str) -> None:
    with pytest.raises(ValueRefused) as refused:
        field.encode(value)
    assert str(refused.value) == said


@pytest.mark.parametrize("field", QUANTITIES, ids=str)
@given(value=st.floats(allow_nan=True, allow_infinity=True) | st.integers())
def test_a_number_is_carried_exactly_or_refused(field: Quantity, value: float) -> None:
    try:
        raw = field.encode(value)
    except ValueRefused:
        assert value not in map(field.decode, range(256))
    else:
        assert field.decode(raw) == value
