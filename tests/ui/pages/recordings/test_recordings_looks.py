"""A recording on the Live page: everything of it has room, also where little is left."""

from collections.abc import Iterator
from pathlib import Path
from shutil import copytree

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.walk import SMALL_SCREEN
from ui.main import PAGES
from ui.pages.live.page import LivePage
from ui.pages.recordings.page import RecordingsPage
from ui.widgets.readout import StateChip

ENTRIES = tuple(entry for entry in PAGES if entry.key in ("live", "recordings"))


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"), seconds=10)


@pytest.fixture
def opened(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    with made(qtbot, qapp, tmp_path, template, LivePage) as desk:
        desk.storage.recordings.open(desk.library.entries()[0])
        desk.wait(lambda: desk.live.recording is not None)
        yield desk


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


def test_the_head_of_the_plots_has_its_word_again_where_there_is_room(opened: Desk) -> None:
    chip = opened.live.plot.findChild(StateChip, "time-plot-state")
    assert chip is not None
    shown = opened.live.window()
    shown.resize(500, 500)
    opened.wait(lambda: chip.word == "")
    shown.resize(1000, 500)
    opened.wait(lambda: chip.word == "recorded")
