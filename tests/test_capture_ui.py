"""Captures in the window: search and marks, save and open, decoded without a module, and played as a recording."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.acts import Act
from app.capture import Entry, Way, explained, read_capture
from app.journal import Outcome
from app.procedure import Ask, Cancelled, Pause, Procedure
from app.procedures.act import Performed, perform
from app.procedures.lock import Locked, lock
from app.recording import is_recording, questions_only
from app.simulator import bench
from app.store.database import StoreTrouble
from app.store.store import Store
from app.worker import Job
from protocol.catalogue import ACTIVATION, BY_NAME
from protocol.events import Unanswered
from protocol.link_states import Presence
from protocol.messages import Status
from tests.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.test_diagnosis_page import click, diagnosis
from tests.test_traffic import cell, sent, streamed
from ui.application import PAGES, Assembly
from ui.capture_files import SUFFIX, Kept, capture_parts
from ui.connector import Target
from ui.diagnosis_page import DiagnosisPage
from ui.link_state import Phase
from ui.preflight_page import PreflightPage
from ui.recording_bar import SPEEDS, recording_target
from ui.traffic_model import KEPT_ROWS, Column, Filter, TrafficModel
from ui.traffic_search import hex_part, matches

ACTIVE = Status(7, 1.0, triggered=False, active=True).encode()


def write_capture(path: Path, *, seconds: float = 30.0) -> Path:
    """A module that streams, ACTIVE, and answers what the window asks at first."""
    entries = []
    for number, name in enumerate(("heartbeat", "status", "active", "triggered", "cell_voltage", "boot_count")):
        request = BY_NAME[name].query()
        entries.append(Entry(0.01 * number, Way.OUT, request.encode()))
    answers = {"heartbeat": "4175 01 A5 5A 00", "active": "4175 33 01 01 35", "cell_voltage": "4175 34 01 BE F3"}
    ordered = []
    for entry, name in zip(entries, ("heartbeat", "status", "active", "triggered", "cell_voltage", "x"), strict=True):
        ordered.append(entry)
        if name in answers:
            ordered.append(Entry(entry.at_s + 0.002, Way.IN, bytes.fromhex(answers[name])))
    ordered += [Entry(0.2 + 0.05 * n, Way.IN, ACTIVE) for n in range(round(seconds * 20))]
    ordered.append(Entry(ordered[-1].at_s + 0.01, Way.IN, b"\x00\xff"))
    path.write_bytes(b"".join(capture_parts(tuple(ordered), Kept().header("/dev/ttyUSB0", 115200))))
    return path


@contextmanager
def opened(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[tuple[Assembly, DiagnosisPage, Path]]:
    path = write_capture(folder / f"flight{SUFFIX}")
    with diagnosis(qtbot, qapp, folder) as (assembly, page):
        page.files.ask_open = lambda _parent, _folder: path
        click(qtbot, page.files.open)
        qtbot.waitUntil(lambda: page.opened is not None, timeout=WAIT_MS)
        yield assembly, page, path


def strip_button(page: DiagnosisPage, key: str) -> QPushButton:
    button = page.strip.button(key)
    assert button is not None
    return button


def play(qtbot: QtBot, assembly: Assembly, page: DiagnosisPage) -> None:
    click(qtbot, strip_button(page, "capture_play"))
    qtbot.waitUntil(lambda: assembly.connector.device.presence is Presence.ONLINE, timeout=WAIT_MS)
    device = assembly.connector
    qtbot.waitUntil(lambda: device.device.known("active", device.clock()) is not None, timeout=WAIT_MS)


# Search and marks


def test_bytes_and_words_are_found() -> None:
    assert hex_part("41 75 3") == ""
    assert hex_part("41 75 3A") == "41753a"
    assert hex_part("tilt") == ""
    status = streamed(1)[0]
    assert matches(status, "41 75", "4175")
    assert matches(status, "tilt 7", "")
    assert matches(status, "stream", "")
    assert not matches(status, "boot count", "")


def test_search_goes_on_and_round_and_says_when_there_is_nothing(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        traffic = page.traffic
        click(qtbot, page.segments["traffic"])
        traffic.model.keep([*streamed(3000), sent("light"), *streamed(2000), sent("boot_count")])
        traffic.draw()
        qtbot.keyClick(assembly.window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
        assert traffic.search.field.hasFocus()
        qtbot.keyClicks(traffic.search.field, "query")

        def found() -> list[int]:
            return [index.row() for index in traffic.table.selectionModel().selectedRows()]

        qtbot.waitUntil(lambda: found() in ([3000], [5001]), timeout=WAIT_MS)
        first = found()
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() not in (first, []), timeout=WAIT_MS)
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() == first, timeout=WAIT_MS)
        click(qtbot, traffic.search.before)
        qtbot.waitUntil(lambda: found() not in (first, []), timeout=WAIT_MS)
        traffic.search.field.clear()
        qtbot.keyClicks(traffic.search.field, "FF FF FF")
        qtbot.waitUntil(lambda: traffic._count.text() == "Not found", timeout=WAIT_MS)


def test_marks_are_seen_filtered_and_outlive_the_list(qapp: QApplication) -> None:
    model = TrafficModel()
    model.keep([sent("light"), *streamed(5)])
    model.show_new()
    model.mark([0, 2])
    assert model.is_marked(0)
    spoken = model.index(0, Column.TIME.value).data(Qt.ItemDataRole.AccessibleTextRole)
    assert "marked" in spoken
    assert not model.index(0, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole).isNull()
    assert model.index(1, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole) is None
    model.mark([2])
    assert not model.is_marked(2)
    model.keep(streamed(KEPT_ROWS))
    model.show_new()
    model.use_filter(Filter.MARKED)
    assert model.rowCount() == 1
    assert "light" in cell(model, 0, Column.MEANING)
    model.mark([0])
    assert model.rowCount() == 0


def test_mark_by_key(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        click(qtbot, page.segments["traffic"])
        page.traffic.model.keep([sent("light"), sent("boot_count")])
        page.traffic.draw()
        page.traffic.table.selectRow(1)
        qtbot.keyClick(page.traffic.table, Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier)
        assert page.traffic.model.is_marked(1)
        click(qtbot, page.traffic.mark)
        assert not page.traffic.model.is_marked(1)


# Files


def test_what_is_saved_can_be_read_again(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / f"saved{SUFFIX}"
    with simulated("saved", stream_at_boot=True), diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        assembly.connector.connect_to(Target("sim://saved", 115200))
        wait_online(qtbot, assembly)
        page.files.ask_save = lambda _parent, _title, _suggested, _filter: path
        qtbot.waitUntil(page.files.save.isEnabled, timeout=WAIT_MS)
        kept = page.kept.entries()
        click(qtbot, page.files.save)
        qtbot.waitUntil(lambda: "Saved" in page.strip.accessibleName(), timeout=WAIT_MS)
        capture = read_capture(path)
        assert capture.header.port == "sim://saved"
        assert capture.header.baud_rate == 115200
        assert not capture.faults
        assert [entry.raw for entry in capture.entries[: len(kept)]] == [entry.raw for entry in kept]
        assert capture.entries[0].at_s == 0.0


def test_a_capture_that_cannot_be_saved_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.kept.take([sent("light")])
        page.files.refresh()
        page.files.ask_save = lambda _parent, _title, _suggested, _filter: tmp_path / "none" / "x.dpscap"
        click(qtbot, page.files.save)
        qtbot.waitUntil(lambda: "Choose another folder" in page.strip.accessibleName(), timeout=WAIT_MS)


def test_what_is_kept_is_bounded() -> None:
    kept = Kept()
    for first in range(0, 61_000, 1000):
        kept.take([*streamed(1000, first=first)])
    assert len(kept) == 60_000
    assert kept.has_dropped
    assert kept.entries(10)[0].at_s == 0.0
    assert len(kept.entries(10)) == 10


def test_a_capture_is_decoded_without_a_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (_assembly, page, path):
        model = page.traffic.model
        rows = list(explained(read_capture(path)))
        assert model.rowCount() == len(rows)
        assert page.traffic.isVisible()
        assert cell(model, 0, Column.TIME) == "0.000 s"
        assert cell(model, 0, Column.MEANING) == "heartbeat"
        assert cell(model, model.rowCount() - 1, Column.KIND) == "rejected"
        assert "active" in cell(model, 20, Column.MEANING)
        page.traffic.model.keep(streamed(5))  # what goes over the line meanwhile is kept, out of sight
        page.traffic.draw()
        assert model.rowCount() == len(rows)
        click(qtbot, strip_button(page, "capture_leave"))
        page.traffic.model.rebuild()
        assert model.rowCount() == 5
        assert not model.is_recorded


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no bytes"),
        (b"# DPS-S capture 9\n", "later version"),
        (b"hello\nworld\n", "no bytes"),
    ],
)
def test_a_file_that_is_no_capture_is_refused_with_the_reason(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, content: bytes, said: str
) -> None:
    path = tmp_path / f"other{SUFFIX}"
    path.write_bytes(content)
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.open_file(path)
        qtbot.waitUntil(lambda: said in page.strip.accessibleName(), timeout=WAIT_MS)
        page.open_file(tmp_path / "missing.dpscap")
        qtbot.waitUntil(lambda: "missing.dpscap was not opened" in page.strip.accessibleName(), timeout=WAIT_MS)
        assert page.opened is None


def test_hex_text_is_opened_and_its_faults_are_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / "pasted.hex"
    path.write_text("42 61 32 01 00 33\n41 75 32 07 0A 00 01 44\nzz\n", encoding="utf-8")
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.open_file(path)
        qtbot.waitUntil(lambda: page.opened is not None, timeout=WAIT_MS)
        assert "It has no times" in page.strip.accessibleName()
        assert "line 3" in page.strip.accessibleName()
        assert page.traffic.model.rowCount() == 2


def drop(window_: QWidget, path: Path) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    buttons, keys = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(QPoint(50, 50), Qt.DropAction.CopyAction, data, buttons, keys)
    QApplication.sendEvent(window_, enter)
    assert enter.isAccepted()
    QApplication.sendEvent(window_, QDropEvent(QPointF(50, 50), Qt.DropAction.CopyAction, data, buttons, keys))


def test_a_capture_dropped_on_the_window_is_opened(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"dropped{SUFFIX}", seconds=1)
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        drop(assembly.window, path)
        qtbot.waitUntil(lambda: page.opened is not None, timeout=WAIT_MS)


# Played


def test_a_recording_is_labelled_everywhere_and_sends_nothing(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, path):
        shell = assembly.window
        play(qtbot, assembly, page)
        shell.refresh()
        assert shell.top_bar.port.title == f"RECORDING: {path.name}"
        assert shell.windowTitle().startswith("RECORDING")
        assert shell.recording_bar.isVisible()
        assert "RECORDING" in shell.recording_bar.accessibleName()
        assert not shell.top_bar.lock.isEnabled()
        assert not shell.menus.lock.isEnabled()
        assert not shell.menus.find_rate.isEnabled()
        page.go_to("why")
        assert "recording" in page.why.what.text()
        assert not assembly.connector.is_active  # there is no module that could fire …
        known = assembly.connector.device.known("active", assembly.connector.clock())
        assert known is not None
        assert known.value is True  # … whatever was recorded
        assert shell.attention.is_risky_to_leave is False


def test_acts_end_unsent_while_a_recording_is_played(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        play(qtbot, assembly, page)
        ended: list[Job[Locked]] = []
        performed: list[Job[Performed]] = []
        assembly.connector.run(lock(), ended.append, is_urgent=True)
        journal = assembly.keeping.journal(assembly.connector.target)
        assembly.connector.run(perform(Act.LOCK, journal), performed.append)
        qtbot.waitUntil(lambda: bool(ended and performed), timeout=WAIT_MS)
        assert ended[0].outcome().is_acknowledged is False
        assert performed[0].outcome().outcome in (Outcome.NOT_SENT, Outcome.REFUSED)
        raws = {entry.raw for entry in page.kept.entries()}
        assert ACTIVATION.set(False).encode() not in raws
        rows = page.traffic.model
        rows.rebuild()
        assert not any("lock" in cell(rows, row, Column.MEANING) for row in range(rows.rowCount()))


def test_nothing_of_a_recording_is_remembered_or_kept_as_the_modules(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        play(qtbot, assembly, page)
        assert assembly.window._remembered.last_port is None
        assert len(page.kept) == 0
        assert page.live_figures.totals.sent == 0
        assert not assembly.keeping.journal(assembly.connector.target).is_ready
        assert isinstance(assembly.keeping.store, StoreTrouble)
        assert not assembly.keeping.has_store
        click(qtbot, assembly.window.recording_bar.stop)
        assert isinstance(assembly.keeping.store, Store)


def test_another_speed_begins_anew_and_it_can_be_stopped(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, path):
        play(qtbot, assembly, page)
        bar = assembly.window.recording_bar
        bar.speed.setCurrentIndex(SPEEDS.index(20.0))
        assert assembly.connector.target == recording_target(path, 20.0)
        qtbot.waitUntil(lambda: "ended" in bar.accessibleName(), timeout=WAIT_MS)
        assert assembly.window.top_bar.port.word == "The recording has ended"
        assert assembly.window.notice_bar.notice is None  # nobody is sent to check a cable
        click(qtbot, bar.again)
        qtbot.waitUntil(lambda: "ended" not in bar.accessibleName(), timeout=WAIT_MS)
        click(qtbot, bar.stop)
        qtbot.waitUntil(lambda: assembly.connector.state.phase is Phase.CLOSED, timeout=WAIT_MS)
        assembly.window.refresh()
        assert bar.isHidden()
        assert assembly.window.windowTitle() == "DPS-S Configurator"


def test_it_is_played_through_every_page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"whole{SUFFIX}")
    with window(qapp, tmp_path, entries=PAGES) as assembly:
        shell = assembly.window
        qtbot.waitUntil(lambda: shell.findChild(DiagnosisPage) is not None, timeout=WAIT_MS)
        shell.connect_to(recording_target(path, 5.0))
        wait_online(qtbot, assembly)
        for key in (entry.key for entry in PAGES):
            shell.go_to(key)
            QApplication.processEvents()
            assert shell.recording_bar.isVisible() or not shell.isVisible()
        preflight = shell.findChild(PreflightPage)
        assert isinstance(preflight, PreflightPage)
        assert not preflight.work.can_check  # there is no module that could be found fit to fly
        tilt = assembly.connector.device.known("tilt_deg", assembly.connector.clock())
        assert tilt is not None
        assert tilt.value == 7


def test_an_active_module_is_not_left_for_a_recording_unasked(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    path = write_capture(tmp_path / f"other{SUFFIX}", seconds=1)
    with simulated("armed", active=True), diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        assembly.connector.connect_to(Target("sim://armed", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: assembly.connector.is_active, timeout=WAIT_MS)
        page.open_file(path)
        qtbot.waitUntil(lambda: page.opened is not None, timeout=WAIT_MS)
        click(qtbot, strip_button(page, "capture_play"))
        bar = assembly.window.notice_bar
        assert not assembly.connector.is_recording
        leave = bar.button("leave_active")
        assert leave is not None
        click(qtbot, leave)
        qtbot.waitUntil(lambda: assembly.connector.is_recording, timeout=WAIT_MS)
        assert bench.module("armed").state().is_active


# Qt-free: questions only


def test_only_questions_go_out() -> None:
    def changes() -> Procedure[object]:
        before = yield Pause(0.1)
        refused = yield Ask(ACTIVATION.set(True), is_deliberate=True)
        answered = yield Ask(BY_NAME["active"].query())
        return before, refused, answered

    guarded = questions_only(changes())
    assert guarded.send(None) == Pause(0.1)
    assert guarded.send(5.0) == Ask(BY_NAME["active"].query())  # the set was never asked
    with pytest.raises(StopIteration) as ended:
        guarded.send("answer")
    assert ended.value.value == (5.0, Unanswered(ACTIVATION.set(True), 0, 0.0, 5.0), "answer")


def test_being_cancelled_reaches_the_procedure_inside() -> None:
    def cleans_up() -> Procedure[str]:
        try:
            yield Pause(1.0)
        except Cancelled:
            yield Ask(ACTIVATION.set(False))
            return "cleaned up"
        return "done"

    guarded = questions_only(cleans_up())
    guarded.send(None)
    with pytest.raises(StopIteration) as ended:
        guarded.throw(Cancelled())
    assert ended.value.value == "cleaned up"


def test_what_plays_a_capture() -> None:
    assert is_recording("capture:///tmp/x.dpscap?speed=1")
    assert not is_recording("/dev/ttyUSB0")
    assert not is_recording("sim://capture")
