"""A capture played: through the session on a fake clock, and as a port of the worker."""

import sys
import time
from pathlib import Path

import pytest

from app.captures.entries import CaptureEntry, Way
from app.captures.player import Player, UrlRefused, parse_url, play, playing, stop_playing, url_of
from app.captures.script import Script
from app.captures.writer import entries_of
from app.engine.session import Run, Session
from app.engine.transport import PortError, PortTrouble, open_line
from app.engine.worker import Batch, PortState, Worker
from app.procedures.stream import StreamSwitch, watch
from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.frame import encode_reply
from protocol.link_states import Presence
from tests.support.line.batches import Batches
from tests.support.line.sim_line import FakeClock, Rig
from tests.support.records.captures import EMPTY_SLOT, ENTRIES, STATUS_FRAME, Capture, script_of, written

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
            CaptureEntry(number * 2.0, Way.OUT, light.encode()),
            CaptureEntry(number * 2.0 + 0.01, Way.IN, encode_reply(0x14, number)),
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
        CaptureEntry(0.0, Way.OUT, light.encode()),
        CaptureEntry(0.1, Way.IN, encode_reply(0x14, 3)),
        CaptureEntry(2.0, Way.OUT, light.encode()),
        CaptureEntry(20.0, Way.IN, STATUS_FRAME),
    )
    player = Player(script_of(Capture(entries=entries)), 0.0)
    player.write(light.encode(), 3.0)
    assert player.read(10.0) == b""


def test_a_heartbeat_is_answered_while_there_is_a_sign_of_the_module() -> None:
    entries = (CaptureEntry(0.0, Way.IN, STATUS_FRAME), CaptureEntry(60.0, Way.OUT, STATUS.query().encode()))
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
    assert len(history.records) == 3
    one_query = b"".join(record.raw for record in history.records) + EMPTY_SLOT * 6
    assert [answer.data for answer in script.answers[TRIGGER_RECORDS.query()]] == [one_query] * 2


def test_urls() -> None:
    assert parse_url(url_of("/tmp/a b.dpscap", speed=2)) == ("/tmp/a b.dpscap", 2.0)
    assert parse_url("capture://C:/x.txt") == ("C:/x.txt", 1.0)
    for bad in ("capture://", "capture:///x?speed=fast", "capture:///x?speed=0", "capture:///x?loop=1", "sim://x"):
        with pytest.raises(UrlRefused):
            parse_url(bad)


def test_another_player_of_the_same_url_is_left_alone() -> None:
    one, two = (play("capture:///x", script_of(Capture()), speed=1.0) for _ in range(2))
    stop_playing("capture:///x", one)
    assert playing("capture:///x") is two
    stop_playing("capture:///x", two)
    assert playing("capture:///x") is None


# Through the whole worker

pytest_plugins = ["tests.support.port_fixtures"]


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
        path.write_text(text, encoding="utf-8")
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
