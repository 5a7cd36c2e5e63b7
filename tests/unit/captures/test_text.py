"""Bytes as text: read with times and without, damaged; what went over the line as entries."""

import random
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures.traffic import (
    MAX_ENTRY_BYTES,
    MAX_FAULTS,
    CaptureEntry,
    Explained,
    NotHex,
    TextReader,
    Way,
    entries_of,
    hex_bytes,
)
from protocol.catalogue import STATUS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.messages import Direction, Frame, Noise, Reason, Status
from tests.support.line.nasty_bytes import hostile_bytes
from tests.support.records.recordings_made import directions, explained

STATUS_FRAME = Status(7, 1.0, triggered=False, active=True).encode()


def read(lines: Iterable[str]) -> tuple[list[Explained], TextReader]:
    reader = TextReader()
    rows = [row for line in lines for row in reader.feed(line)]
    return [*rows, *reader.end()], reader


# With times


@given(
    st.lists(
        st.tuples(st.integers(0, 10**7), st.sampled_from(Way), st.binary(min_size=1, max_size=MAX_ENTRY_BYTES)),
        min_size=1,
        max_size=20,
    )
)
def test_any_entries_survive(drawn: list[tuple[int, Way, bytes]]) -> None:
    entries = [CaptureEntry(at / 1000, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
    rows, reader = read(entry.line for entry in entries)
    assert rows == list(explained(entries))
    assert directions([(row.way, row.piece.raw) for row in rows]) == directions([entry[1:] for entry in entries])
    assert reader.faults == []


def test_lines_that_cannot_be_read_are_left_out_and_named() -> None:
    text = (
        "# DPS-S capture 1", "1.0 < 41 75", "what is this", "1.5 < 4", "1.6 < zz", "0.5 < 33", "2.0 > ", "",
        "# a remark: with a colon", "3.5 < 0x41,0x75\r",
    )  # fmt: skip
    rows, reader = read(text)
    assert b"".join(row.piece.raw for row in rows) == b"Au3Au"
    assert all(row.at_s is not None and row.at_s >= 1.0 for row in rows)
    assert [number for number, _ in reader.faults] == [3, 4, 5, 6]
    for _ in range(5000):
        reader.feed("?")
    assert len(reader.faults) == MAX_FAULTS


def test_what_a_pause_cuts_is_explained_as_broken_off() -> None:
    entries = (CaptureEntry(0.0, Way.IN, STATUS_FRAME[:4]), CaptureEntry(1.0, Way.IN, STATUS_FRAME))
    pieces = [row.piece for row in explained(entries)]
    assert isinstance(pieces[0], Noise)
    assert pieces[-1].raw == STATUS_FRAME


# Without


def test_hex_text_is_read_without_times() -> None:
    query, reply = STATUS.query().encode(), bytes.fromhex("41 75 35 01 BE F4")
    rows, _ = read(["# from a logic analyser\n", f"{query.hex()}\n", f"{STATUS_FRAME.hex(' ')}, 0xFF\n"])
    assert [(row.at_s, row.way, row.piece.raw, row.asked) for row in rows] == [
        (None, Way.OUT, query, None),
        (None, Way.IN, STATUS_FRAME, STATUS.query()),
        (None, Way.IN, b"\xff", None),
    ]
    (only,), _ = read([reply[:3].hex(), reply[3:].hex()])
    assert only.piece.raw == reply, "a frame may go on in the next line"
    for other in (["hello"], ["41 75", "4"], ["41 7"], [random.Random(1).randbytes(5000).decode("latin-1")]):
        with pytest.raises(NotHex):
            read(other)


@given(st.integers(0, 2**64))
def test_every_byte_is_in_one_row(seed: int) -> None:
    data = hostile_bytes(random.Random(seed))
    rows, _ = read([data.hex()])
    assert b"".join(row.piece.raw for row in rows) == data


@given(st.binary(max_size=40), st.sampled_from(["", " ", ",", " 0x", ", 0X", "\r\n"]))
def test_hex_text_with_anything_between_the_bytes(data: bytes, between: str) -> None:
    assert hex_bytes("".join(between + f"{byte:02x}" for byte in data)) == data


# Entries


def test_events_become_what_went_over_the_wire() -> None:
    noise = Noise(b"\x00\xff", Reason.NO_HEADER, 0)
    frame = Frame(Direction.MODULE_TO_HOST, STATUS_FRAME)
    query = STATUS.query()
    events: list[Event] = [
        Sent(query.encode(), query, 1, 10.0),
        Received(frame, None, Role.STREAMED, 10.01),
        Rejected(noise, 10.01),
        Received(frame, None, Role.STREAMED, 10.02),
    ]
    entries = list(entries_of(events, started_at=10.0))
    assert [(round(entry.at_s, 3), entry.way, entry.raw) for entry in entries] == [
        (0.0, Way.OUT, query.encode()),
        (0.01, Way.IN, STATUS_FRAME + b"\x00\xff"),
        (0.02, Way.IN, STATUS_FRAME),
    ]
