"""The longest state of a row of the Settings page, on the screen at which the page has least room for it."""

from pathlib import Path

import pytest
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.device import How, Known
from app.settings.drafts import Draft
from app.settings.form import FormRow, RowState
from app.settings.setting_texts import value_text
from app.text.i18n import ENGLISH, PSEUDO
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import window
from tests.support.window.settings_bench import ENTRIES
from tests.support.window.steps import find
from tests.support.window.walk import SMALL_SCREEN
from ui.main import WindowOptions
from ui.pages.settings.page import SettingsPage
from ui.style.theme import Choice, Size, font
from ui.widgets.step_button import is_in_sight


def test_acknowledged_is_not_cut_off(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Another page may switch the stream at any moment: the walk through the window meets this state by chance."""
    with window(qapp, tmp_path, options=WindowOptions(language=PSEUDO), entries=ENTRIES) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(SMALL_SCREEN)
        assembly.window.panel.hide()
        assembly.window.go_to("settings")
        page = find(assembly.window, SettingsPage)
        known = Known(value=True, how=How.ACKNOWLEDGED, at=assembly.connector.clock())
        row = FormRow(command=SERIAL_OUTPUT, module_value=known, draft=None, state=RowState.ACKNOWLEDGED)
        for _ in range(2):  # a layout asks for another one
            page.rows["serial_output"].show_row(row, known.at, is_editable=True, is_chosen=False)
            QApplication.processEvents()
        assert page.rows["serial_output"].state.word
        assert not cut_off(page)


@pytest.mark.parametrize("size", [(1366, 768), (960, 540)])
def test_in_sunlight_values_and_chosen_flags_are_whole(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, size: tuple[int, int]
) -> None:
    with window(qapp, tmp_path, options=WindowOptions(language=ENGLISH), entries=ENTRIES) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(*size)
        assembly.appearance.choose(Choice.SUNLIGHT)
        assembly.window.panel.hide()
        assembly.window.go_to("settings")
        page = find(assembly.window, SettingsPage)
        command = BY_NAME["attitude_trigger"]
        row = FormRow(command=command, module_value=None, draft=Draft("", value=False), state=RowState.EDITED)
        for _ in range(2):  # a layout asks for another one
            page.rows[command.key].show_row(row, 0.0, is_editable=True, is_chosen=False)
            QApplication.processEvents()
        assert not [fault for fault in cut_off(page) if command.name in fault]
        rows = page.rows.values()
        assert sum(is_in_sight(row) for row in rows) >= (7 if size == (1366, 768) else 5)
        heights = [row.height() for row in rows]
        assert max(heights) - min(heights) <= 1  # fields are as high as buttons
        bold, small = QFontMetricsF(font(Size.BODY, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        assert bold.horizontalAdvance(value_text(BAUD_RATE, 115200)) <= page.baud.stands.width()
        assert small.horizontalAdvance(page.rows[command.key].stands.note) <= page.rows[command.key].stands.width()
