"""The first run without a manual: from the first start to READY by clicks and keys."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.simulator import bench as benches
from tests.support.check_pace import hurry_check
from tests.support.window.fakes_ui import WAIT_MS, ListedPorts, wait_online, window
from tests.support.window.preflight_window import VERDICTS
from tests.support.window.steps import find, press
from ui.main import PAGES, Assembly
from ui.pages.preflight.controller import Standing
from ui.pages.preflight.page import PreflightPage

MAX_CHECKS = 6
"""A busy machine answers late, which is a fault that the check rightly finds."""


def click(qtbot: QtBot, assembly: Assembly, name: str) -> None:
    widget = find(assembly.window, QWidget, name)
    assert widget.isVisible(), name
    assert widget.isEnabled(), name
    press(qtbot, widget)


def test_from_the_icon_to_go(qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hurry_check(monkeypatch, still_s=0.2)
    benches.remove_bench("demo")
    with window(qapp, tmp_path, ports=ListedPorts(), entries=PAGES) as assembly:
        main, connector = assembly.window, assembly.connector
        with qtbot.waitSignal(main.pages_made):
            main.resize(1024, 600)
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow, timeout=WAIT_MS)
        qtbot.waitUntil(main.panel.isVisible, timeout=WAIT_MS)
        assert not main.panel.connect_button.isEnabled()
        ports = main.panel.list
        row = ports.model().index(ports.model().rowCount() - 1, 0)
        qtbot.mouseClick(ports.viewport(), Qt.MouseButton.LeftButton, pos=ports.visualRect(row).center())
        assert ports.chosen is not None
        click(qtbot, assembly, "connect_button")
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: connector.current.state.phase is Phase.ONLINE, timeout=WAIT_MS)
        qtbot.waitUntil(main.panel.isHidden, timeout=WAIT_MS)
        assert "Pre-flight" in main.status_bar.passing.text()  # what comes next
        benches.module("demo").set_tilt(20)  # as if it were not set down
        qtbot.keyClick(main, Qt.Key.Key_4, Qt.KeyboardModifier.ControlModifier)
        page = find(main, PreflightPage)
        qtbot.waitUntil(page.isVisible, timeout=WAIT_MS)
        page.tick()
        assert "Enable triggers and check" in page.banner.announcement.head
        click(qtbot, assembly, "preflight_enable")
        wait_verdict(qtbot, page)
        assert page.work.standing is Standing.NO_GO
        for _ in range(MAX_CHECKS):
            if page.work.standing is Standing.READY:
                break
            set_down = page.strip.button("set_down")
            button = set_down if set_down is not None and set_down.isVisible() else page.buttons.run
            press(qtbot, button)
            wait_verdict(qtbot, page)
        assert page.banner.announcement.word == "READY"
        assert benches.module("demo").state().tilt_deg == 0  # by the button that said so
        connector.current.disconnect_port()
        qtbot.waitUntil(lambda: not connector.current.is_open, timeout=WAIT_MS)
    benches.remove_bench("demo")


def wait_verdict(qtbot: QtBot, page: PreflightPage) -> None:
    qtbot.waitUntil(lambda: page.work.standing is not Standing.CHECKING)
    assert page.work.standing in VERDICTS


def test_each_page_leads_to_the_list_of_ports(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Every page, with nothing connected: one sentence on it, and a button in sight that leads on."""
    with window(qapp, tmp_path, ports=ListedPorts(), entries=PAGES) as assembly:
        main = assembly.window
        with qtbot.waitSignal(main.pages_made):
            main.resize(1024, 600)
        qtbot.waitUntil(main.panel.isVisible, timeout=WAIT_MS)
        for entry in PAGES[1:]:
            main.go_to(entry.key)
            assert main.panel.isHidden(), entry.key  # it would lie over the page
            own = {"diagnosis": "why_act"}  # pages that say so themselves
            button = (
                main.findChild(QPushButton, own[entry.key])
                if entry.key in own
                else main.notice_bar.button("choose_port")
            )
            assert button is not None, entry.key
            assert button.isVisible(), entry.key
        press(qtbot, button)
        assert main.panel.isVisible()
