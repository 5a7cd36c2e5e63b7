"""Captures played in the window are labelled everywhere, and only queries are sent."""

from pathlib import Path

from PySide6.QtCore import QRect
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.engine.playback import OnlyPlayedBack
from app.engine.worker import Job
from app.procedures.act import Performed, perform
from app.procedures.lock import Locked, lock
from app.safety.acts import Act
from app.simulator import bench
from app.store.database import StoreTrouble
from app.store.store import Store
from protocol.catalogue import ACTIVATION
from tests.support.window.capture_window import opened, play, strip_button, write_capture
from tests.support.window.fakes_ui import WAIT_MS, connect, simulated, wait_online, window
from tests.support.window.moved import moved, places
from tests.support.window.steps import find, press
from tests.ui.pages.diagnosis.test_diagnosis_page import diagnosis
from tests.ui.pages.diagnosis.test_traffic import cell
from ui.main import PAGES
from ui.pages.diagnosis.capture_files import SUFFIX
from ui.pages.diagnosis.traffic_model import Column
from ui.pages.preflight.page import PreflightPage
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice
from ui.widgets.recording_bar import SPEEDS, recording_target


def test_the_notice_of_an_open_capture_follows_the_language(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, path):
        assert page.strip.notice is not None
        assert page.strip.notice.text.startswith(f"{path.name}; rows: ")
        assembly.language_switch.use("zh_CN")
        assert "行数" in page.strip.notice.text
        assert strip_button(page, "capture_leave").text() == "返回实时"
        assembly.language_switch.use("en")


# Played


def test_a_recording_is_labelled_everywhere_and_sends_nothing(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
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
        page.why.refresh()
        assert page.why.seen["port"].text() == f"{path.name}, 115200 baud"
        assert not assembly.connector.is_active  # there is no module that could fire …
        known = assembly.connector.device.known("active", assembly.connector.clock())
        assert known is not None
        assert known.value is True  # … whatever was recorded
        assert shell.attention.is_risky_to_leave is False


def test_nothing_moves_when_a_capture_is_played_and_stopped(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Its bar stands at the foot of the window; beside a notice its buttons stay where they are."""
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        shell = assembly.window

        def seen() -> dict[str, QRect]:
            shell.refresh()
            qapp.processEvents()
            one = {key: place for key, place in places(shell).items() if not key.startswith("notice_")}
            return one | {"area": shell.area.geometry().translated(shell.centre.pos())}

        page._close_capture()
        before = seen()
        assembly.window.connect_to(recording_target(_path))
        wait_online(qtbot, assembly)
        playing = seen()
        assert {"recording_stop", "recording_speed", "area", "traffic_pause"} <= playing.keys()
        assert moved(before, playing) == []
        assert playing["area"] == before["area"]
        shell.attention.queue_notice(lambda: Notice(Meaning.ATTENTION, "Something to read. " * 20))
        beside = seen()
        assert shell.notice_bar.isVisible()
        assert moved(playing, beside) == []
        shell.attention.dismiss_queued()
        shell.show_message("Saved.")
        shell.status_bar._write()
        assert shell.recording_bar.label.text() == "Saved."
        press(qtbot, shell.recording_bar.stop)
        qtbot.waitUntil(lambda: assembly.connector.state.phase is Phase.CLOSED, timeout=WAIT_MS)
        after = seen()
        assert shell.recording_bar.isHidden()
        assert moved(before, after) == []
        assert after["area"] == before["area"]


def test_acts_end_unsent_while_a_recording_is_played(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        play(qtbot, assembly, page)
        ended: list[Job[Locked]] = []
        performed: list[Job[Performed]] = []
        assembly.connector.run(lock(), ended.append, is_urgent=True)
        journal = assembly.storage.journal(assembly.connector.target)
        assembly.connector.run(perform(Act.ZERO, journal), performed.append)
        qtbot.waitUntil(lambda: bool(ended and performed), timeout=WAIT_MS)
        assert isinstance(ended[0].run.error, OnlyPlayedBack)
        assert isinstance(performed[0].run.error, OnlyPlayedBack)
        raws = {entry.raw for entry in page.traffic_buffer.entries()}
        assert ACTIVATION.set(False).encode() not in raws
        rows = page.traffic.model
        rows.rebuild()
        assert not any("lock" in cell(rows, row, Column.MEANING) for row in range(rows.rowCount()))


def test_data_of_a_playback_is_not_kept_as_the_modules(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        play(qtbot, assembly, page)
        assert assembly.window._remembered.last_port is None
        assert len(page.traffic_buffer) == 0
        assert page.live_figures.totals.sent == 0
        assert not assembly.storage.journal(assembly.connector.target).is_ready
        assert isinstance(assembly.storage.store, StoreTrouble)
        assert not isinstance(assembly.storage.store, Store)
        press(qtbot, assembly.window.recording_bar.stop)
        assert isinstance(assembly.storage.store, Store)


def test_a_played_state_is_not_left_behind_as_the_modules(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """The recorded module was active."""
    with opened(qtbot, qapp, tmp_path) as (assembly, page, _path):
        play(qtbot, assembly, page)
        shell = assembly.window
        press(qtbot, shell.recording_bar.stop)
        assert not assembly.connector.is_active
        qtbot.waitUntil(lambda: assembly.connector.state.phase is Phase.CLOSED, timeout=WAIT_MS)
        shell.refresh()
        assert not assembly.connector.is_active
        assert not assembly.connector.device.values
        assert "unknown" in shell.top_bar.activation.accessibleName()
        assert shell.attention.is_risky_to_leave is False


def test_another_speed_restarts_the_playback_and_it_can_be_stopped(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with opened(qtbot, qapp, tmp_path) as (assembly, page, path):
        play(qtbot, assembly, page)
        bar = assembly.window.recording_bar
        bar.speed.setCurrentIndex(SPEEDS.index(20.0))
        assert assembly.connector.target == recording_target(path, 20.0)
        qtbot.waitUntil(lambda: "ended" in bar.accessibleName(), timeout=WAIT_MS)
        qtbot.waitUntil(lambda: assembly.window.top_bar.port.word == "ended", timeout=WAIT_MS)
        assert assembly.window.notice_bar.notice is None  # no advice about cables
        press(qtbot, bar.again)
        qtbot.waitUntil(lambda: "ended" not in bar.accessibleName(), timeout=WAIT_MS)
        press(qtbot, bar.stop)
        qtbot.waitUntil(lambda: assembly.connector.state.phase is Phase.CLOSED, timeout=WAIT_MS)
        assembly.window.refresh()
        assert bar.isHidden()
        assert assembly.window.windowTitle() == "DPS-S Configurator"


def test_it_is_played_through_every_page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"whole{SUFFIX}")
    with window(qapp, tmp_path, entries=PAGES) as assembly:
        shell = assembly.window
        qtbot.waitUntil(lambda: len(shell._pages) == len(PAGES), timeout=4 * WAIT_MS)
        shell.connect_to(recording_target(path, 5.0))
        wait_online(qtbot, assembly)
        for key in (entry.key for entry in PAGES):
            shell.go_to(key)
            QApplication.processEvents()
            assert shell.recording_bar.isVisible() or not shell.isVisible()
        preflight = find(shell, PreflightPage)
        assert not preflight.work.can_check  # there is no module that could be found fit to fly
        tilt = assembly.connector.device.known("tilt_deg", assembly.connector.clock())
        assert tilt is not None
        assert tilt.value == 7


def test_an_active_module_is_not_left_for_a_recording_unasked(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"other{SUFFIX}", seconds=1)
    with simulated("armed", active=True), diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        connect(qtbot, assembly, "sim://armed")
        qtbot.waitUntil(lambda: assembly.connector.is_active, timeout=WAIT_MS)
        page.open_file(path)
        qtbot.waitUntil(lambda: page.opened is not None, timeout=WAIT_MS)
        press(qtbot, strip_button(page, "capture_play"))
        bar = assembly.window.notice_bar
        assert not assembly.connector.is_playback
        leave = bar.button("leave_active")
        assert leave is not None
        press(qtbot, leave)
        qtbot.waitUntil(lambda: assembly.connector.is_playback, timeout=WAIT_MS)
        assert bench.module("armed").state().is_active


def test_no_notice_moves_a_control_of_the_page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        for key in ("why", "traffic", "figures", "bundle"):
            page.go_to(key)
            qapp.processEvents()
            before = places(page)
            page.result.notify(Meaning.ATTENTION, lambda: "Something to read. " * 20)
            qapp.processEvents()
            assert page.strip.isVisible()
            assert moved(before, places(page)) == []
            page.result.dismiss()
            qapp.processEvents()
