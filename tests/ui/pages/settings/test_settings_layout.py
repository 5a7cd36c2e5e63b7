"""What is in sight of the Settings page, whole, at each size, and that its rows do not move."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication, QToolButton
from pytestqt.qtbot import QtBot

from app.engine.device import How, Known
from app.settings.form import FormRow, RowState
from app.settings.setting_texts import value_text
from app.text.i18n import ENGLISH, PSEUDO
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT
from tests.support.window import walk
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import window
from tests.support.window.settings_bench import ENTRIES, desk, type_into, write
from tests.support.window.steps import find, let_lay_out
from tests.support.window.walk import SMALL_SCREEN
from ui.main import WindowOptions
from ui.pages.settings.page import SettingsPage
from ui.pages.settings.row import NAME_PX, WIDE_NAME_PX
from ui.shell.main_window import FIRST_SIZE
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
        row = FormRow(command=SERIAL_OUTPUT, module_value=known, edited=None, state=RowState.ACKNOWLEDGED)
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
        row = FormRow(command=command, module_value=None, edited=False, state=RowState.EDITED)
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


def test_a_reason_is_whole_at_the_first_size(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.assembly.window.resize(FIRST_SIZE)
        for name, text in (("attitude_threshold", "40"), ("freefall_acceleration", "0.9"), ("light_threshold", "0")):
            type_into(one, name, text)
        one.click(one.find(QToolButton, "freefall_trigger_off"))
        one.settings.refresh()
        let_lay_out()
        one.until(lambda: not any("…" in row.reason.text() for row in one.settings.rows.values()))
        assert not one.settings.rows["serial_output"].reason.text()


@pytest.mark.parametrize("language", ["en", "zh_CN"])
def test_the_baud_rate_and_the_profiles_are_in_sight_on_the_smallest_screen(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, language: str
) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.assembly.language_switch.use(language)
        one.assembly.window.resize(1024, 600)
        one.settings.refresh()
        let_lay_out()
        page = one.settings
        for widget in (page.baud, page.files.open, page.files.recent, page.files.save, page.code, page.write):
            assert is_in_sight(widget), widget.objectName()


@pytest.mark.parametrize(("width", "height", "least"), [(1366, 768, 8), (1024, 600, 6)])
def test_the_table_is_dense_and_its_rows_never_move(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, width: int, height: int, least: int
) -> None:
    """All eight settings in sight at 1366×768, six at 1024×600; a neighbour's state moves no row."""
    with desk(qtbot, qapp, tmp_path) as one:
        one.assembly.window.resize(width, height)
        page = one.settings
        rows = [*page.rows.values(), page.baud]

        def places() -> list[QRect]:
            page.refresh()
            let_lay_out()
            return [QRect(row.mapTo(page, QPoint()), row.size()) for row in rows]

        one.until(lambda: sum(is_in_sight(row) for row in rows) >= least)
        before = places()
        for button in (page.write, page.revert, page.read):
            assert is_in_sight(button), button.objectName()
        assert page.scroll_area.horizontalScrollBar().maximum() == 0
        type_into(one, "freefall_time", "9999")
        assert places() == before
        type_into(one, "freefall_time", "0.1")
        one.click(one.find(QToolButton, "freefall_trigger_off"))
        assert page.pane.title.text() == "Free-fall trigger"  # the row that is edited is the chosen one
        assert places() == before
        write(one)
        one.until(lambda: page.strip.notice is not None)
        assert places() == before


def test_wide_columns_never_make_a_narrow_window_scroll_sideways(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    """Otherwise the next page begins too wide, with Cancel of the deploy panel out of sight."""
    with desk(qtbot, qapp, tmp_path) as one:
        main, name = one.assembly.window, one.settings.rows["attitude_threshold_deg"].name
        for width, name_px in ((1024, NAME_PX), (940, WIDE_NAME_PX), (790, NAME_PX)):
            main.resize(width, 600)
            let_lay_out()
            assert main.area.horizontalScrollBar().maximum() == 0, width
            assert name.width() == name_px
        profile = tmp_path / "H6.toml"
        main.resize(1366, 768)
        profile.write_text(walk.PROFILE, encoding="utf-8")
        one.settings.open_file(profile)
        main.resize(1024, 600)
        let_lay_out()
        assert main.area.horizontalScrollBar().maximum() == 0  # the pane asks for no room beside another view
