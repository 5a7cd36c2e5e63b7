"""What frames mean, with and without what was asked, and which pass; the values themselves: `tests.vendor`.

What a byte can carry, which bit errors are noticed, which requests are dangerous, and the parser in any cuts.
"""

import math
import random
from collections import Counter
from collections.abc import Iterator
from itertools import chain, combinations, pairwise

import pytest
from hypothesis import given, settings
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
    SET,
    STATUS_CODE,
    TENTH_G,
    TENTH_VOLT,
    Hazard,
    Request,
)
from protocol.fields import Done, Field, Quantity, Value, ValueRefused
from protocol.messages import (
    Acknowledgement,
    EmptySlot,
    Frame,
    Noise,
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
from protocol.stream import Piece, StreamParser
from tests.support.thorough import IS_THOROUGH
from tests.unit.protocol import reference_decoder
from tests.unit.protocol.nasty_bytes import hostile_bytes, summed
from tests.unit.protocol.reference_decoder import REPLIES, REQUESTS
from tests.vendor.frames import BY_ID, FROM_HOST, FROM_MODULE, VALID, Vector


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
    one = decode_record(encode_long(RECORD_CODE, bytes((1, 1, 0, 108, 2, 60, 5, 160, 0, charging, 12, cell))))
    assert isinstance(one, TriggerRecord)
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
    ("asked", "raw", "is_accepted"),
    [
        (BY_NAME["freefall_time"].set(1.6), 0xA0, True),
        (BY_NAME["freefall_time"].set(1.6), 0x01, True),
        (BY_NAME["freefall_time"].set(1.6), 0x9F, False),
        (BY_NAME["freefall_acceleration"].set(0.5), 0x01, True),
        (BY_NAME["baud_rate"].set(115200), 0x01, True),
        (BY_NAME["attitude_threshold"].set(60), 0x3C, True),
        (BY_NAME["attitude_threshold"].set(60), 0x01, False),
        (BY_NAME["activation"].set(True), 0x00, False),
        (BY_NAME["activation"].set(False), 0x01, False),
        (BY_NAME["zero_sensor"].query(), 0x01, True),
        (BY_NAME["shutdown"].set(True), 0x01, True),
    ],
)
def test_e02_what_counts_as_acknowledged(asked: Request, raw: int, is_accepted: bool) -> None:
    message = decode(encode_reply(asked.command.code, raw), asked)
    assert isinstance(message, Acknowledgement)
    assert (message.request, message.is_accepted) == (asked, is_accepted)


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


@pytest.mark.parametrize("vector", VALID, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_e13_no_one_bit_error_goes_unnoticed(vector: Vector) -> None:
    asked = BY_NAME[vector.while_asked].query() if vector.while_asked == "cell_voltage" else None
    assert all(not frames_in(corrupted, asked) for corrupted in corruptions(vector.raw, 1))


DANGEROUS = {
    "42 61 10 02 01",  # activate
    "42 61 11 02 00",  # forbid deploying: for how long, nobody knows (E15)
    "42 61 11 02 01",  # fire
    "42 61 12 02 01",  # shut down
    "42 61 24 02 01",  # the six baud rates (E9)
    "42 61 24 02 02",
    "42 61 24 02 03",
    "42 61 24 02 04",
    "42 61 24 02 05",
    "42 61 24 02 06",
    "42 61 25 01 00",  # zero the sensor, in the shape of a query
}


def test_e09_exactly_these_requests_are_dangerous_and_the_questions_of_the_table_may_be_repeated() -> None:
    queries = [command.query() for command in COMMANDS if command.query_data is not None]
    sets = [Request(one, SET, raw) for one in COMMANDS if one.write is not None for raw in one.write.allowed]
    dangerous = [one for one in (*queries, *sets) if one.hazard is Hazard.DANGEROUS]
    assert {one.encode()[:-1].hex(" ").upper() for one in dangerous} == DANGEROUS
    repeatable = {one.encode() for one in (*queries, *sets) if one.is_repeatable}
    asked = {vector.raw for vector in FROM_HOST if not vector.is_set and vector.command != "zero_sensor"}
    assert repeatable == asked


VOLTAGE = BY_NAME["cell_voltage"].query()
RECORDS = BY_NAME["trigger_records"].query()
STATUS = BY_NAME["status"].query()
MOST_PENDING = 15
LIKE_A_VOLTAGE = BY_ID["trigger-record-that-begins-like-a-voltage"].raw
VOLTAGE_AS_35 = BY_ID["cell-voltage-reply-35-3.8V"].raw
STREAMED = Status(7, 1.0, triggered=False, active=True).encode()

asked_requests = st.sampled_from([None, VOLTAGE, RECORDS, STATUS])
nasty_streams = st.integers(0, 2**64).map(lambda seed: hostile_bytes(random.Random(seed)))


def parse(*chunks: bytes, asked: Request | None = None, follows_host: bool = False) -> list[Piece]:
    """All pieces of a stream that is fed in these chunks and then falls quiet."""
    parser = StreamParser(asked=asked, follows_host=follows_host)
    pieces = [piece for chunk in chunks for piece in parser.feed(chunk)]
    return pieces + parser.flush()


def frames(pieces: list[Piece]) -> list[bytes]:
    return [piece.raw for piece in pieces if isinstance(piece, Frame)]


def rejected(pieces: list[Piece]) -> Counter[Reason]:
    """Rejected bytes by reason, as the link counts them."""
    counted: Counter[Reason] = Counter()
    for piece in pieces:
        if isinstance(piece, Noise):
            counted[piece.reason] += len(piece.raw)
    return counted


def cut(data: bytes, places: list[int]) -> list[bytes]:
    edges = [0, *sorted(place % (len(data) + 1) for place in places), len(data)]
    return [data[start:end] for start, end in pairwise(edges)]


@pytest.mark.parametrize(
    ("hex_text", "reason"),
    [
        ("00 FF 13", Reason.NO_HEADER),
        ("41 75 32 07 0A 00 01", Reason.INCOMPLETE),
        ("41 75 99 01 00 9A", Reason.UNKNOWN_CODE),
        ("42 61 99 01 00 9A", Reason.UNKNOWN_CODE),
        ("41 75 20 02 3C 5E", Reason.CONTROL),
        ("41 75 35 02 01 00", Reason.CONTROL),
        ("41 75 24 01 07 2C", Reason.VALUE),
        ("41 75 01 A5 5B 01", Reason.VALUE),
        ("41 75 32 07 0A 00 01 45", Reason.CHECKSUM),
        ("41 75 35 01 01 00 6C 02 3C 05", Reason.INCOMPLETE),
        (summed(LIKE_A_VOLTAGE[:11] + b"\2" + LIKE_A_VOLTAGE[12:15]).hex(), Reason.VALUE),
        (summed(LIKE_A_VOLTAGE[:12] + b"\2" + LIKE_A_VOLTAGE[13:15]).hex(), Reason.VALUE),
    ],
)  # fmt: skip
def test_rejected_bytes_carry_their_reason(hex_text: str, reason: Reason) -> None:
    raw = bytes.fromhex(hex_text)
    (noise,) = parse(raw)
    assert isinstance(noise, Noise)
    assert (noise.raw, noise.reason, noise.offset) == (raw, reason, 0)


@pytest.mark.parametrize(("asked", "most_cuts"), [(None, 15 if IS_THOROUGH else 4), (RECORDS, 4), (STATUS, 4)])
@pytest.mark.parametrize("following", [b"", STREAMED * 2], ids=["alone", "followed"])
def test_e03_a_record_that_begins_like_a_voltage_is_a_record_in_every_chunking(
    asked: Request | None, most_cuts: int, following: bytes
) -> None:
    inner = range(1, len(LIKE_A_VOLTAGE))
    for places in chain.from_iterable(combinations(inner, count) for count in range(most_cuts + 1)):
        chunks = cut(LIKE_A_VOLTAGE, list(places))
        parser = StreamParser(asked=asked)
        pieces = [piece for chunk in (*chunks, following) for piece in parser.feed(chunk)]
        assert frames(pieces) == [LIKE_A_VOLTAGE] + [STREAMED] * (len(following) // 8)
        assert parser.pending == 0


@pytest.mark.parametrize("asked", [None, VOLTAGE, STATUS])
@pytest.mark.parametrize("step", range(1, 16))
def test_e03_a_voltage_before_streamed_frames_is_six_bytes(asked: Request | None, step: int) -> None:
    for tilt in range(256):  # for one of them the sixteen bytes have the checksum of a record
        streamed = Status(tilt, 1.0, triggered=False, active=True).encode()
        data = VOLTAGE_AS_35 + streamed * 2
        chunks = [data[at : at + step] for at in range(0, len(data), step)]
        assert frames(parse(*chunks, asked=asked)) == [VOLTAGE_AS_35, streamed, streamed]


@pytest.mark.parametrize("asked", [None, RECORDS, STATUS])
def test_e03_a_record_that_is_damaged_behind_its_sixth_byte_is_no_voltage(asked: Request | None) -> None:
    for position in range(6, 16):
        for bit in range(8):
            damaged = bytearray(LIKE_A_VOLTAGE)
            damaged[position] ^= 1 << bit
            assert frames(parse(bytes(damaged) + STREAMED, asked=asked)) == [STREAMED]
    for length in range(6 if asked is RECORDS else 7, 16):
        assert frames(parse(LIKE_A_VOLTAGE[:length], asked=asked)) == []


@settings(max_examples=5000 if IS_THOROUGH else 500)
@pytest.mark.promise("g")
@given(
    nasty_streams | st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=20), asked_requests, st.booleans()
)
def test_both_decoders_agree_and_every_byte_is_in_exactly_one_piece_in_order(
    data: bytes, places: list[int], asked: Request | None, follows_host: bool
) -> None:
    parser = StreamParser(asked=asked, follows_host=follows_host)
    pieces: list[Piece] = []
    for chunk in cut(data, places):
        pieces += parser.feed(chunk)
        assert parser.pending <= MOST_PENDING
    pieces += parser.flush()
    assert b"".join(piece.raw for piece in pieces) == data
    assert all(piece.raw and piece.raw == data[piece.offset :][: len(piece.raw)] for piece in pieces)
    found = [(piece.offset, piece.raw) for piece in pieces if isinstance(piece, Frame)]
    code = None if asked is None else asked.command.code
    assert found == reference_decoder.frames(data, asked=code, follows_host=follows_host)
    assert rejected(pieces) == rejected(parse(data, asked=asked, follows_host=follows_host)), "in any cuts"
