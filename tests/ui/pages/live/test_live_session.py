"""The automatic recording of sessions: start, end, content and indicator."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from app.engine.identity import Identity, Trust
from PySide6.QtCore import QEvent
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.engine.worker import Batch, Connection
from app.procedures.stream import StreamSwitch
from app.recordings.markers import MarkerKind
from app.recordings.recording import open_recording
from protocol.events import FellSilent
from tests.support.records.recordings_made import CLOSED, LOST, OPEN, WAIT_S, batch, device, opened, recorder_in, report
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.steps import find, given, notice_text
from ui.core.bridge import Bridge
from ui.main import PAGES
from ui.pages.live.panel import device_at
from ui.services.recording_jobs import RecordingJobs
from ui.services.storage import SessionRecording
from ui.shell.status_bar import RecordingSign
from ui.style.icons import Icon
from ui.widgets.labels import IconLabel

OTHER = OPEN._replace(port="/dev/ttyACM0", opening=7)
NEXT = OPEN._replace(opening=7)
ELSEWHERE = OPEN._replace(port="/dev/ttyUSB1")


# From the worker to the disk, without a window


class Link:
    """What the recording asks of the connector."""

    connection = OPEN
    stream = StreamSwitch(is_wanted=False)


class Bench:
    """A session recording whose worker is the test."""

    def __init__(self, folder: Path) -> None:
        self.handed_on: list[Batch] = []
        self.link = Link()
        self.library = (jobs := RecordingJobs(folder)).library
        self.sessions = SessionRecording(self.link, jobs)  # type: ignore[arg-type]
        self.sessions.name_module("Left wing")
        self.say = self.sessions.recorded(self.handed_on.append)

    def show_next(self, connection: Connection) -> None:
        """As a person chooses it; the former one is still recorded."""
        self.link.connection = connection
        self.sessions.name_module("")

    def listed(self) -> list[tuple[str, str, int]]:
        """Port, module and number of reports of all recordings, oldest first."""
        assert self.sessions._recorder is None or self.sessions._recorder.settle(WAIT_S)
        return [(entry.port, entry.module, entry.sample_count) for entry in reversed(self.library.entries())]


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    one = Bench(tmp_path / "recordings")
    yield one
    assert one.sessions.stop(WAIT_S)


def some(first_s: float, *, connection: Connection = OPEN, is_in_doubt: bool = False) -> Batch:
    """Three reports, by the clock of the recorder: a part that began a day ago ends."""
    first_s += time.monotonic()
    reports = batch(first_s + 0.3, *(report(first_s + n / 10, n) for n in range(3)), connection=connection)
    return reports._replace(identity=Identity(Trust.OPEN)) if is_in_doubt else reports


def test_everything_is_handed_on_and_recorded(bench: Bench) -> None:
    batches = [some(1.0), some(2.0), some(3.0, connection=CLOSED)]
    for one in batches:
        bench.say(one)
    assert bench.handed_on == batches
    assert bench.listed() == [("/dev/ttyUSB0", "Left wing", 9)]
    assert not bench.library.entries()[0].is_running


@pytest.mark.parametrize(
    ("connections", "counts"),
    [
        ((OPEN, OPEN), [6]),
        ((OPEN, CLOSED, OPEN), [6, 3]),  # closed by hand
        ((OPEN, LOST, OPEN), [6, 3]),  # lost, and back: another module may be there
        ((OPEN, LOST, LOST, ELSEWHERE), [6, 3]),
        ((OPEN, OPEN._replace(baud_rate=9600)), [6]),
        ((OPEN, NEXT), [3, 3]),  # a person says that another module answers
        ((OPEN, CLOSED, LOST, OPEN), [6, 3]),  # it could not be opened
    ],
)
def test_where_sessions_begin(bench: Bench, connections: tuple[Connection, ...], counts: list[int]) -> None:
    for number, connection in enumerate(connections):
        bench.say(some(1.0 + number, connection=connection))
    assert [count for _, _, count in bench.listed()] == counts


def test_the_file_is_that_of_this_conversation(bench: Bench) -> None:
    bench.say(some(1.0))
    bench.listed()
    bench.say(some(2.0))
    first, recorder = bench.sessions.path, bench.sessions._recorder
    assert first is not None
    assert recorder is not None
    begin, may_begin = recorder._begin, threading.Event()

    def held(*asked: Any) -> None:
        may_begin.wait(WAIT_S)
        begin(*asked)

    recorder._begin = held  # type: ignore[method-assign, assignment]
    for number in range(2):  # the disk is slow: the next file is not begun yet
        bench.say(some(3.0 + number, connection=NEXT))
        assert bench.sessions.path is None
    may_begin.set()
    bench.listed()
    bench.say(some(5.0, connection=NEXT))
    assert bench.sessions.path not in (None, first)
    second = bench.sessions.path
    bench.say(some(6.0, connection=CLOSED))
    bench.listed()
    assert bench.sessions.path == second  # it is shown until another one is connected


def test_what_may_be_another_module_is_recorded_under_no_name(bench: Bench) -> None:
    bench.say(some(1.0))
    bench.say(some(2.0, is_in_doubt=True))
    bench.sessions.name_module("Left wing")  # before the window knew of the doubt
    bench.say(some(3.0, is_in_doubt=True))
    assert bench.listed() == [("/dev/ttyUSB0", "Left wing", 3), ("/dev/ttyUSB0", "", 6)]
    assert bench.handed_on[-1].identity.trust is Trust.OPEN


def test_the_recording_says_from_where_on_it_may_be_of_another_module(bench: Bench) -> None:
    """A silence too short to be noticed: only the boot count tells, which was read last before it."""
    read_at = time.monotonic() + 1.5
    bench.say(some(1.0)._replace(device=device(read_at, boot_count=7)))
    bench.say(some(2.0)._replace(device=device(read_at, boot_count=7)))
    bench.say(some(3.0, is_in_doubt=True)._replace(device=device(read_at + 2.0, boot_count=9)))
    bench.listed()
    named, in_doubt = (open_recording(entry) for entry in reversed(bench.library.entries()))
    (since_s,) = (marker.time_s for marker in named.markers if marker.kind is MarkerKind.DOUBTED)
    assert since_s == pytest.approx(read_at, abs=0.001)
    assert MarkerKind.DOUBTED not in [marker.kind for marker in in_doubt.markers]
    assert (len(named.tilt), len(in_doubt.tilt)) == (6, 3)


def test_what_was_recorded_in_doubt_is_of_the_module_that_a_person_names(bench: Bench) -> None:
    bench.say(some(1.0))
    bench.sessions.name_module("")
    bench.say(some(2.0, is_in_doubt=True))
    bench.say(some(3.0))
    bench.sessions.name_module("Left wing")
    assert bench.listed() == [("/dev/ttyUSB0", "Left wing", 3), ("/dev/ttyUSB0", "Left wing", 6)]
    bench.say(some(4.0, is_in_doubt=True))
    bench.show_next(NEXT)
    bench.say(some(5.0, connection=NEXT))
    bench.sessions.name_module("Right wing")
    assert bench.listed()[2:] == [("/dev/ttyUSB0", "Right wing", 6)]


def broken(at_s: float) -> Batch:
    """Nothing, as the module fell silent."""
    at_s += time.monotonic()
    return batch(at_s)._replace(events=(FellSilent(at_s, 0.3),))


@pytest.mark.parametrize("is_in_doubt", [True, False])
@pytest.mark.parametrize("silent_at_s", [3.0, 1.6])
def test_a_name_is_of_what_one_unbroken_conversation_recorded(
    bench: Bench, is_in_doubt: bool, silent_at_s: float
) -> None:
    """In doubt, and without a name, a third module may come unasked, also after one that was heard for a moment."""
    bench.sessions.name_module("")
    bench.say(some(1.0, is_in_doubt=is_in_doubt))
    silence = broken(silent_at_s)
    bench.say(silence._replace(identity=Identity(Trust.OPEN)) if is_in_doubt else silence)
    bench.say(some(4.0, is_in_doubt=is_in_doubt))
    bench.say(some(5.0))
    bench.sessions.name_module("Left wing")
    bench.say(some(6.0))
    parts = [("Left wing", 9)] if is_in_doubt else [("Left wing", 3)]
    assert [(module, count) for _, module, count in bench.listed()][1:] == parts
    assert bench.listed()[0] == ("/dev/ttyUSB0", "", 3 if is_in_doubt else 9)


def test_a_new_name_belongs_to_its_session(bench: Bench) -> None:
    bench.say(some(1.0))
    bench.sessions.name_module("Right wing")
    bench.show_next(OTHER)
    bench.sessions.name_module("Tail")  # while the first still closes
    bench.say(some(2.0, connection=CLOSED))
    bench.say(some(3.0, connection=OTHER))
    assert [module for _, module, _ in bench.listed()] == ["Right wing", "Tail"]


def test_a_failing_recorder_does_not_affect_the_link(bench: Bench, tmp_path: Path, qtbot: QtBot) -> None:
    (tmp_path / "recordings").write_text("a file stands where the folder should be", encoding="utf-8")
    sign = RecordingSign(lambda: bench.sessions.sign)
    qtbot.addWidget(sign)
    told = QSignalSpy(sign.troubled)
    bench.say(some(1.0))
    recorder = given(bench.sessions._recorder)
    recorder.settle(WAIT_S)
    bench.say(some(2.0))
    sign.refresh()
    sign.refresh()
    assert len(bench.handed_on) == 2
    assert told.count() == 1
    assert "Not recording" in told.at(0)[0].translated()
    assert sign.label.text() == "Not recorded"
    assert _is_a_warning(sign)


def test_an_error_in_the_recorder_does_not_reach_the_worker(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(_batch: Batch) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(bench.sessions, "_on_batch", fail)
    bench.say(some(1.0))
    assert len(bench.handed_on) == 1
    assert "could not be recorded" in caplog.text


def test_the_sign_shows_since_when(bench: Bench, qtbot: QtBot) -> None:
    sign = RecordingSign(lambda: bench.sessions.sign)
    qtbot.addWidget(sign)
    assert sign.isHidden()
    bench.say(some(1.0))
    bench.listed()
    sign.refresh()
    since = given(bench.sessions.sign.since)
    assert sign.label.text() == f"Recorded since {since.astimezone():%H:%M}"
    assert not sign.isHidden()
    assert _is_a_warning(sign) is False
    QApplication.sendEvent(sign, QEvent(QEvent.Type.StyleChange))
    assert _is_a_warning(sign) is False


def _is_a_warning(sign: RecordingSign) -> bool:
    shown = find(sign, IconLabel)
    return shown._shown is not None and shown._shown[0] is Icon.WARNING


# In the window


def test_where_a_recording_has_a_gap_nothing_is_said_of_the_module(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as made:
        made.record(batch(1000.0, report(1000.0, active=True)), batch(1060.0, report(1060.0, active=True)))
        made.finish()
        recording = opened(made.path)
        seen = [device_at(recording, at_s) for at_s in (1000.0, 1030.0)]
    assert [one.fresh("active", 1000.0) for one in seen] == [True, None]
    assert seen[1].values == {}


def test_samples_of_two_ports_are_not_joined(qtbot: QtBot, qapp: QApplication) -> None:
    bridge = Bridge()
    taken: list[Batch] = []
    bridge.batch.connect(taken.append)
    for one in (some(1.0), some(2.0), some(3.0, connection=CLOSED), some(4.0, connection=OTHER)):
        bridge.deliver(one)
    qtbot.waitUntil(lambda: len(taken) == 3)
    assert [(one.connection, len(one.samples)) for one in taken] == [(OPEN, 6), (CLOSED, 3), (OTHER, 3)]
    bridge.close()


def test_a_recorded_session_streams_on_every_page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("paged?uptime=60"), window(qapp, tmp_path, entries=page_entries("live", "triggers")) as assembly:
        assembly.window.go_to("triggers")
        connect(qtbot, assembly, "sim://paged?uptime=60")
        qtbot.waitUntil(lambda: assembly.ports.module.view.is_streaming)
        assert not assembly.ports.current.stream.is_wanted
        assert assembly.ports.current.stream.is_recorded
        taken: list[StatusSample] = []
        assembly.ports.batch.connect(lambda batch: taken.extend(batch.samples))
        qtbot.waitUntil(lambda: len(taken) > 100)
        assert taken[-1].at - taken[-101].at < 10.0  # polled it would be 50 s
        assembly.window.disconnect_port()
        qtbot.waitUntil(lambda: not assembly.ports.current.stream.is_recorded)


def test_closing_the_window_closes_the_recording(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("closed"), window(qapp, tmp_path, entries=PAGES[:1]) as assembly:
        library = assembly.storage.recordings.library
        connect(qtbot, assembly, "sim://closed")
        qtbot.waitUntil(lambda: assembly.ports.current.recording.sign.since is not None)
        assembly.window.close_now()
        qtbot.waitUntil(lambda: not any(entry.is_running for entry in library.entries()))
        assert [entry.was_cut_off for entry in library.entries()] == [False]


def test_an_unwritable_disk_is_shown_and_the_link_continues(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("unkept"), window(qapp, tmp_path, entries=PAGES[:1]) as assembly:
        folder = assembly.storage.recordings.library.folder
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.write_text("a file stands where the folder should be", encoding="utf-8")
        connect(qtbot, assembly, "sim://unkept")
        bar, sign = assembly.window.notice_bar, assembly.window.recording_sign
        qtbot.waitUntil(lambda: "Not recording" in notice_text(bar))
        assert bar.button("recordings") is not None
        assert sign.label.text() == "Not recorded"
        assert assembly.ports.current.is_open
