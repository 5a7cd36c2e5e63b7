"""A recording on the Live page fits on a small screen."""

from pathlib import Path
from shutil import copytree

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.records.recordings_desk import record
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.walk import SMALL_SCREEN
from ui.main import PAGES
from ui.pages.live.page import LivePage
from ui.pages.recordings.page import RecordingsPage

ENTRIES = tuple(entry for entry in PAGES if entry.key in ("live", "recordings"))


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"), seconds=10)


def test_a_recording_that_is_opened_from_the_list_fits_on_a_small_screen(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    with simulated("small"), window(qapp, tmp_path, entries=ENTRIES) as assembly:
        main = assembly.window
        main.resize(SMALL_SCREEN)
        qtbot.waitUntil(lambda: main.findChild(RecordingsPage) is not None, timeout=WAIT_MS)
        live = main.findChild(LivePage)
        assert live is not None
        copytree(template, assembly.storage.sessions.library.folder / template.name)
        main.connect_to(Target("sim://small", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: live.data.has_samples and not live.is_empty, timeout=WAIT_MS)
        main.go_to("recordings")
        assembly.storage.recordings.open(assembly.storage.sessions.library.entries()[-1])
        qtbot.waitUntil(lambda: live.isVisible() and live.recording is not None, timeout=WAIT_MS)
        QApplication.processEvents()
        assert not cut_off(live.panel)
