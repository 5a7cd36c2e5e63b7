"""The automatic recording of sessions: start, end, content and indicator."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import ConversationView, StatusSample
from app.engine.worker import Batch, Connection
from app.procedures.stream import StreamSwitch
from app.recordings.library import RecordingLibrary
from app.system.clock import steady_time
from protocol.events import Began
from tests.support.records.recordings_made import CLOSED, LOST, OPEN, WAIT_S, batch, received, report
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.steps import notice_text
from ui.main import PAGES
from ui.session.recording import SessionRecording

NEXT = OPEN._replace(opening=7)


# From the worker to the disk, without a window


class Bench:
    """A session recording whose worker is the test."""

    def __init__(self, folder: Path) -> None:
        self.handed_on: list[Batch] = []
        self.library = RecordingLibrary(folder)
        self.stream = StreamSwitch(is_wanted=False)
        self.sessions = SessionRecording(self.stream, lambda: self.library)
        self.say = self.sessions.recorded(self.handed_on.append)

    def name(self, name: str, *, number: int = 1) -> None:
        self.sessions.name_module(name, ConversationView(number=number))

    def listed(self) -> list[tuple[str, tuple[str, ...], int]]:
        """Port, modules and number of reports of all recordings, oldest first."""
        assert self.sessions._recorder is None or self.sessions._recorder.settle(WAIT_S)
        return [(entry.port, entry.modules, entry.sample_count) for entry in reversed(self.library.entries())]


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    one = Bench(tmp_path / "recordings")
    yield one
    assert one.sessions.stop(WAIT_S)


def some(first_s: float, *, connection: Connection = OPEN, number: int = 1, begins: bool = False) -> Batch:
    """Three reports, by the clock of the recorder: a part that began a day ago ends."""
    first_s += steady_time()
    reports = tuple(report(first_s + n / 10, n) for n in range(3))
    events = ((Began(7, first_s),) if begins else ()) + tuple(map(received, reports))
    view = ConversationView(number=number, began_at=first_s)
    return batch(first_s + 0.3, *reports, connection=connection, view=view, events=events)


def test_everything_is_handed_on_and_recorded_until_the_port_is_closed(bench: Bench) -> None:
    batches = [some(1.0, begins=True), some(2.0), some(3.0, connection=CLOSED)]
    for one in batches:
        bench.say(one)
        bench.name("Left wing")
    assert bench.handed_on == batches
    assert bench.listed() == [("/dev/ttyUSB0", ("Left wing",), 9)]
    assert not bench.library.entries()[0].is_running


@pytest.mark.parametrize(
    ("connections", "counts"),
    [
        ((OPEN, OPEN), [6]),
        ((OPEN, LOST, NEXT), [6, 3]),  # lost, and back
        ((OPEN, NEXT), [3, 3]),
    ],
)
def test_one_opening_of_the_port_is_one_recording(
    bench: Bench, connections: tuple[Connection, ...], counts: list[int]
) -> None:
    for number, connection in enumerate(connections):
        bench.say(some(1.0 + number, connection=connection))
    assert [count for _, _, count in bench.listed()] == counts


def test_an_error_in_the_recorder_does_not_reach_the_worker(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(_batch: Batch) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(bench.sessions, "_on_batch", fail)
    bench.say(some(1.0))
    assert len(bench.handed_on) == 1
    assert "could not be recorded" in caplog.text


# In the window


def test_a_recorded_session_streams_on_every_page_and_is_closed_with_the_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("paged?uptime=60"), window(qapp, tmp_path, entries=page_entries("live", "triggers")) as assembly:
        assembly.window.go_to("triggers")
        connect(qtbot, assembly, "sim://paged?uptime=60")
        qtbot.waitUntil(lambda: assembly.ports.module.view.is_streaming)
        assert not assembly.ports.current.stream.is_wanted
        assert assembly.ports.current.stream.is_recorded
        taken: list[StatusSample] = []
        assembly.ports.current.batch.connect(lambda batch: taken.extend(batch.samples))
        qtbot.waitUntil(lambda: len(taken) > 100)
        assert taken[-1].at - taken[-101].at < 10.0  # polled it would be 50 s
        library = assembly.storage.library
        assembly.window.close_now()
        qtbot.waitUntil(lambda: not any(entry.is_running for entry in library.entries()))
        assert [entry.was_cut_off for entry in library.entries()] == [False]


def test_an_unwritable_disk_is_shown_and_the_link_continues(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("unkept"), window(qapp, tmp_path, entries=PAGES[:1]) as assembly:
        folder = assembly.storage.library.folder
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.write_text("a file stands where the folder should be", encoding="utf-8")
        connect(qtbot, assembly, "sim://unkept")
        bar, sign = assembly.window.notice_bar, assembly.window.recording_sign
        qtbot.waitUntil(lambda: "Not recording" in notice_text(bar))
        assert bar.button("recordings") is not None
        assert sign.label.text() == "Not recorded"
        assert assembly.ports.current.is_open
