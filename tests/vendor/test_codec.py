"""The product's codec reads what the vendor's table prints."""

import pytest

from app.captures.explain import meaning
from protocol.catalogue import BY_NAME, Request
from protocol.messages import Direction, Frame, Noise, Status, TriggerRecord, decode
from protocol.stream import StreamParser
from tests.vendor import table
from tests.vendor.frames import VECTORS, Vector

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
