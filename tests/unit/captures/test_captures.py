"""Captures: read as text with times and without, what went over the line as entries, frames in words and values."""

import random
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures.explain import Asked, meaning, sentence
from app.captures.traffic import (
    MAX_FAULTS,
    CaptureEntry,
    Explained,
    Explainer,
    NotHex,
    TextReader,
    entries_of,
    hex_bytes,
)
from app.text.i18n import CHINESE, set_language
from protocol.catalogue import BY_NAME, COMMANDS, SET, STATUS, Command, Request
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.messages import Direction, Frame, Noise, Reason, Status, encode_reply
from protocol.stream import StreamParser
from tests.support.records.recordings_made import directions, explained

STATUS_FRAME = Status(7, 1.0, triggered=False, active=True).encode()


def read(lines: Iterable[str]) -> tuple[list[Explained], TextReader]:
    reader = TextReader()
    rows = [row for line in lines for row in reader.feed(line)]
    return [*rows, *reader.end()], reader


# With times


@given(
    st.lists(
        st.tuples(st.integers(0, 10**7), st.sampled_from(Direction), st.binary(min_size=1, max_size=4096)),
        min_size=1,
        max_size=20,
    )
)
def test_any_entries_survive(drawn: list[tuple[int, Direction, bytes]]) -> None:
    entries = [CaptureEntry(at / 1000, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
    rows, reader = read(entry.line for entry in entries)
    assert rows == list(explained(entries))
    assert directions([(row.direction, row.piece.raw) for row in rows]) == directions([entry[1:] for entry in entries])
    assert reader.faults == []


def test_lines_that_cannot_be_read_are_left_out_and_named() -> None:
    text = (
        "# DPS-S capture 1", "1.0 < 41 75", "what is this", "1.5 < 4", "1.6 < zz", "0.5 < 33", "2.0 > ", "",
        "# a remark: with a colon", "3.5 < 0x41,0x75\r",
    )  # fmt: skip
    rows, reader = read(text)
    assert b"".join(row.piece.raw for row in rows) == b"Au3Au"
    assert all(row.at_s is not None and row.at_s >= 0.5 for row in rows)
    assert reader.faults == [3, 4, 5]
    for _ in range(5000):
        reader.feed("?")
    assert len(reader.faults) == MAX_FAULTS


# Without


def test_hex_text_is_read_without_times() -> None:
    query, reply = STATUS.query().encode(), bytes.fromhex("41 75 35 01 BE F4")
    rows, _ = read(["# from a logic analyser\n", f"{query.hex()}\n", f"{STATUS_FRAME.hex(' ')}, 0xFF\n"])
    assert [(row.at_s, row.direction, row.piece.raw, row.asked) for row in rows] == [
        (None, Direction.HOST_TO_MODULE, query, None),
        (None, Direction.MODULE_TO_HOST, STATUS_FRAME, STATUS.query()),
        (None, Direction.MODULE_TO_HOST, b"\xff", None),
    ]
    (only,), _ = read([reply[:3].hex(), reply[3:].hex()])
    assert only.piece.raw == reply, "a frame may go on in the next line"
    for other in (["hello"], ["41 75", "4"], ["41 7"], [random.Random(1).randbytes(5000).decode("latin-1")]):
        with pytest.raises(NotHex):
            read(other)


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
    assert [(round(entry.at_s, 3), entry.direction, entry.raw) for entry in entries] == [
        (0.0, Direction.HOST_TO_MODULE, query.encode()),
        (0.01, Direction.MODULE_TO_HOST, STATUS_FRAME + b"\x00\xff"),
        (0.02, Direction.MODULE_TO_HOST, STATUS_FRAME),
    ]


@pytest.mark.parametrize(("pause_s", "is_frame"), [(0.2, True), (0.3, False)])
@pytest.mark.parametrize("side", Direction)
def test_a_frame_in_pieces_is_one_unless_its_line_was_quiet_meanwhile(
    side: Direction, pause_s: float, is_frame: bool
) -> None:
    raw = STATUS_FRAME if side is Direction.MODULE_TO_HOST else STATUS.query().encode()
    rows = list(explained([CaptureEntry(10.0, side, raw[:3]), CaptureEntry(10.0 + pause_s, side, raw[3:])]))
    assert any(isinstance(row.piece, Frame) for row in rows) is is_frame


def test_what_was_asked_is_known_of_each_answer_and_no_echo_changes_it() -> None:
    asked, other = BY_NAME["cell_voltage"].query(), BY_NAME["trigger_records"].query()
    explainer = Explainer()
    explainer.feed(CaptureEntry(0.0, Direction.HOST_TO_MODULE, asked.encode()))
    explainer.feed(CaptureEntry(0.1, Direction.MODULE_TO_HOST, other.encode()))
    (row,) = explainer.feed(CaptureEntry(0.2, Direction.MODULE_TO_HOST, bytes.fromhex("41 75 35 01 BE F4")))
    assert row.asked == asked, "six bytes are enough where a voltage was asked for"
    explainer.feed(CaptureEntry(1.0, Direction.HOST_TO_MODULE, other.encode()))
    assert explainer.feed(CaptureEntry(1.1, Direction.MODULE_TO_HOST, bytes.fromhex("41 75 35 01 BE F4"))) == []


# Frames in words and values


def reply(code: int, raw: int) -> Frame:
    return Frame(Direction.MODULE_TO_HOST, encode_reply(code, raw))


def test_rejected_bytes_are_explained_by_their_reason() -> None:
    (noise,) = StreamParser().feed(bytes.fromhex("41 75 20 01 3C 50"))
    assert isinstance(noise, Noise)
    assert sentence(noise) == "no frame: wrong checksum"
    set_language(CHINESE)
    assert sentence(noise) == "不是有效帧：校验错误"


FREEFALL_TIME = BY_NAME["freefall_time"]


@pytest.mark.parametrize(
    ("asked", "code", "raw", "values", "words"),
    [
        (FREEFALL_TIME.set(1.6), 0x22, 0xA0, {"value_s": 1.6}, "acknowledged: free-fall time 1.60 s"),
        (FREEFALL_TIME.set(1.6), 0x22, 1, {"acknowledged": True}, "acknowledged: free-fall time"),
        (FREEFALL_TIME.set(1.6), 0x22, 0x50, {"acknowledged": False}, "not acknowledged: free-fall time (50)"),
        (FREEFALL_TIME.set(0.01), 0x22, 1, {"value_s": 0.01}, "acknowledged: free-fall time 0.01 s"),
        (BY_NAME["status"].query(), 0x22, 1, {"value_s": None}, "reply: free-fall time ?"),
        (BY_NAME["baud_rate"], 0x24, 1, {"acknowledged": True}, "acknowledged: baud rate"),
        (None, 0x24, 1, {"acknowledged": True}, "reply: baud rate ?"),
        (BY_NAME["freefall_trigger"], 0x16, 1, {"enabled": False}, "acknowledged: free-fall trigger disabled"),
        (None, 0x16, 1, {"enabled": False}, "reply: attitude trigger disabled / free-fall trigger disabled"),
        (
            BY_NAME["activation"].set(True),
            0x10,
            0,
            {"acknowledged": False, "active": False},
            "not acknowledged: activate / lock (00)",
        ),
    ],
)
def test_an_acknowledgement_says_no_more_than_it_knows(
    asked: Asked, code: int, raw: int, values: dict[str, object], words: str
) -> None:
    said = meaning(reply(code, raw), asked)
    assert {key: said[key] for key in said if key not in ("command", "may_answer")} == values
    assert sentence(reply(code, raw), asked) == words


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_every_request_and_every_reply_has_a_sentence(command: Command) -> None:
    requests = [command.query()] if command.query_data is not None else []
    if command.write is not None:
        requests += [Request(command, SET, raw) for raw in command.write.allowed]
    for request in requests:
        sent = Frame(Direction.HOST_TO_MODULE, request.encode())
        assert (bool(sentence(sent)), meaning(sent)["command"]) == (True, command.name)
    for raw in command.reply.allowed if command.reply is not None else ():
        for asked in (None, command, *requests[:2]):
            said = reply(command.code, raw)
            assert (bool(sentence(said, asked)), meaning(said, asked)["command"]) == (True, command.name)
