"""Bytes as text: written and read back, with times and without, damaged; what went over the line as entries."""

import random
from contextlib import suppress
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures.entries import MAX_ENTRY_BYTES, CaptureEntry, Way, entries_of, line_of
from app.captures.explained import MAX_RUN_LENGTH, Explained, HexExplainer
from app.captures.text import MAX_FAULTS, NotHex, TextReader, TimedLines, hex_bytes
from app.procedures.read import read_everything
from protocol.catalogue import BY_NAME, STATUS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from protocol.messages import Status
from tests.support.line.nasty_bytes import hostile_bytes
from tests.support.line.sim_line import Rig
from tests.support.records.recordings_made import explained

STATUS_FRAME = Status(7, 1.0, triggered=False, active=True).encode()


def read(text: str) -> tuple[list[Explained], TextReader]:
    reader = TextReader()
    rows = [row for line in text.splitlines(keepends=True) for row in reader.feed(line)]
    return [*rows, *reader.end()], reader


def rows_of(*chunks: bytes, asked: str | None = None) -> list[Explained]:
    explainer = HexExplainer(BY_NAME[asked] if asked else None)
    return [row for chunk in chunks for row in explainer.feed(chunk)] + explainer.end()


# With times


@given(
    st.lists(
        st.tuples(st.integers(0, 10**7), st.sampled_from(Way), st.binary(min_size=1, max_size=MAX_ENTRY_BYTES)),
        max_size=20,
    )
)
def test_any_entries_survive(drawn: list[tuple[int, Way, bytes]]) -> None:
    entries = [CaptureEntry(at / 1000, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
    lines = TimedLines()
    assert [lines.feed(line_of(entry)) for entry in entries] == entries
    assert lines.faults == []


def test_lines_that_cannot_be_read_are_left_out_and_named() -> None:
    lines = TimedLines()
    text = (
        "# DPS-S capture 1", "1.0 < 41 75", "what is this", "1.5 < 4", "1.6 < zz", "0.5 < 33", "2.0 > ", "",
        "# a remark: with a colon", f"3.0 < {'00' * 40_000}", "3.5 < 0x41,0x75\r",
    )  # fmt: skip
    assert [(entry.at_s, entry.raw) for entry in map(lines.feed, text) if entry] == [
        (1.0, b"Au"),
        (1.0, b"3"),
        (3.5, b"Au"),
    ]
    assert [fault.line for fault in lines.faults] == [3, 4, 5, 6, 10]
    for _ in range(5000):
        lines.feed("?")
    assert len(lines.faults) == MAX_FAULTS


@given(st.text(alphabet="0123456789.<>#AuBa \n:DPS-capture1", max_size=300))
def test_any_text_is_read_or_refused(text: str) -> None:
    lines = TimedLines()
    entries = [entry for entry in map(lines.feed, text.splitlines()) if entry]
    sent = [row.piece.raw for row in explained(entries) if row.way is Way.OUT]
    assert b"".join(sent) == b"".join(entry.raw for entry in entries if entry.way is Way.OUT)
    with suppress(NotHex):
        read(text)


def test_what_a_pause_cuts_is_explained_as_broken_off() -> None:
    entries = (CaptureEntry(0.0, Way.IN, STATUS_FRAME[:4]), CaptureEntry(1.0, Way.IN, STATUS_FRAME))
    pieces = [row.piece for row in explained(entries)]
    assert isinstance(pieces[0], Noise)
    assert pieces[-1].raw == STATUS_FRAME


# Without


def test_hex_text_is_read_without_times() -> None:
    rows, reader = read(f"# from a logic analyser\n{STATUS.query().encode().hex()}\n{STATUS_FRAME.hex(' ')}, 0xFF\n")
    assert not reader.is_timed
    assert [(row.way, row.piece.raw) for row in rows] == [
        (Way.OUT, STATUS.query().encode()),
        (Way.IN, STATUS_FRAME),
        (Way.IN, b"\xff"),
    ]
    assert 0 < rows[-1].at_s < 0.01
    for other in ("hello\nworld\n", "41 75\n4\n", "41 7", random.Random(1).randbytes(5000).decode("latin-1")):
        with pytest.raises(NotHex):
            read(other)


@given(st.integers(0, 2**64), st.lists(st.integers(0, 150), max_size=12), st.sampled_from([None, *BY_NAME]))
def test_cuts_do_not_show_in_the_rows(seed: int, places: list[int], asked: str | None) -> None:
    data = hostile_bytes(random.Random(seed))
    edges = [0, *sorted(min(place, len(data)) for place in places), len(data)]
    rows = rows_of(*(data[start:end] for start, end in pairwise(edges)), asked=asked)
    assert rows == rows_of(data, asked=asked)
    assert b"".join(row.piece.raw for row in rows) == data


@pytest.mark.parametrize("step", [1, 700, 4096, 10_000])
def test_a_run_without_end_is_bounded(step: int) -> None:
    garbage = bytes(10_000)
    rows = rows_of(*(garbage[at : at + step] for at in range(0, len(garbage), step)))
    assert [(row.piece.offset, len(row.piece.raw)) for row in rows] == [
        (0, MAX_RUN_LENGTH),
        (MAX_RUN_LENGTH, MAX_RUN_LENGTH),
        (2 * MAX_RUN_LENGTH, 10_000 - 2 * MAX_RUN_LENGTH),
    ]
    assert all(isinstance(row.piece, Noise) for row in rows)


@given(st.binary(max_size=40), st.sampled_from(["", " ", ",", " 0x", ", 0X", "\r\n"]))
def test_hex_text_with_anything_between_the_bytes(data: bytes, between: str) -> None:
    assert hex_bytes("".join(between + f"{byte:02x}" for byte in data)) == data


@given(st.text(alphabet="0123456789abcdefxXgG ,\n-é", max_size=30))
def test_any_other_text_is_refused_by_a_word_of_it(text: str) -> None:
    word = text[:1]
    try:
        hex_bytes(text)
    except NotHex as refused:
        word = refused.word
    assert word in text
    assert bool(word) == bool(text)


# Entries


def test_events_become_what_went_over_the_wire() -> None:
    noise = Noise(b"\x00\xff", Fault(Reason.NO_HEADER, "no frame header"), 0)
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


def test_a_session_is_captured_whole() -> None:
    """Every byte that the port gave and took is in it, in order."""
    rig = Rig({"history": "2", "corrupt": "0.01", "seed": "3"})
    rig.run(read_everything())
    rig.step_for(1.0)
    entries = list(entries_of(rig.session.take_events(), started_at=rig.session.opened_at))
    assert b"".join(entry.raw for entry in entries if entry.way is Way.IN) == bytes(rig.line.arrived)
    assert b"".join(entry.raw for entry in entries if entry.way is Way.OUT) == bytes(rig.line.sent)
