"""What every page does: it is laid out anew for another size of text."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS, window
from ui.main import PAGES
from ui.pages.settings.page import SettingsPage
from ui.pages.settings.row import EDITOR_PX
from ui.services.page import HEIGHT_PX
from ui.style.theme import scaled


def test_the_page_in_sight_follows_the_size_of_text(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    entries = tuple(entry for entry in PAGES if entry.key == "settings")
    with window(qapp, tmp_path, entries=entries) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.findChild(SettingsPage) is not None, timeout=WAIT_MS)
        page = main.findChild(SettingsPage)
        assert page is not None
        main.resize(1700, 1000)
        main.panel.hide()
        for percent in (150, 100):
            main.choices.use_zoom(percent)
            qapp.processEvents()
            editors = {row.editor.width() for row in page.rows.values()}
            assert (page.header.minimumHeight(), editors) == (scaled(HEIGHT_PX), {scaled(EDITOR_PX)})
