"""The longest state of a row of the Settings page, on the screen at which the page has least room for it."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.device import How, Known
from app.settings.form import FormRow, RowState
from app.text.i18n import PSEUDO
from protocol.catalogue import SERIAL_OUTPUT
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import window
from tests.support.window.settings_bench import ENTRIES
from tests.support.window.walk import SMALL_SCREEN
from ui.main import WindowOptions
from ui.pages.settings.page import SettingsPage


def test_acknowledged_is_not_cut_off(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Another page may switch the stream at any moment: the walk through the window meets this state by chance."""
    with window(qapp, tmp_path, options=WindowOptions(language=PSEUDO), entries=ENTRIES) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(SMALL_SCREEN)
        assembly.window.panel.hide()
        assembly.window.go_to("settings")
        page = assembly.window.findChild(SettingsPage)
        assert page is not None
        known = Known(value=True, how=How.ACKNOWLEDGED, at=assembly.connector.clock())
        row = FormRow(command=SERIAL_OUTPUT, module_value=known, draft=None, state=RowState.ACKNOWLEDGED)
        for _ in range(2):  # a layout asks for another one
            page.rows["serial_output"].show_row(row, known.at, is_editable=True, is_chosen=False)
            QApplication.processEvents()
        assert page.rows["serial_output"].state.word
        assert not cut_off(page)
