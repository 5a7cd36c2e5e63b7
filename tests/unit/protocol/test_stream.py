"""The stream parser: frames and rejected bytes out of anything, in any cuts."""

import random
from collections import Counter
from itertools import chain, combinations, pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.catalogue import BY_NAME, Request
from protocol.messages import Frame, Noise, Reason, Status
from protocol.stream import Piece, StreamParser
from tests.support.line import reference_decoder
from tests.support.line.nasty_bytes import hostile_bytes, summed
from tests.support.thorough import IS_THOROUGH
from tests.vendor.frames import BY_ID

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


@given(nasty_streams, st.lists(st.integers(0, 200), max_size=20), asked_requests, st.booleans())
def test_cuts_change_neither_frames_nor_rejected_bytes(
    data: bytes, places: list[int], asked: Request | None, follows_host: bool
) -> None:
    whole = parse(data, asked=asked, follows_host=follows_host)
    pieces = parse(*cut(data, places), asked=asked, follows_host=follows_host)
    assert [piece for piece in pieces if isinstance(piece, Frame)] == [one for one in whole if isinstance(one, Frame)]
    assert rejected(pieces) == rejected(whole)


@given(nasty_streams | st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=5), asked_requests)
@pytest.mark.promise("g")
def test_every_byte_is_in_exactly_one_piece_in_order(data: bytes, places: list[int], asked: Request | None) -> None:
    pieces = parse(*cut(data, places), asked=asked)
    assert b"".join(piece.raw for piece in pieces) == data
    assert all(piece.raw and piece.raw == data[piece.offset :][: len(piece.raw)] for piece in pieces)


@pytest.mark.parametrize(
    ("hex_text", "reason"),
    [
        ("00 FF 13", Reason.NO_HEADER),
        ("41", Reason.NO_HEADER),
        ("41 75", Reason.INCOMPLETE),
        ("41 75 32", Reason.INCOMPLETE),
        ("41 75 99", Reason.UNKNOWN_CODE),
        ("41 75 32 07 0A 00 01", Reason.INCOMPLETE),
        ("42 61 32 01", Reason.INCOMPLETE),
        ("41 75 99 01 00 9A", Reason.UNKNOWN_CODE),
        ("42 61 99 01 00 9A", Reason.UNKNOWN_CODE),
        ("41 75 20 02 3C 5E", Reason.CONTROL),
        ("42 61 14 02 01 17", Reason.CONTROL),
        ("41 75 35 02 01 00", Reason.CONTROL),
        ("41 75 24 01 07 2C", Reason.VALUE),
        ("42 61 11 02 02 15", Reason.VALUE),
        ("41 75 01 A5 5B 01", Reason.VALUE),
        ("41 75 32 07 0A 00 01 45", Reason.CHECKSUM),
        ("41 75 35 01 BE F5", Reason.CHECKSUM),
        ("41 75 35 01 01 00 6C 02 3C 05", Reason.INCOMPLETE),
        (summed(LIKE_A_VOLTAGE[:11] + b"\2" + LIKE_A_VOLTAGE[12:15]).hex(), Reason.VALUE),
    ],
)  # fmt: skip
def test_rejected_bytes_carry_their_reason(hex_text: str, reason: Reason) -> None:
    raw = bytes.fromhex(hex_text)
    (noise,) = parse(raw)
    assert isinstance(noise, Noise)
    assert (noise.raw, noise.reason, noise.offset) == (raw, reason, 0)


def test_a_header_within_rejected_bytes_begins_a_frame() -> None:
    pieces = parse(b"Au\x20\x01" + STREAMED)
    assert frames(pieces) == [STREAMED]
    assert rejected(pieces) == {Reason.CHECKSUM: 4}
    for header, frame in ((b"Au", STREAMED), (b"Ba", STATUS.encode())):
        assert [frames(parse(header * count + frame)) for count in range(6)] == [[frame]] * 6


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
@given(nasty_streams, st.lists(st.integers(0, 200), max_size=20), asked_requests, st.booleans())
def test_both_decoders_agree_on_nasty_streams(
    data: bytes, places: list[int], asked: Request | None, follows_host: bool
) -> None:
    parser = StreamParser(asked=asked, follows_host=follows_host)
    pieces: list[Piece] = []
    for chunk in cut(data, places):
        pieces += parser.feed(chunk)
        assert parser.pending <= MOST_PENDING
    found = [(piece.offset, piece.raw) for piece in pieces + parser.flush() if isinstance(piece, Frame)]
    code = None if asked is None else asked.command.code
    assert found == reference_decoder.frames(data, asked=code, follows_host=follows_host)
