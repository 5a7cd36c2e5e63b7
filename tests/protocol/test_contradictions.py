"""Where the vendor's table contradicts itself: E1 … E15, as far as bytes and their meaning go.

The link, the device and the simulated module have tests of their own that bear the same names.
"""

import pytest

from app.captures.explain import meaning
from protocol.catalogue import BY_CODE, BY_NAME, COMMANDS, RECORD_CODE, Hazard
from protocol.frame import Frame, Noise, Reason, encode_long, encode_reply
from protocol.messages import Acknowledgement, EmptySlot, Reading, TriggerRecord, decode
from protocol.stream import StreamParser
from tests.support.line.vectors import BY_ID

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
    assert (noise.raw, noise.reason, noise.detail) == (misprint, Reason.CHECKSUM, "checksum 50, the sum is 5D")
    assert isinstance(parsed(misprint[:-1] + b"\x5d")[0], Frame)


def test_e02_a_01_in_reply_to_a_set_is_never_shown_as_the_value() -> None:
    (frame,) = parsed(encode_reply(0x22, 0x01))
    assert isinstance(frame, Frame)
    assert meaning(frame, BY_NAME["freefall_time"].set(1.6)) == {"command": "freefall_time", "acknowledged": True}
    assert meaning(frame, BY_NAME["freefall_time"].query()) == {"command": "freefall_time", "value_s": 0.01}
    assert meaning(frame) == {"command": "freefall_time", "value_s": None}


@pytest.mark.parametrize("code", [0x34, 0x35])
def test_e03_a_cell_voltage_comes_with_code_34_or_35(code: int) -> None:
    query = BY_NAME["cell_voltage"].query()
    (frame,) = parsed(encode_reply(code, 0xBE), "cell_voltage")
    assert isinstance(frame, Frame)
    message = decode(frame.raw, query)
    assert message == Reading(BY_NAME["cell_voltage"], 0xBE)
    assert message.value == 3.8


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


def test_e05_the_record_of_the_code_notes_is_whole_and_the_row_of_the_table_is_not() -> None:
    assert [piece.raw for piece in parsed(EXAMPLE)] == [EXAMPLE]
    (noise,) = parsed(EXAMPLE[:14])
    assert isinstance(noise, Noise)
    assert noise.reason is Reason.INCOMPLETE


@pytest.mark.parametrize("count", [0, 1, 2, 9])
def test_e06_as_many_records_as_come_are_taken_in_their_order(count: int) -> None:
    raws = [encode_long(RECORD_CODE, bytes((1, number)) + EXAMPLE[5:-1]) for number in range(1, count + 1)]
    pieces = parsed(b"".join(raws), "trigger_records")
    assert [piece.raw for piece in pieces] == raws
    assert all(isinstance(decode(raw), TriggerRecord) for raw in raws)


@pytest.mark.parametrize("filling", [0x00, 0xFF])
def test_e07_a_slot_of_all_00_or_all_ff_is_empty_and_no_trigger(filling: int) -> None:
    raw = encode_long(RECORD_CODE, b"\1" + bytes((filling,)) * 11)
    (frame,) = parsed(raw, "trigger_records")
    assert isinstance(frame, Frame)
    assert decode(frame.raw) == EmptySlot(raw)
    assert meaning(frame) == {"command": "trigger_records", "empty": True}


def test_e08_the_flags_and_the_serial_output_cannot_be_asked_for() -> None:
    unreadable = {command.name for command in COMMANDS if command.is_setting and not command.can_be_asked}
    assert unreadable == {"serial_output", "attitude_trigger", "freefall_trigger", "baud_rate"}
    for name in unreadable:
        with pytest.raises(LookupError):
            BY_NAME[name].query()


def test_e09_a_change_of_the_baud_rate_is_dangerous_and_never_repeated() -> None:
    for raw in BY_NAME["baud_rate"].write_hazards:
        request = BY_NAME["baud_rate"].set({1: 4800, 2: 9600, 3: 19200, 4: 38400, 5: 57600, 6: 115200}[raw])
        assert request.hazard is Hazard.DANGEROUS
        assert not request.is_repeatable


def test_e10_any_attitude_threshold_can_be_sent_and_below_55_is_against_advice() -> None:
    command = BY_NAME["attitude_threshold"]
    assert command.advice is not None
    for degrees in range(256):
        assert command.set(degrees).data == degrees
        assert command.advice.is_followed_by(degrees) is (degrees >= 55)


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


def test_e14_d13_of_a_record_is_the_light_at_the_trigger() -> None:
    one = record(d13=0x21)
    assert isinstance(one, TriggerRecord)
    assert one.light_v == 3.3


def test_e15_forbidding_the_deployment_is_as_dangerous_as_firing() -> None:
    forbid = BY_CODE[0x11].set(False)
    assert forbid.encode() == BY_ID["deploy-forbid"].raw
    assert forbid.hazard is Hazard.DANGEROUS
    assert decode(BY_ID["deploy-forbid-ack"].raw, forbid) == Acknowledgement(forbid, 0)
