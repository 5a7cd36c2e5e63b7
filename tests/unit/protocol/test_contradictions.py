"""Where the vendor's table contradicts itself: E1 … E15, as far as its own frames (`vectors`) do not show it.

The catalogue, the link, the device and the simulated module have tests of their own that bear the same names.
"""

import pytest

from app.captures.explain import meaning
from protocol.catalogue import BY_NAME, RECORD_CODE
from protocol.frame import Frame, Noise, Reason, encode_long, encode_reply
from protocol.messages import Acknowledgement, EmptySlot, Reading, TriggerRecord, decode
from protocol.stream import StreamParser
from tests.vendor.frames import BY_ID

STATUS = BY_ID["status-example"].raw
EXAMPLE = BY_ID["trigger-record-example"].raw


def parsed(data: bytes, asked: str | None = None) -> list[Frame | Noise]:
    parser = StreamParser(asked=BY_NAME[asked].query() if asked else None)
    return parser.feed(data) + parser.flush()


def record(**changed: int) -> TriggerRecord | EmptySlot:
    """The table's example with other bytes, by the table's byte numbers: d13=…"""
    data = bytearray(EXAMPLE[3:-1])
    for name, value in changed.items():
        data[int(name.removeprefix("d")) - 3] = value
    message = decode(encode_long(RECORD_CODE, bytes(data)))
    assert isinstance(message, TriggerRecord | EmptySlot)
    return message


@pytest.mark.parametrize("asked", [None, "attitude_threshold"])
def test_e01_the_misprinted_reply_is_a_checksum_error(asked: str | None) -> None:
    misprint = BY_ID["attitude-threshold-reply-misprint"].raw
    (noise,) = parsed(misprint, asked)
    assert isinstance(noise, Noise)
    assert (noise.raw, noise.reason) == (misprint, Reason.CHECKSUM)
    assert isinstance(parsed(misprint[:-1] + b"\x5d")[0], Frame)


def test_e03_every_record_that_begins_like_a_voltage_is_a_record() -> None:
    for boot_count in range(256):
        uptime_high = (0x36 + boot_count) & 0xFF
        raw = encode_long(RECORD_CODE, bytes((1, boot_count, uptime_high)) + EXAMPLE[6:-1])
        for asked in (None, "trigger_records", "status"):
            assert [piece.raw for piece in parsed(raw + STATUS, asked)] == [raw, STATUS]


def test_e04_the_acknowledgement_of_17_comes_with_code_16_or_17() -> None:
    freefall, attitude = BY_NAME["freefall_trigger"].set(False), BY_NAME["attitude_trigger"].set(False)
    assert decode(encode_reply(0x16, 1), freefall) == Acknowledgement(freefall, 1)
    assert decode(encode_reply(0x17, 1), freefall) == Acknowledgement(freefall, 1)
    assert decode(encode_reply(0x16, 1), attitude) == Acknowledgement(attitude, 1)
    assert decode(encode_reply(0x17, 1), attitude) == Reading(BY_NAME["freefall_trigger"], 1)


def test_e04_with_nothing_asked_a_16_is_not_put_down_to_one_of_the_two() -> None:
    (frame,) = parsed(encode_reply(0x16, 1))
    assert isinstance(frame, Frame)
    assert meaning(frame)["may_answer"] == ["attitude_trigger", "freefall_trigger"]
    assert "may_answer" not in meaning(frame, BY_NAME["attitude_trigger"])


@pytest.mark.parametrize("filling", [0x00, 0xFF])
def test_e07_a_slot_of_all_00_or_all_ff_is_empty_and_no_trigger(filling: int) -> None:
    raw = encode_long(RECORD_CODE, b"\1" + bytes((filling,)) * 11)
    (frame,) = parsed(raw, "trigger_records")
    assert isinstance(frame, Frame)
    assert decode(frame.raw) == EmptySlot(raw)
    assert meaning(frame) == {"command": "trigger_records", "empty": True}


def test_e11_the_light_is_a_voltage_and_no_open_or_closed() -> None:
    """Which way it moves with light is not said, so the codec hands on the number and nothing else."""
    (frame,) = parsed(encode_reply(0x14, 0x03), "light")
    assert isinstance(frame, Frame)
    assert meaning(frame) == {"command": "light", "light_v": 0.3}


@pytest.mark.parametrize(
    ("d14", "d12", "implausible"),
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
    d14: int, d12: int, implausible: tuple[str, ...]
) -> None:
    one = record(d14=d14, d12=d12)
    assert isinstance(one, TriggerRecord)
    assert one.cell_voltage_v == d14 / 50
    assert one.implausible == implausible
