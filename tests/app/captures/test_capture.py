"""Captures: written and read back, read by the page's own description, damaged and endless."""

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures.entries import CaptureEntry, Way
from app.captures.reader import CaptureRefused
from app.captures.writer import BYTES_A_LINE, Header, entries_of
from protocol.catalogue import STATUS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from tests.support.line.sim_line import Rig
from tests.support.records.captures import (
    ENTRIES,
    HEADER,
    STATUS_FRAME,
    Capture,
    explained,
    parse_capture,
    read_capture,
    written,
)


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "a.dpscap"
    written(path)
    assert read_capture(path) == Capture(header=HEADER, entries=ENTRIES)


@given(
    st.lists(
        st.tuples(st.integers(0, 10**7), st.sampled_from(Way), st.binary(min_size=1, max_size=BYTES_A_LINE)),
        max_size=20,
    )
)
def test_any_entries_survive(drawn: list[tuple[int, Way, bytes]]) -> None:
    entries = [CaptureEntry(at / 1000, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
    from app.captures.writer import lines_of

    text = "\n".join([*HEADER.lines(), *(line for entry in entries for line in lines_of(entry))])
    assert parse_capture(text).entries == tuple(entries)


def test_a_long_entry_takes_several_lines(tmp_path: Path) -> None:
    raw = bytes(range(256)) * 40
    written(tmp_path / "a", (CaptureEntry(1.0, Way.IN, raw),))
    entries = read_capture(tmp_path / "a").entries
    assert len(entries) == 3
    assert b"".join(entry.raw for entry in entries) == raw


def test_a_file_behind_another_is_a_part_that_follows(tmp_path: Path) -> None:
    path, second = tmp_path / "a", tmp_path / "b"
    written(path, (CaptureEntry(1.0, Way.IN, b"\x01"), CaptureEntry(4.0, Way.IN, b"\x02")))
    written(second, (CaptureEntry(0.5, Way.OUT, b"\x03"),), Header(port="other"))
    path.write_bytes(path.read_bytes() + second.read_bytes())
    capture = read_capture(path)
    assert [entry.at_s for entry in capture.entries] == [1.0, 4.0, 4.5]
    assert capture.header == HEADER
    assert capture.faults == ()


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
    from app.procedures.read import read_everything

    rig.run(read_everything())
    rig.step_for(1.0)
    entries = list(entries_of(rig.session.take_events(), started_at=rig.session.opened_at))
    assert b"".join(entry.raw for entry in entries if entry.way is Way.IN) == bytes(rig.line.arrived)
    assert b"".join(entry.raw for entry in entries if entry.way is Way.OUT) == bytes(rig.line.sent)


# Reading what others wrote


def test_lines_that_cannot_be_read_are_left_out_and_named() -> None:
    text = "\n".join(
        [
            "# DPS-S capture 1",
            "1.0 < 41 75",
            "what is this",
            "1.5 < 4",
            "1.6 < zz",
            "0.5 < 33",
            "2.0 > ",
            "",
            "# a remark: with a colon",
            "# baud_rate: 9600",
            f"3.0 < {'00' * 40_000}",
            "3.5 < 0x41,0x75\r",
        ]
    )
    capture = parse_capture(text)
    assert [fault.line for fault in capture.faults] == [3, 4, 5, 6, 11]
    assert [(entry.at_s, entry.raw) for entry in capture.entries] == [(1.0, b"Au"), (1.0, b"3"), (3.5, b"Au")]
    assert capture.header.baud_rate is None  # a header ends at the first entry


def test_the_number_of_faults_is_bounded() -> None:
    assert len(parse_capture("# DPS-S capture 1\n" + "?\n" * 5000).faults) == 100


def test_a_later_version_is_refused_and_so_is_a_file_without_end(tmp_path: Path) -> None:
    with pytest.raises(CaptureRefused, match="later version"):
        parse_capture("# DPS-S capture 2\n0.0 < 41")
    path = tmp_path / "huge"
    with path.open("wb") as file:
        file.truncate(200 * 1024 * 1024)
    with pytest.raises(CaptureRefused, match="too long"):
        read_capture(path)


def test_plain_hex_text_is_read_without_times() -> None:
    text = f"# from a logic analyser\n{STATUS.query().encode().hex()}\n{STATUS_FRAME.hex(' ')}, 0xFF\nzz\n"
    capture = parse_capture(text)
    assert capture.is_plain
    assert [(entry.way, entry.raw) for entry in capture.entries] == [
        (Way.OUT, STATUS.query().encode()),
        (Way.IN, STATUS_FRAME),
        (Way.IN, b"\xff"),
    ]
    assert [fault.line for fault in capture.faults] == [4]
    assert 0 < capture.duration_s < 0.01


@given(st.text(alphabet="0123456789.<>#AuBa \n:DPS-capture1", max_size=300))
def test_any_text_is_read_without_an_error_of_ours(text: str) -> None:
    try:
        capture = parse_capture(text)
    except CaptureRefused:
        return
    assert b"".join(one.piece.raw for one in explained(capture.entries) if one.way is Way.OUT) == b"".join(
        entry.raw for entry in capture.entries if entry.way is Way.OUT
    )


def test_random_bytes_as_a_file_are_no_error_of_ours(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(random.Random(1).randbytes(5000))
    read_capture(tmp_path / "a")


def test_what_a_pause_cuts_is_explained_as_broken_off() -> None:
    capture = Capture(entries=(CaptureEntry(0.0, Way.IN, STATUS_FRAME[:4]), CaptureEntry(1.0, Way.IN, STATUS_FRAME)))
    pieces = [one.piece for one in explained(capture.entries)]
    assert isinstance(pieces[0], Noise)
    assert pieces[-1].raw == STATUS_FRAME
