"""Captures: written and read back, read by the page's own description, damaged, endless, and played."""

import random
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.capture import (
    BYTES_A_LINE,
    Capture,
    CaptureRefused,
    CaptureWriter,
    Entry,
    Header,
    Way,
    entries_of,
    explained,
    parse_capture,
    read_capture,
)
from app.explain import sentence
from app.procedures.stream import StreamSwitch, watch
from app.replay import Player, Script, UrlRefused, parse_url, play, playing, script_of, stop_playing, url_of
from app.session import Run, Session
from app.transport import PortError, PortTrouble, open_line
from app.worker import Batch, PortState, Worker
from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason, encode_reply
from protocol.link_states import Presence
from protocol.messages import Status
from tests.batches import Batches
from tests.sim_line import FakeClock, Rig

DOCUMENT = Path(__file__).parent.parent / "docs" / "capture.md"
STATUS_FRAME = Status(7, 1.0, triggered=False, active=True).encode()
HEADER = Header(program="DPS-S 1.2", port="/dev/ttyUSB0", baud_rate=115200, started="2026-11-21T01:49:05Z")
ENTRIES = (
    Entry(0.0, Way.OUT, STATUS.query().encode()),
    Entry(0.002913, Way.IN, STATUS_FRAME),
    Entry(0.5, Way.IN, b"\x00\xff" + STATUS_FRAME[:3]),
    Entry(3600.25, Way.IN, STATUS_FRAME[3:]),
)


def written(
    path: Path, entries: tuple[Entry, ...] = ENTRIES, header: Header = HEADER, *, appends: bool = False
) -> None:
    writer = CaptureWriter(path, header, appends=appends)
    writer.write(entries)
    writer.close()


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
    entries = [Entry(at / 1000, way, raw) for at, way, raw in sorted(drawn, key=lambda one: one[0])]
    from app.capture import lines_of

    text = "\n".join([*HEADER.lines(), *(line for entry in entries for line in lines_of(entry))])
    assert parse_capture(text).entries == tuple(entries)


def test_a_long_entry_takes_several_lines(tmp_path: Path) -> None:
    raw = bytes(range(256)) * 40
    written(tmp_path / "a", (Entry(1.0, Way.IN, raw),))
    entries = read_capture(tmp_path / "a").entries
    assert len(entries) == 3
    assert b"".join(entry.raw for entry in entries) == raw


def test_appending_begins_a_part_that_follows_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "a"
    written(path, (Entry(1.0, Way.IN, b"\x01"), Entry(4.0, Way.IN, b"\x02")))
    written(path, (Entry(0.5, Way.OUT, b"\x03"),), Header(port="other"), appends=True)
    capture = read_capture(path)
    assert [entry.at_s for entry in capture.entries] == [1.0, 4.0, 4.5]
    assert capture.header == HEADER
    assert capture.faults == ()


def test_it_stops_at_its_limit_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a"
    writer = CaptureWriter(path, HEADER, limit_bytes=1000)
    writer.write(Entry(float(number), Way.IN, STATUS_FRAME) for number in range(1000))
    assert writer.is_full
    writer.write(ENTRIES)
    writer.close()
    writer.close()
    text = path.read_text()
    assert len(text) < 1100
    assert text.endswith("# the file is full: what came afterwards is not in it\n")
    capture = read_capture(path)
    assert len(capture.entries) == writer.entries
    assert capture.faults == ()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_an_error_and_no_surprise() -> None:
    with pytest.raises(OSError, match="space"):
        CaptureWriter(Path("/dev/full"), HEADER).write(ENTRIES)


def test_events_become_what_went_over_the_wire() -> None:
    noise = Noise(b"\x00\xff", Fault(Reason.NO_HEADER, "no frame header"))
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


def test_the_example_of_the_page_reads_as_the_page_says() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    example = re.findall(r"```\n(.*?)```", text, re.DOTALL)[0]
    capture = parse_capture(example)
    assert capture.header.port == "/dev/ttyUSB0"
    said = [sentence(one.piece, one.asked) for one in explained(capture)]
    assert said == [
        "query: status",
        "status: tilt 7°, 1.0 g, not triggered, active",
        "query: cell voltage",
        "reply: cell voltage 3.80 V",
    ]


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
    assert not capture.is_timed
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
    assert b"".join(one.piece.raw for one in explained(capture) if one.way is Way.OUT) == b"".join(
        entry.raw for entry in capture.entries if entry.way is Way.OUT
    )


def test_random_bytes_as_a_file_are_no_error_of_ours(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(random.Random(1).randbytes(5000))
    read_capture(tmp_path / "a")


def test_what_a_pause_cuts_is_explained_as_broken_off() -> None:
    capture = Capture(entries=(Entry(0.0, Way.IN, STATUS_FRAME[:4]), Entry(1.0, Way.IN, STATUS_FRAME)))
    pieces = [one.piece for one in explained(capture)]
    assert isinstance(pieces[0], Noise)
    assert pieces[-1].raw == STATUS_FRAME


# Playing


def recorded(options: dict[str, str], seconds: float = 6.0) -> Capture:
    """What `watch` sees of a simulated module."""
    rig = Rig(options)
    rig.session.run(Run(watch(StreamSwitch())))
    rig.step_for(seconds)
    return Capture(entries=tuple(entries_of(rig.session.take_events(), rig.session.opened_at)))


class PlayedLine:
    """A `Line` on a player and a fake clock."""

    baud_rate = 115200

    def __init__(self, player: Player, clock: FakeClock) -> None:
        self.player = player
        self.clock = clock

    def read(self, longest_s: float, gather_s: float) -> bytes:
        end_s = self.clock.now_s + longest_s
        due_s = self.player.next_due()
        self.clock.now_s = end_s if due_s is None else max(self.clock.now_s, min(due_s, end_s))
        return self.player.read(self.clock.now_s)

    def write(self, data: bytes) -> None:
        self.player.write(data, self.clock.now_s)

    def use_rate(self, baud_rate: int) -> None:
        pass

    def close(self) -> None:
        pass


def played(capture: Capture, seconds: float, *, speed: float = 1.0) -> Session:
    clock = FakeClock()
    session = Session(PlayedLine(Player(script_of(capture), clock.now_s, speed=speed), clock), clock)
    session.run(Run(watch(StreamSwitch())))
    end_s = clock.now_s + seconds
    while clock.now_s < end_s:
        session.step()
    return session


def test_what_is_played_shows_what_was_recorded() -> None:
    capture = recorded({"tilt": "33", "rate": "50", "boots": "12"})
    session = played(capture, 5.0)
    view = session.device.view(session.clock())
    now = session.clock()
    assert view.presence is Presence.ONLINE
    assert view.fresh("tilt_deg", now) == 33
    assert view.fresh("boot_count", now) == 12
    assert view.fresh("attitude_threshold_deg", now) == 60
    assert view.is_streaming
    assert len(session.device.take_samples()) > 100
    assert view.restarts == 0


def test_after_the_end_the_line_is_silent_and_all_is_stale() -> None:
    capture = recorded({"rate": "50"}, 4.0)
    session = played(capture, 25.0)
    view = session.device.view(session.clock())
    assert view.presence is Presence.OFFLINE
    assert all(known.is_stale for known in view.values.values())


def test_the_speed_is_kept() -> None:
    capture = recorded({"rate": "50"}, 6.0)
    usual, quick = (played(capture, seconds, speed=speed) for seconds, speed in ((5.0, 1.0), (0.5, 10.0)))
    rates = [len(one.device.take_samples()) for one in (usual, quick)]
    assert abs(rates[0] - rates[1]) < 0.15 * rates[0]


def test_what_was_never_asked_is_never_answered() -> None:
    script = script_of(Capture(entries=ENTRIES[:2]))
    player = Player(script, 0.0)
    player.write(BY_NAME["deploy"].set(True).encode() + BY_NAME["light"].query().encode(), 0.001)
    assert player.read(1.0) == b""
    again = Player(script, 0.0)
    again.write(STATUS.query().encode(), 0.001)
    assert again.read(1.0) == STATUS_FRAME


def test_the_answer_is_the_one_of_that_moment() -> None:
    light = BY_NAME["light"].query()
    entries = []
    for number in range(5):
        entries += [
            Entry(number * 2.0, Way.OUT, light.encode()),
            Entry(number * 2.0 + 0.01, Way.IN, encode_reply(0x14, number)),
        ]
    player = Player(script_of(Capture(entries=tuple(entries))), 0.0)
    player.write(light.encode(), 5.0)
    assert player.next_due() == pytest.approx(5.01)
    assert player.read(5.02) == encode_reply(0x14, 2)
    assert player.position_s(5.02) == 5.02
    assert not player.is_over(5.02)
    assert player.is_over(9.0)
    assert player.position_s(100.0) == player.duration_s


def test_a_question_that_was_not_answered_then_is_not_answered_now() -> None:
    light = BY_NAME["light"].query()
    entries = (
        Entry(0.0, Way.OUT, light.encode()),
        Entry(0.1, Way.IN, encode_reply(0x14, 3)),
        Entry(2.0, Way.OUT, light.encode()),
        Entry(20.0, Way.IN, STATUS_FRAME),
    )
    player = Player(script_of(Capture(entries=entries)), 0.0)
    player.write(light.encode(), 3.0)
    assert player.read(10.0) == b""


def test_a_heartbeat_is_answered_while_there_is_a_sign_of_the_module() -> None:
    entries = (Entry(0.0, Way.IN, STATUS_FRAME), Entry(60.0, Way.OUT, STATUS.query().encode()))
    heartbeat = HEARTBEAT.query().encode()
    player = Player(script_of(Capture(entries=entries)), 0.0)
    player.write(heartbeat, 5.0)
    assert player.read(5.0).startswith(STATUS_FRAME)
    player.write(heartbeat, 30.0)
    assert player.read(40.0) == b""


def test_all_records_come_back_together() -> None:
    rig = Rig({"history": "3"})
    from app.procedures.history import read_history

    history = rig.run(read_history())
    capture = Capture(entries=tuple(entries_of(rig.session.take_events(), rig.session.opened_at)))
    script = script_of(capture)
    assert isinstance(script, Script)
    assert [len(answer.data) for answer in script.answers[TRIGGER_RECORDS.query()]] == [48, 48]
    assert len(history.records) == 3


def test_urls() -> None:
    assert parse_url(url_of("/tmp/a b.dpscap", speed=2)) == ("/tmp/a b.dpscap", 2.0)
    assert parse_url("capture://C:/x.txt") == ("C:/x.txt", 1.0)
    for bad in ("capture://", "capture:///x?speed=fast", "capture:///x?speed=0", "capture:///x?loop=1", "sim://x"):
        with pytest.raises(UrlRefused):
            parse_url(bad)


def test_another_player_of_the_same_url_is_left_alone() -> None:
    one, two = (play("capture:///x", Capture(), speed=1.0) for _ in range(2))
    stop_playing("capture:///x", one)
    assert playing("capture:///x") is two
    stop_playing("capture:///x", two)
    assert playing("capture:///x") is None


# Through the whole worker


@pytest.fixture
def batches() -> Batches:
    return Batches()


@pytest.fixture
def worker(batches: Batches) -> Iterator[Worker]:
    made = Worker(batches)
    made.start()
    yield made
    assert made.stop(2.0)


def test_a_capture_is_a_port_of_the_worker(worker: Worker, batches: Batches, tmp_path: Path) -> None:
    path = tmp_path / "with space.dpscap"
    written(path, recorded({"tilt": "44", "rate": "100"}, 8.0).entries)
    url = url_of(str(path), speed=20)
    worker.open(url, 115200, lambda: watch(StreamSwitch()))
    seen = batches.until(lambda batch: batch.device.fresh("tilt_deg", batch.at) == 44)
    assert seen.connection.state is PortState.OPEN
    player = playing(url)
    assert player is not None
    batches.until(lambda batch: batch.device.is_streaming)
    batches.until(lambda _batch: player.is_over(time.monotonic()), limit_s=3)
    worker.close()

    def is_closed(batch: Batch) -> bool:
        return batch.connection.state is PortState.CLOSED and batch.at > seen.at

    batches.until(is_closed)
    assert playing(url) is None


@pytest.mark.parametrize(
    ("text", "trouble"), [(None, PortTrouble.MISSING), ("# DPS-S capture 9\n", PortTrouble.UNUSABLE)]
)
def test_a_file_that_cannot_be_played_is_a_port_that_cannot_be_opened(
    tmp_path: Path, text: str | None, trouble: PortTrouble
) -> None:
    path = tmp_path / "a"
    if text is not None:
        path.write_text(text)
    with pytest.raises(PortError) as refused:
        open_line(url_of(str(path)), 115200)
    assert refused.value.trouble is trouble


@pytest.mark.skipif(sys.platform == "win32", reason="another form of path")
def test_the_port_behaves_as_one(tmp_path: Path) -> None:
    path = tmp_path / "a"
    written(path)
    line = open_line(url_of(str(path)), 115200)
    line.write(STATUS.query().encode())
    end_s = time.monotonic() + 2
    came = b""
    while len(came) < len(STATUS_FRAME) and time.monotonic() < end_s:
        came += line.read(0.01, 0.0)
    assert came.startswith(STATUS_FRAME)
    line.use_rate(9600)
    line.close()
    line.close()
    with pytest.raises(PortError):
        line.read(0.01, 0.0)
