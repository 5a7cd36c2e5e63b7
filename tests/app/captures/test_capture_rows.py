"""Captures in little memory: entries and rows that are made when they are looked at, and work that rests."""

import sys
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.captures.entries import MAX_ENTRY_BYTES, CaptureEntry, Way
from app.captures.explained import Explained
from app.captures.rows import CaptureRows
from app.captures.traffic_buffer import MAX_BYTES, MAX_ENTRIES, PART_ENTRIES, TrafficBuffer
from app.system import gil_yield as pace
from protocol.catalogue import BY_NAME, STATUS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from protocol.messages import Status, decode
from tests.support.line.vectors import VECTORS
from tests.support.records.captures import explained

RAWS = st.binary(min_size=1, max_size=20) | st.sampled_from([vector.raw for vector in VECTORS])
ENTRIES = st.lists(st.tuples(st.integers(0, 10_000), st.sampled_from(Way), RAWS), max_size=30).map(
    lambda drawn: [CaptureEntry(at / 100, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
)
STREAMED = Status(7, 1.0, triggered=False, active=True).encode()


@given(ENTRIES)
def test_rows_are_what_was_explained(drawn: list[CaptureEntry]) -> None:
    rows = CaptureRows(explained(drawn))
    expected = list(explained(drawn))
    assert list(rows) == expected
    assert rows[:3] == tuple(expected[:3])
    assert b"".join(row.piece.raw for row in rows if row.way is Way.IN) == b"".join(
        entry.raw for entry in drawn if entry.way is Way.IN
    )
    rejected = rows.chosen(rows.rejected())
    assert list(rejected) == [row for row in expected if isinstance(row.piece, Noise)]
    assert [rows[place] for place in rows.rejected()] == list(rejected)
    others = rows.chosen(rows.without_status())
    assert list(others) == [row for row in expected if not _is_status(row)]
    assert others[-2:] == tuple(list(others)[-2:])


@pytest.mark.parametrize(("pause_s", "is_frame"), [(0.2, True), (0.3, False)])
@pytest.mark.parametrize("way", Way)
def test_a_frame_in_pieces_is_one_unless_its_line_was_quiet_meanwhile(way: Way, pause_s: float, is_frame: bool) -> None:
    raw = STREAMED if way is Way.IN else STATUS.query().encode()
    rows = list(explained([CaptureEntry(10.0, way, raw[:3]), CaptureEntry(10.0 + pause_s, way, raw[3:])]))
    assert any(isinstance(row.piece, Frame) for row in rows) is is_frame


def _is_status(row: Explained) -> bool:
    return isinstance(row.piece, Frame) and len(row.piece.raw) == 8


def test_what_was_asked_is_known_of_each_answer() -> None:
    asked = [BY_NAME["cell_voltage"].query(), BY_NAME["trigger_records"].query()]
    reply = bytes.fromhex("41 75 35 01 BE F4")
    rows = CaptureRows(
        explained(
            [
                CaptureEntry(0, Way.OUT, asked[0].encode()),
                CaptureEntry(0, Way.IN, reply),
                CaptureEntry(1, Way.OUT, asked[1].encode()),
            ]
        )
    )
    assert [row.asked for row in rows] == [None, asked[0], asked[0]]


def test_faults_that_differ_only_in_their_figures_stay_apart() -> None:
    wrong = [STREAMED[:-1] + bytes(((STREAMED[-1] + number) % 256,)) for number in (1, 2, 1)]
    rows = CaptureRows(explained([CaptureEntry(float(number), Way.IN, raw) for number, raw in enumerate(wrong)]))
    said = [row.piece.detail for row in rows if isinstance(row.piece, Noise)]
    assert len(said) == 3
    assert said[0] == said[2] != said[1]


def test_a_row_takes_few_bytes() -> None:
    rows = CaptureRows(explained(CaptureEntry(number / 1440, Way.IN, STREAMED) for number in range(20_000)))
    kept = (rows._at_s, rows._flags, rows._ends, rows._offsets, rows._notes, rows._raw)
    assert len(rows) == 20_000
    assert sum(map(sys.getsizeof, kept)) < 20_000 * 60


def test_work_in_the_main_thread_never_rests(monkeypatch: pytest.MonkeyPatch) -> None:
    rests: list[float] = []
    monkeypatch.setattr(time, "sleep", rests.append)
    monkeypatch.setattr(time, "perf_counter", iter(range(1000)).__next__)
    keeper = pace.GilYield()
    for _ in range(100):
        keeper.checkpoint()
    assert rests == []


def test_work_beside_it_rests_when_it_has_worked_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [0.0]
    rests: list[float] = []
    monkeypatch.setattr(time, "sleep", rests.append)
    monkeypatch.setattr(time, "perf_counter", lambda: now_s[0])

    def work() -> None:
        keeper = pace.GilYield()
        for _ in range(30):
            now_s[0] += pace.WORK_S / 10
            keeper.checkpoint()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert len(rests) in (2, 3)
    assert set(rests) == {pace.REST_S}


# The buffer of the line's traffic is bounded.


RAW = Status(7, 1.0, triggered=False, active=False).encode()
FRAME = Frame(Direction.MODULE_TO_HOST, RAW)
STATUS_READ = decode(RAW)


def status(at: int) -> Event:
    return Received(FRAME, STATUS_READ, Role.STREAMED, float(at))


def asked(at: int) -> Event:
    return Sent(STATUS.query().encode(), STATUS.query(), 1, float(at))


def noise(at: int) -> Event:
    return Rejected(Noise(bytes(MAX_ENTRY_BYTES), Fault(Reason.NO_HEADER, ""), 0), float(at))


def test_old_entries_are_dropped_and_times_begin_at_zero() -> None:
    buffer = TrafficBuffer()
    buffer.feed(status(at) for at in range(MAX_ENTRIES))
    assert not buffer.has_dropped
    assert len(buffer) == MAX_ENTRIES
    buffer.feed([status(MAX_ENTRIES)])
    assert buffer.has_dropped
    assert MAX_ENTRIES - PART_ENTRIES <= len(buffer) <= MAX_ENTRIES
    assert [entry.at_s for entry in buffer.entries(10)] == [float(at) for at in range(10)]
    everything = buffer.entries()
    assert len(everything) == len(buffer)
    assert [entry.at_s for entry in everything] == [float(at) for at in range(len(buffer))]


def test_every_entry_is_kept_as_it_was() -> None:
    buffer, wanted = TrafficBuffer(), list[CaptureEntry]()
    for at in range(3 * PART_ENTRIES + 7):
        buffer.feed([asked(at), status(at), status(at)] if at % 3 else [status(at)])
        wanted += [CaptureEntry(float(at), Way.OUT, STATUS.query().encode())] if at % 3 else []
        wanted.append(CaptureEntry(float(at), Way.IN, RAW * 2 if at % 3 else RAW))
    entries = buffer.entries()
    assert [entry._replace(at_s=round(entry.at_s, 6)) for entry in entries] == wanted
    assert [entry.raw for entry in buffer.entries(5000)] == [entry.raw for entry in wanted[-5000:]]
    assert [entry.raw for entry in buffer.entries(3)] == [entry.raw for entry in wanted[-3:]]


def test_with_the_longest_entries_its_memory_is_bounded() -> None:
    buffer = TrafficBuffer()
    buffer.feed(noise(at) for at in range(2 * MAX_BYTES // MAX_ENTRY_BYTES))
    assert buffer.has_dropped
    entries = buffer.entries()
    assert MAX_BYTES / 2 <= sum(len(entry.raw) for entry in entries) <= MAX_BYTES


def test_a_full_buffer_is_a_few_large_objects() -> None:
    buffer = TrafficBuffer()
    before = sys.getallocatedblocks()
    buffer.feed(status(at) for at in range(MAX_ENTRIES))
    assert sys.getallocatedblocks() - before < MAX_ENTRIES / 10
