"""The tour through the whole window, by keys and clicks: it reaches GO, blocks nothing, touches no module but its own,
and leaves nothing behind."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.recordings.recording import open_recording
from app.records.check_store import CheckStore
from app.settings.form import RowState
from app.simulator import bench as benches
from app.store.store import Store
from app.text.i18n import CHINESE, tr
from tests.support.check_pace import hurry_check
from tests.support.records.recordings_desk import record
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.preflight_window import CHECK_MS
from tests.support.window.steps import let_lay_out, settle
from ui.core.preferences import Preferences
from ui.help.tour import Tour
from ui.help.tour_card import TourCard
from ui.help.tour_steps import STEPS, Scene
from ui.main import PAGES, Assembly
from ui.pages.live.page import LivePage
from ui.pages.preflight.controller import Standing
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.services.tour_port import TOUR_NAME, is_tour
from ui.style.painted_widget import Freshness
from ui.style.theme import Choice

SMALL_SCREEN = QSize(1024, 600)
MOST_PRESSES = 8
Keys = Qt.Key


@dataclass
class Guest:
    """Somebody who takes the tour."""

    qtbot: QtBot
    assembly: Assembly

    @property
    def tour(self) -> Tour:
        tour = self.assembly.help.tour
        assert tour is not None
        return tour

    @property
    def scene(self) -> Scene:
        assert self.tour.scene is not None
        return self.tour.scene

    def press(self, key: Keys) -> None:
        """Where the keyboard is, as a person would."""
        focused = self.assembly.window.focusWidget()
        assert focused is not None
        self.qtbot.keyClick(focused, key)

    def click(self, button: QPushButton | None) -> None:
        assert button is not None
        let_lay_out()
        settle(button)
        self.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    def wait_scene(self, timeout_ms: int = WAIT_MS) -> None:
        """Until there is something to do, or the step is done."""
        self.qtbot.waitUntil(lambda: self.scene.is_done or self.scene.do is not None, timeout=timeout_ms)

    def do_step(self) -> None:
        """Press Enter until the step is done; at each press the card is in nobody's way."""
        for _ in range(MOST_PRESSES):
            self.wait_scene(CHECK_MS)
            self.assert_out_of_the_way()
            if self.scene.is_done:
                return
            before = self.words
            assert self.tour.card.main.hasFocus()
            self.press(Keys.Key_Return)
            self.qtbot.waitUntil(partial(self.has_gone_on, before), timeout=WAIT_MS)
        pytest.fail(f"step {self.tour.number}: {self.scene.text}")

    @property
    def words(self) -> str:
        return f"{self.scene.text} [{self.scene.act}]"

    def has_gone_on(self, before: str) -> bool:
        return self.words != before

    def assert_out_of_the_way(self) -> None:
        """LOCK can be clicked, and the card is whole within the window."""
        main, card = self.assembly.window, self.tour.card
        lock = main.top_bar.lock
        assert main.childAt(lock.mapTo(main, lock.rect().center())) is lock
        assert main.rect().contains(card.geometry())
        assert not card.geometry().intersects(_in_window(main.top_bar, main))
        assert card.height() >= card.heightForWidth(card.width())


def _in_window(widget: QWidget, main: QWidget) -> QRect:
    return QRect(widget.mapTo(main, QPoint()), widget.size())


@contextmanager
def guest(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[Guest]:
    with window(qapp, folder, entries=PAGES) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made, timeout=CHECK_MS):
            assembly.window.resize(SMALL_SCREEN)
        assembly.window.activateWindow()
        qtbot.waitUntil(assembly.window.isActiveWindow, timeout=WAIT_MS)
        yield Guest(qtbot, assembly)
        assembly.help.end_tour()
        assembly.connector.disconnect_port()
        qtbot.waitUntil(lambda: not assembly.connector.is_open, timeout=WAIT_MS)
    benches.forget(TOUR_NAME)


def test_by_keys_alone_it_goes_to_go_and_leaves_nothing(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hurry_check(monkeypatch, still_s=0.2)
    with guest(qtbot, qapp, tmp_path) as one:
        main, connector = one.assembly.window, one.assembly.connector
        main.go_to("diagnosis")
        one.assembly.appearance.choose(Choice.DARK)
        main.menus.tour.trigger()
        assert not connector.is_wanted  # nothing before the person says so
        one.press(Keys.Key_Right)
        assert one.tour.number == 0  # and no step without it
        seen = []
        for number, step in enumerate(STEPS):
            assert one.tour.number == number
            assert main.navigation.chosen == step.page
            one.do_step()
            seen.append(one.scene.text)
            match step.page:
                case "settings":
                    row = main.findChild(SettingsPage).rows["freefall_time_s"].row  # type: ignore[union-attr]
                    assert row is not None
                    assert row.state is RowState.VERIFIED
                    assert benches.module(TOUR_NAME).module.memory.freefall_time == 120
                case "preflight":
                    page = main.findChild(PreflightPage)
                    assert page is not None
                    assert page.banner.announcement.standing is Standing.READY
                case "diagnosis":
                    assert benches.module(TOUR_NAME).plug_number > 1
            assert not benches.module(TOUR_NAME).state().is_active
            one.press(Keys.Key_Right)
        assert len(set(seen)) == len(STEPS)
        assert one.assembly.help.tour is None
        assert main.navigation.chosen == "diagnosis"
        assert one.assembly.appearance.choice is Choice.DARK
        assert not any(one.isVisible() for one in main.findChildren(TourCard))
        assert connector.target is None
        assert not connector.device.values
        store = one.assembly.storage.store
        assert isinstance(store, Store)
        assert not store.modules()
        assert not CheckStore(store.database).checks(None)
        assert not one.assembly.storage.sessions.library.entries()
        assert Preferences(tmp_path / "window.ini").last_port is None
        page = main.findChild(PreflightPage)
        assert page is not None
        assert page.work.standing is Standing.NOT_CHECKED
        live = main.findChild(LivePage)
        assert live is not None
        assert live.is_empty


def test_a_real_module_is_never_touched(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("customer", active=True) as bench, guest(qtbot, qapp, tmp_path) as one:
        main, connector = one.assembly.window, one.assembly.connector
        connector.connect_to(Target("sim://customer", 115200))
        wait_online(qtbot, one.assembly)
        one.assembly.help.begin_tour()
        assert "sim://customer" in one.scene.text
        one.press(Keys.Key_Right)
        assert one.tour.number == 0
        one.press(Keys.Key_Return)  # disconnect: it is ACTIVE, so the window asks as ever
        one.click(main.notice_bar.button("stay"))
        assert connector.target == Target("sim://customer", 115200)
        one.tour.card.main.click()
        one.click(main.notice_bar.button("leave_active"))
        qtbot.waitUntil(lambda: one.scene.act == "Connect the simulated module", timeout=WAIT_MS)
        assert not connector.is_wanted
        assert bench.state().is_active
        assert bench.state().is_plugged_in


def test_another_connection_ends_it_and_stays(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("other") as bench, guest(qtbot, qapp, tmp_path) as one:
        main, connector = one.assembly.window, one.assembly.connector
        one.assembly.help.begin_tour()
        one.do_step()
        assert is_tour(connector.target)
        main.connect_to(Target("sim://other", 115200))
        qtbot.waitUntil(lambda: one.assembly.help.tour is None, timeout=WAIT_MS)
        wait_online(qtbot, one.assembly)
        assert connector.target == Target("sim://other", 115200)
        assert bench.state().is_plugged_in
        assert main.status_bar.passing.text()


def test_escape_ends_and_left_goes_back(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with guest(qtbot, qapp, tmp_path) as one:
        main = one.assembly.window
        had_sheet = main.panel.isVisible()
        one.assembly.help.begin_tour()
        assert not main.panel.isVisible()
        one.do_step()
        one.press(Keys.Key_Right)
        assert one.tour.number == 1
        one.press(Keys.Key_Left)
        assert one.tour.number == 0
        main.go_to("commands")
        qtbot.waitUntil(lambda: one.scene.spots == (main.navigation,), timeout=WAIT_MS)
        one.tour.card.main.click()
        assert main.navigation.chosen == "live"
        one.tour.card.take_focus()
        one.press(Keys.Key_Escape)
        assert one.assembly.help.tour is None
        assert not one.assembly.connector.is_wanted
        assert main.panel.isVisible() == had_sheet


def test_it_speaks_the_language_in_use(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with guest(qtbot, qapp, tmp_path) as one:
        one.assembly.help.begin_tour()
        card, english = one.tour.card, one.tour.card.text.text()
        one.assembly.language_switch.use(CHINESE)
        qtbot.waitUntil(lambda: card.text.text() != english, timeout=WAIT_MS)
        assert card.title.text() == tr(STEPS[0].title) != STEPS[0].title
        assert card.end.text() == tr("End the tour") != "End the tour"
        assert card.accessibleDescription() == card.text.text()


def test_it_is_offered_until_it_was_taken_or_declined(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    def offer(assembly: Assembly) -> QWidget:
        found = assembly.window.findChild(QWidget, "live_tour_offer")
        assert found is not None
        return found

    with guest(qtbot, qapp, tmp_path) as one:
        panel = one.assembly.window.panel
        assert panel.tour.isVisible()
        panel.hide()
        assert offer(one.assembly).isVisible()
        decline = one.assembly.window.findChild(QPushButton, "live_tour_decline")
        assert decline is not None
        qtbot.mouseClick(decline, Qt.MouseButton.LeftButton)
        assert offer(one.assembly).isHidden()
    with guest(qtbot, qapp, tmp_path) as one:
        one.assembly.window.refresh()
        assert offer(one.assembly).isHidden()
        assert one.assembly.window.panel.tour.isHidden()
        assert one.assembly.window.menus.tour.isEnabled()


def test_a_recording_does_not_stand_for_the_tours_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    folder = record(tmp_path / "shelf", seconds=3)
    with guest(qtbot, qapp, tmp_path) as one:
        main = one.assembly.window
        live = main.findChild(LivePage)
        assert live is not None
        live.show_recording(open_recording(folder))
        one.assembly.help.begin_tour()
        assert live.recording is None
        one.do_step()
        one.press(Keys.Key_Right)
        one.wait_scene()
        qtbot.waitUntil(lambda: live.panel.tilt.freshness is Freshness.FRESH, timeout=WAIT_MS)
        one.press(Keys.Key_Escape)
        assert "recording" in main.status_bar.passing.text()
