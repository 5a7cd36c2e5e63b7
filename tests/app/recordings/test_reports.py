"""The reports that numpy finds in the bytes of the line are those of the stream parser, however these were split."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.captures.line import LinePart
from app.recordings.reports import ReportFinder
from protocol.frame import Frame
from protocol.messages import Status, decode
from protocol.stream import StreamParser

OVERLAPPING = b"A" + 5 * bytes.fromhex("75 32 0F 00 00 00 41")
"""Each report's last byte is the first of the next."""
RECORD = bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E")
statuses = st.builds(
    lambda tilt, tenths, triggered, active: Status(tilt, tenths / 10, triggered=triggered, active=active).encode(),
    st.sampled_from((0, 0x41, 0x75, 0x32, 90)), st.integers(0, 255), st.booleans(), st.booleans(),
)  # fmt: skip
pieces = st.lists(
    st.one_of(
        statuses,
        statuses,
        st.just(RECORD),
        st.just(OVERLAPPING),
        st.just(b"Au2"),
        st.just(b"Au\x14\x01\x03\x18"),
        st.binary(max_size=4),
    ),
    max_size=30,
)


def parsed(data: bytes) -> list[Status]:
    parser = StreamParser()
    frames = [piece.raw for piece in (*parser.feed(data), *parser.flush()) if isinstance(piece, Frame)]
    return [message for raw in frames if isinstance(message := decode(raw), Status)]


@given(pieces, st.lists(st.integers(0, 300), max_size=6))
def test_the_same_reports_as_the_stream_parser(parts: list[bytes], cuts: list[int]) -> None:
    data = b"".join(parts)
    places = sorted({0, len(data), *(min(cut, len(data)) for cut in cuts)})
    finder, found = ReportFinder(), []
    for first, end in pairwise(places):
        part = LinePart(np.array([first]), np.array([end - first]), data[first:end])
        columns = finder.feed(part)
        values = zip(columns.tilt_deg, columns.acceleration_g, columns.flags, columns.times_ns, strict=True)
        found += [(int(tilt), round(float(force), 1), int(flags), int(at)) for tilt, force, flags, at in values]
    expected = parsed(data)
    if len(places) > 2:  # a record across two pieces is not known as such: only what is more may differ
        assert len(found) >= len(expected)
        return
    assert [row[:3] for row in found] == [
        (one.tilt_deg, one.acceleration_g, one.active + 2 * one.triggered) for one in expected
    ]


def test_reports_that_overlap_without_end_do_not_hold_it_up() -> None:
    data = OVERLAPPING[:1] + 400_000 * OVERLAPPING[1:8]
    assert len(ReportFinder().feed(LinePart.of([(0, data)])).flags) == 200_000


@given(st.lists(statuses, min_size=1, max_size=20), st.lists(st.integers(0, 160), max_size=6))
def test_a_report_has_the_time_of_its_last_byte(parts: list[bytes], cuts: list[int]) -> None:
    data = b"".join(parts)
    places = sorted({0, len(data), *(min(cut, len(data)) for cut in cuts)})
    spans = list(pairwise(places))
    for is_joined in (True, False):
        messages = [(end * 10, data[first:end]) for first, end in spans]
        finder = ReportFinder()
        if is_joined:
            times = finder.feed(LinePart.of(messages)).times_ns.tolist()
        else:
            times = [at for message in messages for at in finder.feed(LinePart.of([message])).times_ns.tolist()]
        ends = [min(end for _, end in spans if end >= 8 * (number + 1)) * 10 for number in range(len(parts))]
        assert times == ends


def test_a_long_silence_begins_another_message() -> None:
    messages = list(LinePart.of([(0, b"a"), (4_000_000_000, b"b"), (5_000_000_000, b"c")]).messages())
    assert [at for at, _ in messages] == [0, 5_000_000_000]
    part = LinePart.read(messages)
    assert (part.times_ns.tolist(), part.raw) == ([0, 4_000_000_000, 5_000_000_000], b"abc")
    spoilt = [(at, data + b"x") for at, data in messages[:1]] + messages[1:] + [(9, b""), (9, b"\xff" * 20)]
    assert LinePart.read(spoilt).raw == b"c"
