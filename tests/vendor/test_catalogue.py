"""The product's catalogue says what the vendor's table says.

The product's codec reads what the vendor's table prints.
"""

from typing import Any

import pytest

from app.captures.explain import meaning
from protocol import catalogue
from protocol.catalogue import BY_NAME, COMMANDS, Request
from protocol.fields import ValueRefused
from protocol.messages import Direction, Frame, Noise, Status, TriggerRecord, decode
from protocol.stream import StreamParser
from tests.vendor import table
from tests.vendor.frames import FROM_HOST, VALID, VECTORS, Vector


@pytest.mark.parametrize("vector", FROM_HOST, ids=lambda vector: vector.id)
def test_each_frame_of_the_host_is_made_as_it_is_printed(vector: Vector) -> None:
    command, values = BY_NAME[vector.command], dict[str, Any](vector.means or {})
    del values["command"]
    made = command.set(*values.values() or [True]) if vector.is_set else command.query()
    assert made.encode() == vector.raw


def test_nothing_else_is_known_or_can_be_asked_or_set() -> None:
    assert {command.name for command in COMMANDS} == {vector.command for vector in VALID}
    asked = {command.name for command in COMMANDS if command.query_data is not None}
    can_be_set = {command.name for command in COMMANDS if command.write is not None}
    assert asked == {vector.command for vector in FROM_HOST if not vector.is_set}
    assert can_be_set == {vector.command for vector in FROM_HOST if vector.is_set}


@pytest.mark.parametrize("name", table.STEPS)
def test_scales(name: str) -> None:
    command = BY_NAME[name]
    assert command.reply is not None
    for byte in range(256):
        value = byte / table.STEPS[name]
        assert command.reply.decode(byte) == value
        if command.write is not None:
            assert command.set(value).data == byte


def test_baud_codes() -> None:
    command = BY_NAME["baud_rate"]
    assert command.reply is not None
    for code, rate in table.BAUD_CODES.items():
        assert command.set(rate).data == code
        assert command.reply.decode(code) == rate
    assert command.reply.allowed == set(table.BAUD_CODES)
    assert set(catalogue.BAUD_RATES) == set(table.BAUD_CODES.values())
    assert table.BAUD_CODES[table.DEFAULTS["baud_rate"]] == catalogue.DEFAULT_BAUD_RATE
    with pytest.raises(ValueRefused):
        command.set(14400)


@pytest.mark.parametrize("name", ["active", "triggered"])
def test_anything_but_01_means_no(name: str) -> None:
    reply = BY_NAME[name].reply
    assert reply is not None
    assert [byte for byte in range(256) if reply.decode(byte)] == [0x01]
    assert reply.allowed == set(range(256))


def test_defaults_and_advice() -> None:
    assert {one.name: one.default for one in COMMANDS if one.default is not None} == table.DEFAULTS
    attitude = BY_NAME["attitude_threshold"].advice
    assert attitude is not None
    assert attitude.is_followed_by(table.LOWEST_ADVISED_ATTITUDE_DEG)
    assert not attitude.is_followed_by(table.LOWEST_ADVISED_ATTITUDE_DEG - 1)
    acceleration = BY_NAME["freefall_acceleration"].advice
    assert acceleration is not None
    assert acceleration.is_followed_by(0.6)
    assert not acceleration.is_followed_by(table.ACCELERATION_ADVISED_BELOW_G)
    assert catalogue.RESET_BELOW_THRESHOLD_DEG == table.RESET_BELOW_THRESHOLD_DEG
    assert catalogue.MAX_RECORDS == table.RECORDS_KEPT


def test_codes_that_the_table_prints_for_another_command() -> None:
    """E3: the cell voltage comes as 35. E4: 17 is acknowledged as 16."""
    others = {one.name: set(one.reply_codes - {one.code}) for one in COMMANDS if one.reply_codes != {one.code}}
    assert others == {"cell_voltage": {0x35}, "freefall_trigger": {0x16}}


def test_codes_that_may_acknowledge_by_01() -> None:
    """E2."""
    assert {one.code for one in COMMANDS if one.acknowledged_by_one} == {0x21, 0x22, 0x24}


def test_places_of_the_values_in_the_long_frames() -> None:
    assert {part.name: part.first for part in catalogue.STATUS_PARTS} == table.STATUS_BYTES
    assert {part.name: part.first for part in catalogue.RECORD_PARTS} == table.RECORD_BYTES


EXAMPLE = bytes.fromhex("41 75 35 01 01 00 6c 02 3c 05 a0 00 01 0c eb 7e")


def with_sum(body: bytes) -> bytes:
    return b"\x41\x75" + body + bytes((sum(body) % 256,))


def pieces(data: bytes, asked: Request | None = None) -> list[Frame | Noise]:
    parser = StreamParser(asked=asked)
    return parser.feed(data) + parser.flush()


def request(name: str | None) -> Request | None:
    """Return what stands for a question of this name; the flags can only be set."""
    if name is None:
        return None
    command = BY_NAME[name]
    return command.set(True) if command.query_data is None else command.query()


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
def test_every_frame_of_the_table(vector: Vector) -> None:
    asked = request(vector.while_asked)
    (piece,) = pieces(vector.raw, asked)
    if vector.means is None:
        assert isinstance(piece, Noise)
        return
    assert isinstance(piece, Frame)
    assert piece.raw == vector.raw
    expected = Direction.HOST_TO_MODULE if vector.raw[:2] == b"\x42\x61" else Direction.MODULE_TO_HOST
    assert piece.direction is expected
    assert meaning(piece, None if asked is None else asked.command).items() >= vector.means.items()


def test_the_row_of_35_as_it_is_printed_is_no_record() -> None:
    """E5: the row stops after 14 of its 16 bytes."""
    printed = bytes.fromhex("41 75 35 01 01 00 6c 02 3c 05 a0 00 01 0c")
    assert not [piece for piece in pieces(printed, BY_NAME["trigger_records"].query()) if isinstance(piece, Frame)]


def status(**values: int) -> Status:
    data = bytearray((0x32, 7, 10, 0, 1))
    for name, byte in values.items():
        data[table.STATUS_BYTES[name] - 2] = byte
    raw = with_sum(bytes(data))
    assert len(raw) == table.STATUS_LENGTH
    found = decode(raw)
    assert isinstance(found, Status)
    return found


def test_bytes_of_the_status() -> None:
    assert status() == Status(7, 1.0, triggered=False, active=True)
    assert status(tilt_deg=61).tilt_deg == 61
    assert status(acceleration_g=0x75).acceleration_g == 11.7
    assert status(triggered=1).triggered
    assert not status(active=0).active


def record(**values: int) -> TriggerRecord:
    data = bytearray(EXAMPLE[2:-1])
    for name, byte in values.items():
        data[table.RECORD_BYTES[name] - 2] = byte
    raw = with_sum(bytes(data))
    assert len(raw) == table.RECORD_LENGTH
    found = decode(raw, BY_NAME["trigger_records"].query())
    assert isinstance(found, TriggerRecord)
    return found


@pytest.mark.parametrize("name", table.RECORD_STEPS)
def test_scales_of_a_record(name: str) -> None:
    for byte in range(256):
        assert getattr(record(**{name: byte}), name) == byte / table.RECORD_STEPS[name]


@pytest.mark.parametrize("name", table.RECORD_YES)
def test_senses_of_a_record(name: str) -> None:
    yes = table.RECORD_YES[name]
    assert getattr(record(**{name: yes}), name) is True
    assert getattr(record(**{name: 1 - yes}), name) is False


def test_uptime_and_sources_of_a_record() -> None:
    assert record().uptime_s == 108
    assert record(uptime_s=0xFF).uptime_s == 0xFF6C
    for bit, name in table.SOURCES.items():
        assert record(sources=bit).sources == (name,)
    assert record(sources=0x0A).sources == ("attitude", "freefall")


def test_one_byte_of_a_record_is_one_value() -> None:
    before = record()._asdict()
    for name in table.RECORD_BYTES:
        other = {"serial_connected": 1, "charging": 0}.get(name, 0x11)
        after = record(**{name: other})._asdict()
        changed = {one for one in before if one != "raw" and before[one] != after[one]}
        assert changed == {name}
