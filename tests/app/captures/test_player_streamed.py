"""A capture is read while it is played: a little ahead, without a thread, and nothing of it changes what is heard."""

import threading
from collections.abc import Iterator, Sequence
from itertools import count, islice
from pathlib import Path

import pytest

from app.captures.entries import CaptureEntry, Way
from app.captures.player import AHEAD_S, KNOWN_AHEAD_S, MIN_AHEAD_S, READ_EARLIER_S, Player, playing, url_of
from app.captures.script import Script
from app.captures.writer import entries_of
from app.engine.worker import PortState, Worker
from app.port_urls import protocol_capture
from app.port_urls.protocol_capture import Serial
from app.procedures.history import read_history
from app.procedures.stream import StreamSwitch, watch
from protocol.catalogue import BY_NAME, HEARTBEAT
from protocol.frame import encode_reply
from tests.app.captures.test_player import recorded
from tests.support.line.batches import Batches
from tests.support.line.sim_line import Rig
from tests.support.records.captures import EMPTY_SLOT, STATUS_FRAME, Capture, script_of, written

HEARTBEAT_REPLY = bytes.fromhex("41 75 01 A5 5A 00")
LIGHT = BY_NAME["light"].query()


class Source:
    """Entries in steps; how many have been taken."""

    def __init__(self, entries: Iterator[CaptureEntry], *, at_once: int = 10) -> None:
        self.entries, self.at_once, self.taken = entries, at_once, 0

    def __iter__(self) -> Iterator[Sequence[CaptureEntry]]:
        while some := tuple(islice(self.entries, self.at_once)):
            self.taken += len(some)
            yield some


def stream(rate_hz: float = 10.0, *, seconds: float | None = None) -> Iterator[CaptureEntry]:
    """A status every so often; without end, where none is given."""
    numbers = count() if seconds is None else range(round(seconds * rate_hz))
    return (CaptureEntry(number / rate_hz, Way.IN, STATUS_FRAME) for number in numbers)


def streamed(
    entries: Iterator[CaptureEntry], *, at_once: int = 10, expected_s: float = 1000.0
) -> tuple[Script, Source]:
    source = Source(entries, at_once=at_once)
    return Script(iter(source), lambda: expected_s), source


def read_all_it_wants(player: Player, now_s: float) -> None:
    while player.read_ahead(now_s):
        pass


def asked(entries: Sequence[tuple[float, int]], *, until_s: float) -> list[CaptureEntry]:
    """A stream, in which the light was asked for at these times and answered with these values."""
    made = list(stream(seconds=until_s))
    for at_s, value in entries:
        made += [
            CaptureEntry(at_s, Way.OUT, LIGHT.encode()),
            CaptureEntry(at_s + 0.01, Way.IN, encode_reply(0x14, value)),
        ]
    return sorted(made, key=lambda one: one.at_s)


def test_no_more_is_read_than_is_needed_soon() -> None:
    script, source = streamed(stream())
    player = Player(script, 0.0)
    read_all_it_wants(player, 0.0)
    ahead_s = KNOWN_AHEAD_S + READ_EARLIER_S
    assert source.taken <= ahead_s * 10 + 20
    for tick in range(1000):
        read_all_it_wants(player, tick / 10)
        player.read(tick / 10)
    assert source.taken <= (100 + ahead_s) * 10 + 20
    assert len(script.unasked) <= ahead_s * 10 + 20  # what is over is forgotten
    assert len(script.alive_at_s) <= (12 + ahead_s) * 10 + 20


def test_what_is_heard_does_not_depend_on_how_it_is_read() -> None:
    entries = recorded({"rate": "20", "history": "2", "corrupt": "0.01", "seed": "5"}, 30.0).entries
    read_whole = Player(script_of(Capture(entries=entries)), 0.0)
    script, _source = streamed(iter(entries), at_once=3)
    read_ahead = Player(script, 0.0)
    questions = [BY_NAME[name].query() for name in ("light", "trigger_records", "heartbeat", "boot_count", "status")]
    heard: tuple[list[bytes], list[bytes]] = [], []
    for tick in range(400):
        for player, bytes_heard in zip((read_whole, read_ahead), heard, strict=True):
            read_all_it_wants(player, tick / 10)
            if tick % 7 == 0:
                player.write(questions[tick // 7 % len(questions)].encode(), tick / 10)
            bytes_heard.append(player.read(tick / 10))
    assert heard[0] == heard[1]
    assert any(heard[0])
    assert read_ahead.is_over(40.0)
    assert read_ahead.duration_s == read_whole.duration_s


def test_the_captures_time_waits_for_the_reading() -> None:
    """However slow that is, nothing is played early, late or twice."""
    script, source = streamed(stream(), at_once=1)
    player = Player(script, 0.0)
    heard = 0
    for tick in range(3000):
        player.read_ahead(tick)  # a tenth of a second of it in every second
        heard += len(player.read(tick)) // len(STATUS_FRAME)
        assert heard <= max(1, source.taken - MIN_AHEAD_S * 10 + 1)
    assert player.position_s(2999) == pytest.approx(300 - MIN_AHEAD_S, abs=0.5)
    assert heard == pytest.approx(10 * (300 - MIN_AHEAD_S), abs=10)


def test_a_clock_that_leaps_makes_it_forget_nothing_that_is_still_to_come() -> None:
    """The computer slept, or the thread was held up."""
    script, _source = streamed(iter(asked([(5.0, 3), (30.0, 4)], until_s=1000.0)))
    player = Player(script, 0.0)
    read_all_it_wants(player, 0.0)
    known_s = script.read_s
    player.read_ahead(500.0)
    assert player.position_s(500.0) <= known_s
    player.write(HEARTBEAT.query().encode(), 500.0)
    assert player.read(500.0).endswith(HEARTBEAT_REPLY)


def test_it_begins_when_a_little_is_known_and_answers_when_enough_is() -> None:
    script, source = streamed(iter(asked([(5.0, 3)], until_s=100.0)))
    player = Player(script, 0.0)
    for _ in range(2):  # asked again meanwhile: one answer all the same
        player.write(LIGHT.encode(), 0.0)
    assert player.read(0.0) == b""
    while source.taken < 20:
        player.read_ahead(0.5)
    assert player.read(0.5) == STATUS_FRAME  # it begins now
    player.write(HEARTBEAT.query().encode(), 0.5)
    assert player.read(0.5) == HEARTBEAT_REPLY
    while source.taken < 60:
        player.read_ahead(0.6)
    heard = player.read(0.6) + player.read(0.65)
    assert heard.count(encode_reply(0x14, 3)) == 1
    assert encode_reply(0x14, 3) not in player.read(3.0)


@pytest.mark.parametrize("name", ["light", "trigger_records", "boot_count"])
def test_what_is_never_answered_is_not_waited_for_either(name: str) -> None:
    script, _source = streamed(stream())
    player = Player(script, 0.0)
    player.write(BY_NAME[name].query().encode(), 0.0)
    assert player._waiting
    read_all_it_wants(player, 0.0)
    assert player.read(0.0) == STATUS_FRAME
    assert not player._waiting


def test_records_are_waited_for_until_all_of_them_are_known() -> None:
    rig = Rig({"history": "3"})
    history = rig.run(read_history())
    one_query = b"".join(record.raw for record in history.records) + EMPTY_SLOT * 6
    entries = tuple(entries_of(rig.session.take_events(), rig.session.opened_at))
    whole = Player(script_of(Capture(entries=entries)), 0.0)
    part = Player(streamed(iter(entries), at_once=1)[0], 0.0)
    raw = BY_NAME["trigger_records"].query().encode()
    heard = [b"", b""]
    for place, player in enumerate((whole, part)):
        player.write(raw, 0.0)
        for tick in range(300):
            player.read_ahead(tick / 20)
            player.read_ahead(tick / 20)
            heard[place] += player.read(tick / 20)
    assert len(history.records) == 3
    assert heard == [one_query] * 2


def test_only_what_is_answered_soon_is_answered_before_its_time() -> None:
    entries = tuple(asked([(AHEAD_S + 5.0, 3), (AHEAD_S + 30.0, 4)], until_s=100.0))
    for script in (script_of(Capture(entries=entries)), streamed(iter(entries))[0]):
        player = Player(script, 0.0)
        heard = b""
        for tick in range(120):
            read_all_it_wants(player, tick / 2)
            if tick in (0, 30, 100):
                heard = b""
                player.write(LIGHT.encode(), tick / 2)
            heard += player.read(tick / 2)
            if tick in (5, 35, 105):
                told = [value for value in (3, 4) if encode_reply(0x14, value) in heard]
                assert told == {5: [], 35: [3], 105: [4]}[tick]


def test_how_long_it_lasts_is_told_from_the_start_and_exact_in_the_end() -> None:
    script, _source = streamed(stream(seconds=50.0), expected_s=60.0)
    player = Player(script, 0.0)
    read_all_it_wants(player, 0.0)
    assert player.duration_s == 60.0
    assert not player.is_over(0.0)
    for now_s in range(21):
        read_all_it_wants(player, now_s)
    assert player.duration_s == 49.9
    assert player.is_over(50.0)


def test_a_frame_of_the_module_that_went_the_other_way_is_no_question() -> None:
    script = script_of(
        Capture(entries=(CaptureEntry(0.0, Way.OUT, STATUS_FRAME), CaptureEntry(1.0, Way.IN, STATUS_FRAME)))
    )
    assert script.answers == {}
    assert [raw for _at, raw in script.unasked] == [STATUS_FRAME]


# As a port


def long_capture(folder: Path) -> str:
    """The URL of one that takes long to read."""
    path = folder / "long.dpscap"
    written(path, list(stream(100.0, seconds=600.0)))
    return url_of(path.as_posix())


def test_opening_reads_little_and_closing_lets_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocol_capture, "READING_TO_OPEN_S", 0.0)
    url = long_capture(tmp_path)
    port = Serial(url, timeout=0.01)
    player, file = playing(url), port._file
    assert player is not None
    assert file is not None
    assert file.tell() == 0
    port.write(HEARTBEAT.query().encode())
    while not port.read(1):
        pass
    assert file.tell() < (tmp_path / "long.dpscap").stat().st_size / 4
    assert player.duration_s == pytest.approx(599.99)
    port.close()
    assert file.closed
    assert playing(url) is None


def test_a_read_that_waits_can_be_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path / "a", [CaptureEntry(3600.0, Way.IN, STATUS_FRAME)])
    port = Serial(url_of((tmp_path / "a").as_posix()), timeout=3000.0)
    waits = list[float]()

    class Cancelled(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            waits.append(timeout or 0.0)
            port.cancel_read()  # as another thread does
            return super().wait(timeout)

    monkeypatch.setattr(port, "_cancelled", Cancelled())
    assert port.read(1) == b""
    assert len(waits) == 1
    assert waits[0] > 1000
    port.close()


def test_the_worker_ends_while_a_capture_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocol_capture, "READING_TO_OPEN_S", 0.0)
    monkeypatch.setattr(Player, "read_ahead", lambda _player, _now_s: True)  # there is always more to be read
    batches = Batches()
    worker = Worker(batches)
    worker.start()
    url = long_capture(tmp_path)
    worker.open(url, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.connection.state is PortState.OPEN)
    assert worker.stop(2.0)
    assert playing(url) is None
