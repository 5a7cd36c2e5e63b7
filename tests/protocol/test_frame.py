"""One frame: what makes it valid, and the bytes that the codec builds."""

import pytest

from protocol.catalogue import BY_CODE, BY_NAME, RECORD_CODE, STATUS_CODE
from protocol.frame import (
    MAX_FRAME_LENGTH,
    Direction,
    Frame,
    Reason,
    check_host,
    checksum,
    decode_request,
    encode_long,
    encode_reply,
    is_empty_slot,
    module_check,
    module_lengths,
)
from tests.support.line.reference_decoder import REPLIES, REQUESTS, sum_is_right
from tests.support.line.vectors import FROM_HOST, FROM_MODULE, VALID, VECTORS, Vector


@pytest.mark.parametrize("vector", VALID, ids=lambda vector: vector.id)
def test_the_sum_of_every_frame_of_the_table(vector: Vector) -> None:
    assert checksum(vector.raw[2:-1]) == vector.raw[-1]


@pytest.mark.parametrize("vector", FROM_HOST, ids=lambda vector: vector.id)
def test_host_frames_both_ways(vector: Vector) -> None:
    request = decode_request(vector.raw)
    assert vector.means is not None
    assert request.command.name == vector.means["command"]
    assert request.encode() == vector.raw
    command = request.command
    if request.is_set:
        assert command.write is not None
        assert command.set(command.write.decode(request.data)).encode() == vector.raw
    else:
        assert command.query().encode() == vector.raw


@pytest.mark.parametrize("vector", FROM_MODULE, ids=lambda vector: vector.id)
def test_module_frames_are_built_byte_for_byte(vector: Vector) -> None:
    raw = vector.raw
    assert module_check(len(raw))(raw) is None
    assert len(raw) in module_lengths(raw[2])
    built = encode_reply(raw[2], raw[4]) if len(raw) == 6 and raw[2] != 1 else encode_long(raw[2], raw[3:-1])
    assert built == raw


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
            is_valid = module_check(6)(encode_reply(code, data)) is None
            assert is_valid is (code == RECORD_CODE or data in REPLIES[code])


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
def test_a_wrong_sum_is_told_with_both_numbers(vector: Vector) -> None:
    raw = vector.raw[:-1] + bytes((vector.raw[-1] ^ 0x80,))
    fault = check_host(raw) if vector.is_from_host else module_check(len(raw))(raw)
    assert not sum_is_right(raw)
    assert fault is not None
    assert fault.reason is Reason.CHECKSUM
    assert f"checksum {raw[-1]:02X}, the sum is {checksum(raw[2:-1]):02X}" == fault.detail


def test_lengths_by_code() -> None:
    assert module_lengths(0x32) == (8,)
    assert module_lengths(0x35) == (16, 6)
    assert module_lengths(0x34) == (6,)
    assert module_lengths(0x02) == ()
    assert max(length for code in BY_CODE for length in module_lengths(code)) == MAX_FRAME_LENGTH


@pytest.mark.parametrize(
    ("hex_text", "reason"),
    [
        ("", "no host frame"),
        ("42 61 34 01 00", "no host frame"),
        ("41 75 34 01 00 35", "no host frame"),
        ("42 61 34 01 00 35 00", "no host frame"),
        ("42 61 34 01 00 36", "checksum 36, the sum is 35"),
    ],
)
def test_what_is_no_request_is_refused_with_the_reason(hex_text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        decode_request(bytes.fromhex(hex_text))


@pytest.mark.parametrize(
    ("data", "is_empty"),
    [
        (bytes(11), True),
        (b"\xff" * 11, True),
        (bytes(10) + b"\1", False),
        (b"\1" + bytes(10), False),
        (b"\0\xff" * 5 + b"\0", False),
    ],
)
def test_an_unused_slot_is_all_00_or_all_ff(data: bytes, is_empty: bool) -> None:
    raw = encode_long(RECORD_CODE, b"\1" + data)
    assert is_empty_slot(raw) is is_empty


@pytest.mark.parametrize(("position", "name"), [(11, "serial link"), (12, "charging")])
def test_a_record_flag_that_is_neither_00_nor_01_is_rejected(position: int, name: str) -> None:
    data = bytearray(bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB"))
    data[position] = 0x02
    fault = module_check(16)(bytes(data) + bytes((checksum(bytes(data[2:])),)))
    assert fault is not None
    assert (fault.reason, fault.detail) == (Reason.VALUE, f"{name} flag 02, expected 00 or 01")


def test_a_record_with_another_control_byte_is_rejected() -> None:
    fault = module_check(16)(encode_long(RECORD_CODE, b"\2" + bytes(11)))
    assert fault is not None
    assert (fault.reason, fault.detail) == (Reason.CONTROL, "control byte 02, expected 01")


def test_code_of_a_frame() -> None:
    frame = Frame(Direction.HOST_TO_MODULE, BY_NAME["status"].query().encode())
    assert (frame.code, frame.offset) == (0x32, 0)
